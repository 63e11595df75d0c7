"""How the models do on runs that their fit did not see."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.core.once import once
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.problem import build, fixes_mass
from stepid.simulation.records import Records

_RUNS = 3  # left out in turn
_UNSEEN = 1e-9  # square-root weight of samples that judge
_TOLD = 1e-3  # share of what a parameter moves, in power, by which a part of the records tells it


def qualifying(records: Records) -> list[int]:
    """Runs whose labels all occur in other runs, and without which the masses still differ, by index."""
    out = []
    for i in range(len(records.runs)):
        others = np.arange(len(records.runs)) != i
        known = all(np.any(labels[others] == labels[i]) for labels in (records.base, records.spring, records.damper))
        if not known:
            continue
        rest = records.subset([int(j) for j in np.flatnonzero(others)])
        same = (fixes_mass(rest) is None) == (fixes_mass(records) is None)
        if same and (rest.driven.any() or not records.driven.any()):
            out.append(i)
    return out


def judging(optimum: Optimum, first: float, part: float | None) -> list[int]:
    """Runs that a fit can be held against, by index: those that qualify, or that tell enough in their first part.

    Parameters
    ----------
    optimum : Optimum
    first, part : float
        As of `held_out_residuals`.
    """
    able = qualifying(optimum.problem.records)
    if able or part is None or len(optimum.problem.records.runs) < 2:
        return able
    return _judges(optimum, min(first, part))


def held_out_residuals(
    optimum: Optimum,
    *,
    tolerance: float,
    first: float = 1.0,
    part: float | None = None,
    among: Sequence[int] | None = None,
) -> dict[int, Array]:
    """Residuals [m] of up to three runs, each under a fit to the others; only the run's own parameters are refitted.

    Parameters
    ----------
    optimum : Optimum
        The fit to all runs: its effects, and where the other fits start.
    tolerance : float
        m², for the refits.
    first : float
        Share of the run left out on which its own parameters are estimated; if less than 1, the residual is that of
        the rest.
    part : float, optional
        Where no run qualifies: share of the run left out on which all is estimated that the others do not determine
        of the linear plant (a damper that no other run has, the mass of one of two); the residual is that of the rest.
        Runs are passed over whose first part does not tell it, or that alone tell a parameter of an effect.
    among : sequence of int, optional
        Runs of `judging` that may be left out, by index: those that another fit can be held against, too.

    Returns
    -------
    dict
        Run index to residual without wrong readings, shape (n,); empty where no run qualifies and `part` is not given.
    """
    records = optimum.problem.records
    able, told = judging(optimum, first, part) if among is None else list(among), {}
    if able and not qualifying(records):
        first = min(first, part or first)
        told = {i: _told_by(optimum.problem, i) for i in able}
    chosen = sorted({able[round(k)] for k in np.linspace(0, len(able) - 1, _RUNS)}) if able else []
    out: dict[int, Array] = {}
    for i in chosen:
        shared = _without(optimum, i, tolerance)
        if shared is None:
            continue
        own = records.subset([i])
        trusted = own.trusted
        seen_from = round(first * own.size) if first < 1 else 0
        if first < 1:
            own = own.reweighted(np.where(np.arange(own.size) < seen_from, own.weight, _UNSEEN))
        alone = build(own, optimum.problem.simulator.effects)
        alone = replace(alone, free=told.get(i, np.zeros_like(alone.free)), **_own(optimum, [i]))
        local = np.where(alone.active, optimum.local[:, [i]], 0.0)
        seen = minimize(alone, shared, local, tolerance=tolerance, iterations=15)
        if seen is not None:
            out[i] = seen.residual[seen_from:][trusted[seen_from:]]
    return out


def _told_by(problem: Problem, run: int) -> npt.NDArray[np.bool_]:
    """Free parameters of the linear plant that only one run determines, shape (P,): a mass also where it is assumed."""
    records, of = problem.records, problem.layout
    others = np.arange(len(records.runs)) != run
    rest = records.subset([int(j) for j in np.flatnonzero(others)])
    out = np.zeros(of.n_global, dtype=bool)
    for place, labels in ((of.base_mass, records.base), (of.stiffness, records.spring), (of.damping, records.damper)):
        out[place.start + labels[run]] = not np.any(labels[others] == labels[run])
    out[of.base_mass.start + records.base[run]] |= fixes_mass(rest) is not None and fixes_mass(records) is None
    out[of.force_gain] = problem.free[of.force_gain] and not rest.driven.any()
    return out


def _judges(optimum: Optimum, first: float) -> list[int]:
    """Runs whose first part tells what they alone determine, while the others tell all parameters of the effects."""
    problem = optimum.problem
    free = np.flatnonzero(problem.free)
    power = problem.jacobian(optimum.solved)[:, : free.size] ** 2
    whole = power.sum(axis=0)
    if not np.isfinite(whole).all():  # at a runaway's edge nothing is told
        return []
    out = []
    for run, piece in enumerate(problem.records.pieces()):
        own = power[piece]
        alone, seen = own.sum(axis=0), own[: round(first * len(own))].sum(axis=0)
        untold = (free >= problem.layout.linear.stop) & (whole - alone < _TOLD * whole)
        unseen = _told_by(problem, run)[free] & (seen < _TOLD * alone)
        if not (untold | unseen).any():
            out.append(run)
    return out


def _own(optimum: Optimum, runs: list[int]) -> dict[str, Any]:
    """Which parameters of some runs are free, and within which bounds."""
    active, most = optimum.problem.active, optimum.problem.most
    return {"active": active[:, runs], "most": None if most is None else most[:, runs]}


@once
def _without(optimum: Optimum, run: int, tolerance: float) -> Array | None:
    """Global parameters of the fit to all runs but one: they are asked for again.

    Parameters
    ----------
    optimum : Optimum
    run : int
        Index of the run left out.
    tolerance : float
        m².
    """
    records = optimum.problem.records
    others = [j for j in range(len(records.runs)) if j != run]
    problem = build(records.subset(others), optimum.problem.simulator.effects)
    problem = replace(problem, free=problem.free & optimum.problem.free, **_own(optimum, others))
    fitted = minimize(problem, optimum.shared, optimum.local[:, others], tolerance=tolerance, iterations=15)
    return None if fitted is None else fitted.shared
