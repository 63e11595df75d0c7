"""Many plants at once over stretches without events: Dormand–Prince steps of order 5."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.simulation.law import Lanes, Law

_MOST_PIECES = 64
_A = (
    np.array([1 / 5]),
    np.array([3 / 40, 9 / 40]),
    np.array([44 / 45, -56 / 15, 32 / 9]),
    np.array([19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729]),
    np.array([9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656]),
)
_B = np.array([35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84])
_C = (0.2, 0.3, 0.8, 8 / 9, 1.0)


def _smooth(
    law: Law, table: Array, z: Array, elapsed: Array, length: Array, sign: Array, sides: Array, moving: Array, n: int
) -> Array:
    """Advance by `length` in `n` equal Dormand–Prince steps (order 5) with the regime held fixed."""
    h = length / n
    shape = (law.n_rates, z.shape[1])
    k = np.empty((6, *shape))
    flat = k.reshape(6, -1)
    held = not moving.all()
    lanes = Lanes(law, table, sides)
    z = z.copy()
    for i in range(n):
        start, first = elapsed + i * h, z.copy()
        law.relax(table, z, first, 0.0 * h, h)
        lanes.rates(first, sign, start, k[0])
        if held:
            k[0, :2] *= moving
        for stage in range(1, 6):
            y = z.copy()
            y[: law.n_rates] += h * (_A[stage - 1] @ flat[:stage]).reshape(shape)
            law.remember(table, z, y, sign)
            law.relax(table, z, y, _C[stage - 1] * h, h)
            lanes.rates(y, sign, start + _C[stage - 1] * h, k[stage])
            if held:
                k[stage, :2] *= moving
        y = z.copy()
        y[: law.n_rates] += h * (_B @ flat).reshape(shape)
        law.remember(table, z, y, sign)
        law.relax(table, z, y, h)
        z = y
    return z


def substeps(
    law: Law, table: Array, z: Array, elapsed: Array, length: Array, sign: Array, sides: Array, moving: Array
) -> Array:
    """Advance every lane by its own `length` with as many substeps as it needs."""
    needed = law.pieces(table, z, sign, elapsed, sides, length)
    needed = np.ceil(np.minimum(np.fmax(needed, 1.0), _MOST_PIECES if law.fineness >= 1 else 8.0))  # not a number: 1
    most = needed.max(initial=1.0)
    if most == needed.min(initial=most):
        return _smooth(law, table, z, elapsed, length, sign, sides, moving, int(most))
    out = np.empty_like(z)
    group = np.where(needed <= 1, 0, np.where(needed <= 4, 1, 2))  # few groups: each costs a round of calls
    for value in range(3):
        at = np.flatnonzero(group == value)
        if at.size:
            n = int(needed[at].max())
            out[:, at] = _smooth(
                law, table[:, at], z[:, at], elapsed[at], length[at], sign[at], sides[:, at], moving[at], n
            )
    return out
