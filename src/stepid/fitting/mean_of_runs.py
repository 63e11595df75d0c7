"""The plant as the mean of its runs, where conditions differ from run to run, and how sure that mean is."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr, stdtrit

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.deviations import SCATTER, Mask, applies
from stepid.fitting.levenberg_marquardt import Optimum, Problem

NORMAL = 1.96
"""Standard deviations of half a 95 % interval."""
_SHARED = 3.0  # standard deviations of start times about their mean, from which on the mean is what matters


class Common(NamedTuple):
    """What a deviation changes that is the plant's: the plant is the mean of its runs.

    Parameters
    ----------
    kind : str
    parameters : tuple of int
        Shared parameters that it changes.
    runs : array of bool, shape (R,)
        Runs in which they act and the deviation makes sense.
    """

    kind: str
    parameters: tuple[int, ...]
    runs: Mask

    def slopes(self, optimum: Optimum) -> Array:
        """Change of each parameter by a deviation of one: a start time adds to a delay, the others are relative."""
        values = optimum.shared[list(self.parameters)]
        return np.ones_like(values) if self.kind == "start_time" else values


def common(problem: Problem) -> tuple[Common, ...]:
    """Shared parameters whose values in single runs the free deviations of a fit change."""
    of, records = problem.layout, problem.records
    out = []
    for kind in (*SCATTER, "stiffness"):
        if not problem.active[of.deviation(kind)].any():
            continue
        use = applies(problem, kind)
        labels = {"damping": records.damper, "stiffness": records.spring}.get(kind)
        if labels is None:
            places = _changed(problem, kind)
            out.append(Common(kind, tuple(k for k in places if problem.free[k]), use))
            continue
        first = int(of.damping.start if kind == "damping" else of.stiffness.start)
        out += [Common(kind, (first + int(g),), use & (labels == g)) for g in np.unique(labels[use])]
    return tuple(c for c in out if c.parameters)


def _changed(problem: Problem, kind: str) -> tuple[int, ...]:
    of = problem.layout
    if kind == "gain":
        return (of.force_gain,)
    own = zip(of.effects, of.values, strict=True)
    if kind == "friction":
        dry = [(e, place) for e, place in own if e.dry]
        return tuple(int(place.start) + i for e, place in dry for i, q in enumerate(e.parameters) if q.force)
    return tuple(int(place.start) for e, place in own if type(e).delay is not Effect.delay)


def centered(optimum: Optimum) -> Optimum:
    """The same fit with the deviations about their mean: one run had stood for the plant, whose mean all runs are."""
    groups = common(optimum.problem)
    if not groups:
        return optimum
    shared, local = optimum.shared.copy(), optimum.local.copy()
    for own in groups:
        row = optimum.problem.layout.deviation(own.kind)
        mean = float(local[row, own.runs].mean())
        shared[list(own.parameters)] += mean * own.slopes(optimum)
        local[row, own.runs] -= mean
        if own.kind != "start_time":
            local[row, own.runs] /= 1.0 + mean
    return replace(optimum, shared=shared, local=local)


def starts_late(optimum: Optimum) -> bool:
    """Tell whether runs whose start times are free all start as late: what they share is a delay, no scatter.

    By more than their standard deviation, and more than chance does to the mean of so few (Student's t).
    """
    problem = optimum.problem
    row = problem.layout.deviation("start_time")
    late = optimum.local[row, problem.active[row]]
    if late.size < 2 or _changed(problem, "start_time"):
        return False
    chance = stdtrit(late.size - 1, ndtr(_SHARED)) / math.sqrt(late.size - 1)
    return bool(abs(late.mean()) > max(_SHARED, chance) * late.std())


def mean_of_runs(optimum: Optimum) -> Array:
    """Derivatives of the shared parameters' means over the runs by all free parameters, shape (free shared, free)."""
    problem = optimum.problem
    column = np.cumsum(problem.free) - 1
    n = int(problem.free.sum())
    own_column = n + np.cumsum(problem.active).reshape(problem.active.shape) - 1
    out = np.eye(n, n + int(problem.active.sum()))
    for own in common(problem):
        row = problem.layout.deviation(own.kind)
        free = own.runs & problem.active[row]
        for k, slope in zip(own.parameters, own.slopes(optimum), strict=True):
            out[column[k], own_column[row, free]] += slope / own.runs.sum()
    return out


def between_runs(optimum: Optimum) -> tuple[Array, Array]:
    """Covariance of the shared parameters as means of runs that differ, and the quantile of its 95 % interval.

    The runs are a sample of those that the plant could make. Student's quantile for as many as there are.
    """
    problem = optimum.problem
    column = np.cumsum(problem.free) - 1
    n = int(problem.free.sum())
    out, quantile = np.zeros((n, n)), np.full(n, NORMAL)
    groups = common(problem)
    for kind in {own.kind for own in groups}:
        row, alike = problem.layout.deviation(kind), [own for own in groups if own.kind == kind]
        values = [optimum.local[row, own.runs] for own in alike]
        left = sum(v.size - 1 for v in values)
        if left < 1:
            continue
        variance = sum(float(np.sum((v - v.mean()) ** 2)) for v in values) / left
        for own in alike:
            slope = np.zeros(n)
            slope[column[list(own.parameters)]] = own.slopes(optimum)
            out += np.outer(slope, slope) * variance / own.runs.sum()
            quantile[slope != 0] = np.maximum(quantile[slope != 0], float(stdtrit(left, 0.975)))
    return out, quantile
