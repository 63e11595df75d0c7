"""A fit without one of its effects, or without a condition that differs from run to run, to first order."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stepid.core.base import Array, Index
from stepid.fitting.levenberg_marquardt import Optimum

OPEN = 1e-5  # singular value of a direction that the data leave open: no start moves along it


class Absent(NamedTuple):
    """What is taken away from a fit: an effect, whose global parameters `own` get `values`, or a per-run row."""

    own: slice = slice(0, 0)
    values: Array = np.zeros(0)
    row: int | None = None


def without(base: Optimum, own: slice, values: Array) -> tuple[Array, float]:
    """Take an effect away from a fit, the others moved to where that asks for them, to first order.

    Parameters
    ----------
    base : Optimum
    own : slice
        Place of the effect's parameters among the global ones.
    values : array
        At which it is as good as absent.

    Returns
    -------
    array, shape (P,)
        Global parameters.
    float
        Cost that would be left, m²; infinite where that plant cannot be simulated.
    """
    residual, jacobian, kept = linearized(base, Absent(own, values))
    shared = base.shared.copy()
    shared[own] = values
    if not np.isfinite(jacobian).all():
        return shared, np.inf
    size = np.linalg.norm(jacobian, axis=0)
    size[size == 0] = np.inf
    change = np.linalg.lstsq(jacobian / size, residual, rcond=OPEN)[0]
    left = residual - (jacobian / size) @ change
    shared[kept] += (change / size)[: kept.size]
    return np.clip(shared, base.problem.lower, base.problem.upper), float(left @ left)


def linearized(base: Optimum, absent: Absent | None) -> tuple[Array, Array, Index]:
    """Residual, derivatives by what may move, and which global parameters those are."""
    problem = base.problem
    residual, jacobian = problem.residual(base.solved), problem.jacobian(base.solved)
    place = np.flatnonzero(problem.free)
    if absent is None:
        return residual, jacobian, place
    shared, local = base.shared.copy(), base.local.copy()
    held, rows = np.zeros(place.size, dtype=bool), np.argwhere(problem.active)[:, 0]
    if absent.row is not None:
        local[absent.row] = 0.0
    else:
        own = absent.own
        shared[own] = np.clip(absent.values, problem.lower[own], problem.upper[own])  # a law may divide by some
        held = (place >= own.start) & (place < own.stop)
    reading = problem.simulator.readings(shared[None], local[None])[0]
    if not np.isfinite(reading).all():
        return residual, np.full_like(jacobian, np.nan), place
    kept = np.concatenate([~held, rows != absent.row])
    return problem.records.weighted(problem.records.position - reading), jacobian[:, kept], place[~held]
