"""What a fit's own parameters can do about its residual, to first order; the rest an effect must explain."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise

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

    @cached_property
    def _inverse(self) -> Array:
        """From what the parameters can do about a residual to their step, in units of the columns' sizes."""
        out: Array = np.linalg.pinv(self._upper, rcond=OPEN)
        return out

    def beyond(self, seen: Array) -> Array:
        """The part of some responses, shape (S,) or (S, k), that the fit's own parameters cannot follow."""
        out: Array = seen - self._basis @ (self._basis.T @ seen)
        return out

    def adapted(self, seen: Array) -> Array:
        """Parameters of the fit beside a response of shape (S,), within their bounds."""
        base, instead, kept = self._base, self._instead, self._kept
        rest = (self.left if instead is not None else self._residual) - seen
        change = self._inverse @ (self._basis.T @ rest) / self._size
        shared = base.shared.copy()
        if instead is not None and instead.row is None:
            shared[instead.own] = instead.values
        shared[kept] += change[: kept.size]
        out: Array = np.clip(shared, base.problem.lower, base.problem.upper)
        return out


def scaled_parts(beyond: Callable[[Array], Array], blocks: Sequence[Array]) -> list[tuple[Array, Array] | None]:
    """What `beyond` leaves of blocks of responses, shape (S, k) each, all at once: scaled to one, and their norms.

    Columns of one start differ in unit: no norm says what another is worth. It is infinite where rounding alone is
    left; None stands for a block of which nothing is.
    """
    if not blocks:
        return []
    whole = np.concatenate(blocks, axis=1)
    rounding = _ROUNDING * np.linalg.norm(whole, axis=0)
    whole = beyond(whole)
    scale = np.linalg.norm(whole, axis=0)
    told = np.where(scale <= rounding, np.inf, scale)
    with np.errstate(invalid="ignore"):  # of a runaway's response nothing is asked for
        whole /= told
    ends = np.cumsum([0, *(block.shape[1] for block in blocks)])
    return [
        (whole[:, a:b], told[a:b]) if np.isfinite(scale[a:b]).all() and scale[a:b].any() else None
        for a, b in pairwise(ends)
    ]
