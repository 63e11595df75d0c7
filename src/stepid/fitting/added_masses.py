"""The known added masses as what they are: known within their uncertainty, one error of each weight for all runs."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.mass_offset import weight_spread
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.simulation.records import Records
from stepid.simulation.simulator import Simulator

_LIGHTEST = 0.1  # of a run's mass: its weights are not so far off


class WeightErrors(NamedTuple):
    """Errors of the added masses as independent parts of unit variance.

    Parameters
    ----------
    spread : array, shape (R, K)
        kg, of each run's added mass for each part.
    found : array, shape (K,)
        What a fit found so far.
    """

    spread: Array
    found: Array


def weight_errors(records: Records) -> WeightErrors:
    """Parts of the added masses' errors: weights are added one on another, so that a heavier run carries the lighter's.

    Each step from one added mass to the next has its own error, as in `stepid.Campaign.mass_offsets`; none where no two
    runs differ in mass, for then every parameter is per unit mass.
    """
    known = np.array([run.added_mass for run in records.runs])
    steps = np.unique(known[known > 0])
    if not records.weight_uncertainty > 0 or not _differ(records, known):
        steps = steps[:0]
    sizes = np.diff(steps, prepend=0.0)
    parts = np.array([weight_spread(float(size), records.weight_uncertainty) for size in sizes])
    spread = (known[:, None] >= steps) * parts
    off = records.added_mass - known
    reached = np.array([off[np.argmax(known == step)] for step in steps])
    found = np.diff(reached, prepend=0.0) / np.where(parts > 0, parts, 1.0)
    return WeightErrors(spread, found)


def _differ(records: Records, known: Array) -> bool:
    return any(np.ptp(known[records.base == b]) > 0 for b in range(len(records.bases)) if (records.base == b).any())


def with_added_masses(records: Records, found: Array) -> Records:
    """Return the records with the added masses of errors that a fit found, shape (K,); see `WeightErrors`."""
    known = np.array([run.added_mass for run in records.runs])
    return replace(records, added_mass=known + weight_errors(records).spread @ found)


def moved(optimum: Optimum, records: Records, shared: Array, local: Array) -> Optimum | None:
    """Simulate an optimum's plant nearby, with other added masses; None where that is no plant or runs away.

    The derivatives are kept: so near by they are the same.
    """
    problem = optimum.problem
    shared = np.clip(shared, problem.lower, problem.upper)
    mass = problem.layout.mass(shared) + records.added_mass - problem.records.added_mass
    if np.any(mass < _LIGHTEST * problem.layout.mass(optimum.shared)):
        return None
    sim = problem.simulator
    sim = Simulator(records, sim.effects, sim.tolerance, workers=sim.workers, patience=sim.patience)
    problem = replace(problem, simulator=sim)
    solved, known = problem.solve(shared, local), optimum.solved.derivatives
    if solved is None:
        return None
    cost = problem.weigh(solved)[1]
    near = replace(solved, derive=lambda: known)
    return replace(optimum, problem=problem, shared=shared, local=local, solved=near, cost=cost)
