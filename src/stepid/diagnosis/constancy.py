"""Whether an effect is the same whatever the added mass and the input: its parameters are those of one plant."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array, Index
from stepid.core.copies import are_repeats, group_of_each, have_one_label
from stepid.core.experiment import Experiment
from stepid.diagnosis.exchangeable import ALIKE
from stepid.fitting.deviations import SCATTER, applies, columns_by
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.simulation.records import Records

CONDITIONS = "added mass, labels and input"
"""What the parameters of a law that is another follow, as a state in words."""


def conditions_of(records: Records) -> Index:
    """Number of the condition of each run, shape (R,): those of one number have labels, added mass and input alike."""
    return group_of_each(records.runs, _in_one_condition)


def _in_one_condition(one: Experiment, other: Experiment) -> bool:
    """Tell whether two runs are repeats, or releases of one plant, however long they are."""
    if one.is_release and other.is_release:
        return have_one_label(one, other) and one.input_before == other.input_before
    return are_repeats(one, other, within=ALIKE)


def by_condition(optimum: Optimum, place: Index, jacobian: Array, records: Records) -> Array:
    """Change of the reading by each parameter of the effects in each condition alone.

    One law has one set of parameters: what a fit leaves must not ask for others in other conditions (Chow 1960,
    Econometrica 28, 591).

    Parameters
    ----------
    optimum : Optimum
    place : array of int
        Global parameter of each of the first columns of the Jacobian.
    jacobian : array, shape (S, columns)
        Weighted, by the fit's own parameters.
    records : Records
        Its samples.

    Returns
    -------
    array, shape (S, n)
        In the Jacobian's units; no columns where all runs have one condition, or there is no effect.
    """
    condition = conditions_of(records)[records.run]
    count = int(condition.max()) + 1
    effects = optimum.problem.layout.values
    columns = [c for c, p in enumerate(place) if any(own.start <= p < own.stop for own in effects)]
    if count < 2 or not columns:
        return np.zeros((records.size, 0))
    return np.column_stack([np.where(condition == k, jacobian[:, c], 0.0) for c in columns for k in range(count)])


def scatter_columns(optimum: Optimum) -> Array:
    """Change of the reading by what repeats may differ by, in each run, shape (S, n): no law has to explain that."""
    problem = optimum.problem
    free = np.zeros_like(problem.active)
    for kind in SCATTER:
        free[problem.layout.deviation(kind)] |= applies(problem, kind)
    return columns_by(optimum, np.argwhere(free))
