"""Whether what runs differ by is drawn at random: a deviation that goes with a condition is a law, no scatter."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc, ndtri

from stepid.core.base import Array, Index
from stepid.core.copies import group_of_each
from stepid.core.experiment import Experiment
from stepid.fitting.deviations import SCATTER, applies, columns_by, scatter_values
from stepid.fitting.levenberg_marquardt import Optimum

ALIKE = 0.02
"""Relative, by which inputs of one size differ, and of its range an input that is measured."""
_LEAST = 1e-300  # probability, below which all are alike


class Condition(NamedTuple):
    """A condition that a deviation goes with: the `kind` of deviation, the condition in words, and `beyond` chance.

    `beyond` is a normal deviate as rare as the F ratio of what lies between the conditions to what lies within them.
    """

    kind: str
    words: str
    beyond: float


def followed_condition(optimum: Optimum, floor: float) -> Condition | None:
    """Find the condition that the deviations of a fit follow most: the input, its size, the added mass or the spring.

    Deviations are random effects: exchangeable, drawn for each run from one distribution whatever its conditions. A
    one-way analysis of variance says whether they are (Fisher 1925, Statistical Methods for Research Workers, chapter
    7). Those of the damping are compared within each damper label, which has a damping of its own. Runs count by how
    well they tell their deviation.

    Parameters
    ----------
    optimum : Optimum
    floor : float
        RMS noise, m.

    Returns
    -------
    Condition or None
        None where nothing is free in the runs.
    """
    problem = optimum.problem
    records = problem.records
    values = {kind: v for kind, v in scatter_values(optimum).items() if kind in SCATTER}
    found = []
    for kind, deviation in values.items():
        used = np.flatnonzero(np.isfinite(deviation) & applies(problem, kind))
        row = problem.layout.deviation(kind)
        slopes = columns_by(optimum, np.column_stack([np.full(used.size, row), used]))
        error = floor**2 / np.maximum((slopes**2).sum(axis=0), math.ulp(0.0))
        weight = 1.0 / (np.mean(deviation[used] ** 2) + error)
        apart = records.damper[used] if kind == "damping" else np.zeros(used.size, dtype=np.intp)
        for words, alike in _CONDITIONS.items():
            group = group_of_each(records.runs, alike)[used]
            found.append(Condition(kind, words, _beyond(deviation[used], weight, apart, group)))
    return max(found, key=lambda one: one.beyond, default=None)


def _beyond(values: Array, weight: Array, apart: Index, group: Index) -> float:
    """Normal deviate as rare as the F ratio of one-way analysis of variance, -inf where there is nothing to compare."""
    within, every = _left(values, weight, [*zip(apart, group, strict=True)]), _left(values, weight, [*apart])
    more, spare = every[1] - within[1], within[1]
    if not (more > 0 and spare > 0 and within[0] > 0):
        return -math.inf
    ratio = (every[0] - within[0]) / more / (within[0] / spare)
    return float(-ndtri(max(fdtrc(more, spare, ratio), _LEAST)))


def _left(values: Array, weight: Array, labels: list[object]) -> tuple[float, int]:
    """Weighted square of what values of one label differ by, and its degrees of freedom."""
    known = {label: [i for i, other in enumerate(labels) if other == label] for label in labels}
    mean = {label: np.average(values[own], weights=weight[own]) for label, own in known.items()}
    rest = values - np.array([mean[label] for label in labels])
    return float(np.sum(weight * rest**2)), values.size - len(known)


def push(run: Experiment) -> float:
    """The input's largest change from before the record, V, with its sign."""
    change = run.input - run.input_before
    return float(change[np.argmax(np.abs(change))])


_CONDITIONS: dict[str, Callable[[Experiment, Experiment], bool]] = {
    "the direction of the input": lambda a, b: bool(np.sign(push(a)) == np.sign(push(b))),
    "the size of the input": lambda a, b: math.isclose(abs(push(a)), abs(push(b)), rel_tol=ALIKE),
    "the added mass": lambda a, b: a.added_mass == b.added_mass,
    "the spring": lambda a, b: a.spring == b.spring,
}
