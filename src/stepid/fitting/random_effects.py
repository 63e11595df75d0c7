"""What it costs to let a condition differ from run to run: the runs are drawn from one distribution."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from stepid.core.base import Array, Index
from stepid.core.once import once
from stepid.fitting.deviations import SCATTER
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.mean_of_runs import centered
from stepid.simulation.layout import STARTS


def price_of_scatter(optimum: Optimum, counts: Array, variance: float) -> float:
    """Price of the deviations that are free in a fit, on the scale of BIC.

    They are random effects: normal, of a standard deviation τ that is fitted, about the plant, whose mean all runs are
    (a start time: about the command's). Integrated over them (Laplace), a run costs ln(1 + τ²I) + d²/τ², I being the
    inverse variance of its deviation d, and the width as much as a parameter fitted to so many runs. What has to differ
    more costs more: the ordinary price, ln n, does not ask by how much (Pinheiro & Bates, Mixed-Effects Models, 2000).

    Parameters
    ----------
    optimum : Optimum
    counts : array, shape (R,)
        Effective samples of each run.
    variance : float
        m², of what the best fit leaves.
    """
    active = optimum.problem.active[optimum.problem.layout.deviations]
    if not active.any():
        return 0.0
    deviations, information = _priced(optimum)
    effective = information * counts / max(variance, np.finfo(float).tiny)
    out = 0.0
    for own, values, told in zip(active, deviations, effective, strict=True):
        m = int(own.sum())
        if m:
            square = float(np.sum(values**2)) / m
            out += float(np.sum(np.log1p(square * told[own]))) + m + math.log(m)
    return out


@once
def _priced(optimum: Optimum) -> tuple[Array, Array]:
    """Deviations about the plant, and the mean square of what one of each changes, shapes (D, R)."""
    rows = optimum.problem.layout.deviations
    return centered(optimum).local[rows], _information(optimum)[rows]


def sizes_of_scatter(optimum: Optimum) -> dict[str, float]:
    """Standard deviation of what is free in the runs of a fit, about the plant, as it is priced, by kind."""
    of, active = optimum.problem.layout, optimum.problem.active
    counts = {kind: int(active[of.deviation(kind)].sum()) for kind in SCATTER}
    own = centered(optimum).local if any(counts.values()) else optimum.local
    return {kind: math.sqrt(float(np.sum(own[of.deviation(kind)] ** 2)) / m) for kind, m in counts.items() if m}


def _information(optimum: Optimum) -> Array:
    """Mean square over each run of the derivatives by its deviations, m² per unit², shape (Q, R)."""
    problem, solved = optimum.problem, optimum.solved
    records = problem.records
    active = np.zeros_like(problem.active)
    active[problem.layout.deviations] = problem.active[problem.layout.deviations]
    _, by_run = problem.simulator.derivatives(
        optimum.shared, optimum.local, solved.reading, np.zeros_like(problem.free), active, solved.states
    )
    with np.errstate(all="ignore"):
        square = records.weighted(by_run) ** 2
    seen = np.add.reduceat(np.nan_to_num(square, posinf=0.0), records.first, axis=1)
    out: Array = np.where(active, seen / np.add.reduceat(records.weight**2, records.first), 0.0)
    return out


def deviation_std(values: Mapping[str, Array], damper: Index) -> dict[str, float]:
    """Standard deviation of each kind over the runs that have it, in its unit.

    Parameters
    ----------
    values : mapping
        Of `stepid.fitting.deviations.scatter_values`.
    damper : array of int, shape (R,)
        Label of each run: damping is about as many means, what a start is off its rest by about none.
    """
    starts, out = {q.name for q in STARTS}, {}
    for kind, v in values.items():
        has = np.isfinite(v)
        means = 0 if kind in starts else np.unique(damper[has]).size if kind == "damping" else 1
        if has.sum() > max(means, 1):
            out[kind] = float(np.sqrt(np.sum(v[has] ** 2) / (has.sum() - means)))
    return out
