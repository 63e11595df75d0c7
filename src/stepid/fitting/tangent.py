"""What a fit's own parameters can do about its residual, to first order; the rest an effect must explain."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stepid.core.base import Array
from stepid.fitting.absent import OPEN, Absent, linearized
from stepid.fitting.levenberg_marquardt import Optimum

_ROUNDING = 1e-12  # of a response, what is left of it by rounding alone


class Tangent:
    """What a fit's own parameters can do about its residual, to first order.

    Parameters
    ----------
    base : Optimum
    instead : Absent, optional
        What is taken away from the fit.
    """

    def __init__(self, base: Optimum, instead: Absent | None = None) -> None:
        self._base, self._instead = base, instead
        self._residual, jacobian, self._kept = linearized(base, instead)
        self.directed = bool(np.isfinite(jacobian).all())  # a fit at a runaway's edge gives no direction
        if not self.directed:
            return
        self._size = np.linalg.norm(jacobian, axis=0)
        self._size[self._size == 0] = np.inf
        self._basis, self._upper = np.linalg.qr(jacobian / self._size)
        self.left = self.beyond(self._residual) if instead is not None else self._residual
        self.samples = float(self.left.size - self._basis.shape[1])

    def beyond(self, seen: Array) -> Array:
        """The part of some responses, shape (S,) or (S, k), that the fit's own parameters cannot follow."""
        out: Array = seen - self._basis @ (self._basis.T @ seen)
        return out

    def adapted(self, seen: Array) -> Array:
        """Parameters of the fit beside a response of shape (S,), within their bounds."""
        base, instead, kept = self._base, self._instead, self._kept
        rest = (self.left if instead is not None else self._residual) - seen
        change = np.linalg.lstsq(self._upper, self._basis.T @ rest, rcond=OPEN)[0] / self._size
        shared = base.shared.copy()
        if instead is not None and instead.row is None:
            shared[instead.own] = instead.values
        shared[kept] += change[: kept.size]
        out: Array = np.clip(shared, base.problem.lower, base.problem.upper)
        return out


def scaled_parts(beyond: Callable[[Array], Array], blocks: Sequence[Array]) -> list[tuple[Array, Array] | None]:
    """What `beyond` leaves of blocks of responses, shape (S, k) each, all at once; each as `scaled_to_one` does."""
    if not blocks:
        return []
    ends, whole = np.cumsum([block.shape[1] for block in blocks])[:-1], np.concatenate(blocks, axis=1)
    rounding = _ROUNDING * np.linalg.norm(whole, axis=0)
    parts = np.split(beyond(whole), ends, axis=1), np.split(rounding, ends)
    return [scaled_to_one(part, least) for part, least in zip(*parts, strict=True)]


def scaled_to_one(columns: Array, least: Array) -> tuple[Array, Array] | None:
    """Columns scaled to a norm of one, and their norms, infinite below the `least`; None where nothing is left.

    Columns of one start differ in unit: no norm says what another is worth.
    """
    scale = np.linalg.norm(columns, axis=0)
    if not np.isfinite(scale).all() or scale.max(initial=0.0) <= 0:
        return None
    scale[scale <= least] = np.inf
    return columns / scale, scale
