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
