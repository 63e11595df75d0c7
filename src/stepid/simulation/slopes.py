"""Derivatives of the readings: from simulated copies of the plant, and from other derivatives."""

from __future__ import annotations

from typing import Any

from stepid.simulation.compiled import compiled

Array = Any  # numba knows the types


@compiled
def slopes(moved: Array, reading: Array, steps: Array, run: Array, offset: Array, bounds: Array) -> None:
    """Turn the readings of replicas, each of a plant with one parameter moved, into derivatives.

    Parameters
    ----------
    moved : array, shape (N,)
        m, changed into derivatives.
    reading : array, shape (S,)
        m, of the plant itself.
    steps : array, shape (L,)
        By how much each replica's parameter is moved.
    run, offset : arrays of int, shape (L,)
        Record of each replica, and where its samples begin in `moved`.
    bounds : array of int, shape (R + 1,)
        Where each record's samples begin and end.
    """
    for replica in range(run.size):
        first, at = bounds[run[replica]], offset[replica]
        for i in range(bounds[run[replica] + 1] - first):
            moved[at + i] = (moved[at + i] - reading[first + i]) / steps[replica]


@compiled
def _weigh(weight: Array, powers: Array, shared: Array, own: Array, touched: Array, asked: Array) -> bool:
    """Write what each parameter weighs in one unit of one run; True where one that does is not asked for."""
    missing, n = False, shared.size
    for p in range(asked.size):
        value = own[p - n] if p >= n else shared[p] if touched[p] else 0.0
        weight[p] = powers[p] * value
        missing |= weight[p] != 0.0 and not asked[p]
    return missing


@compiled
def follow_units(
    powers: Array,
    shared: Array,
    local: Array,
    touched: Array,
    asked: Array,
    pushed: Array,
    gain: int,
    base: Array,
    spring: Array,
    mass: Array,
    notable: float,
    told: bool,
    flow: bool,
    spared: Array,
    row: Array,
    weight: Array,
) -> None:
    """Tell which derivatives follow from others, see `stepid.simulation.homogeneity`.

    Parameters
    ----------
    powers : array, shape (3, P + Q)
        Of length, time and mass in each parameter.
    shared, local : arrays, shape (P,) and (Q, R)
    touched, asked : arrays of bool, shape (P, R) and (P + Q, R)
        Whether a global parameter enters a run, and whether a derivative is wanted.
    pushed : array, shape (R,)
        V, largest input.
    gain : int
    base, spring : arrays of int, shape (R,)
        Parameters by their places.
    mass : array, shape (R,)
        kg, that moves.
    notable : float
        m, of the motion that a parameter must make up.
    told, flow : bool
        Whether units tell how the laws scale, and whether derivatives by times may follow.
    spared, row, weight
        Written, see `stepid.simulation.homogeneity.Following`: false, -1 and zero before.
    """
    n = shared.size
    for r in range(pushed.size):
        driven = pushed[r] > 0.0
        enters = touched[:, r].copy()
        enters[gain] &= driven
        spared[gain, r] = not driven  # without input it does nothing
        by_gain = asked[gain, r] and driven and abs(shared[gain]) * pushed[r] > notable * abs(shared[spring[r]])
        by_start = asked[n, r] and abs(local[0, r]) > notable
        by_spring = asked[spring[r], r] and flow and not driven
        sources = (
            gain if by_gain else n if by_start else -1,
            spring[r] if by_spring else -1,
            base[r] if asked[base[r], r] else -1,
        )
        for unit in range(3):
            missing = _weigh(weight[unit, r], powers[unit], shared, local[:, r], enters, asked[:, r])
            if told and not missing and sources[unit] >= 0:
                row[unit, r] = sources[unit]
                spared[sources[unit], r] = True
        weight[2, r, base[r]] = mass[r]


@compiled
def follow(out: Array, reading: Array, velocity: Array, time: Array, bounds: Array, row: Array, weight: Array) -> None:
    """Write the derivatives that follow from others.

    Parameters
    ----------
    out : array, shape (P + Q, S)
        Derivatives of the reading, changed.
    reading, velocity : arrays, shape (S,)
        m and m/s; without derivatives by times the velocity is not looked at.
    time : array, shape (S,)
        s.
    bounds : array of int, shape (R + 1,)
        Where each record's samples begin and end.
    row, weight
        See `stepid.simulation.homogeneity.Following`.
    """
    for unit in range(3):
        for r in range(bounds.size - 1):
            target, first, end = row[unit, r], bounds[r], bounds[r + 1]
            if target < 0:
                continue
            for i in range(first, end):
                out[target, i] = 0.0
                if unit == 0:
                    out[target, i] = reading[i]
                elif unit == 1:
                    out[target, i] = -(time[i] - time[first]) * velocity[i]
            for j in range(out.shape[0]):
                share = weight[unit, r, j]
                if j != target and share != 0.0:
                    for i in range(first, end):
                        out[target, i] -= share * out[j, i]
            for i in range(first, end):
                out[target, i] /= weight[unit, r, target]
