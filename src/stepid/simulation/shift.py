"""Readings of runs that start late: the simulated position between its samples, by cubic Hermite interpolation."""

from __future__ import annotations

from stepid.core.base import Array, Index
from stepid.simulation.compiled import compiled


@compiled
def shift(
    late: Array, run: Index, offset: Index, bounds: Index, time: Array, position: Array, velocity: Array,
    slope: bool, reading: Array,
) -> None:  # fmt: skip
    """Shift the readings of replicas, one run each, later in time.

    Before the first sample the position there holds; beyond the last one it goes on at its last velocity. What effects
    add to the reading follows the sensor's clock and stays.

    Parameters
    ----------
    late : array, shape (L,)
        s, by how much each replica's motion comes late.
    run : array of int, shape (L,)
        Record of each replica.
    offset : array of int, shape (L,)
        Where each replica's samples begin in `position`, `velocity` and `reading`.
    bounds : array of int, shape (R + 1,)
        Where each record's samples begin and end.
    time : array, shape (S,)
        s, of each sample.
    position, velocity : array, shape (N,)
        m and m/s, not shifted.
    slope : bool
        Whether the derivative of the reading by `late` [m/s] is written in the place of the reading.
    reading : array, shape (N,)
        m, changed.
    """
    for replica in range(late.size):
        first, at, by = bounds[run[replica]], offset[replica], late[replica]
        n = bounds[run[replica] + 1] - first
        if by == 0.0 and not slope:
            continue
        j = 0
        for i in range(n):
            t = time[first + i] - by
            while j < n - 2 and time[first + j + 1] <= t:
                j += 1
            span = time[first + j + 1] - time[first + j]
            s = (t - time[first + j]) / span
            x0, x1 = position[at + j], position[at + j + 1]
            v0, v1 = velocity[at + j], velocity[at + j + 1]
            if s < 0.0:
                x, v = x0, 0.0
            elif s > 1.0:
                x, v = x1 + v1 * (s - 1.0) * span, v1
            else:
                bend, twist = 3 * (x1 - x0) - (2 * v0 + v1) * span, 2 * (x0 - x1) + (v0 + v1) * span
                x = x0 + s * (v0 * span + s * (bend + s * twist))
                v = v0 + s * (2 * bend + 3 * s * twist) / span
            if slope:
                reading[at + i] = -v
            else:
                reading[at + i] += x - position[at + i]
