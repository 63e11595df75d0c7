"""How the models do on runs that their fit did not see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stepid.core.base import Array
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.problem import build, fixes_mass
from stepid.simulation.records import Records

_RUNS = 3  # left out in turn
_UNSEEN = 1e-9  # square-root weight of samples that judge


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
        driven = bool(np.any(rest.volts)) or not np.any(records.volts)
        if same and driven:
            out.append(i)
    return out


def held_out_residuals(optimum: Optimum, *, tolerance: float, first: float = 1.0) -> dict[int, Array]:
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

    Returns
    -------
    dict
        Run index to residual, shape (n,); empty where no run qualifies.
    """
    records = optimum.problem.records
    able = qualifying(records)
    chosen = sorted({able[round(k)] for k in np.linspace(0, len(able) - 1, _RUNS)}) if able else []
    out: dict[int, Array] = {}
    effects = optimum.problem.simulator.effects
    for i in chosen:
        others = [j for j in range(len(records.runs)) if j != i]
        problem = build(records.subset(others), effects)
        problem = replace(problem, active=optimum.problem.active[:, others], free=problem.free & optimum.problem.free)
        fitted = minimize(problem, optimum.shared, optimum.local[:, others], tolerance=tolerance, iterations=15)
        if fitted is None:
            continue
        own = records.subset([i])
        seen_from = round(first * own.size) if first < 1 else 0
        if first < 1:
            own = own.reweighted(np.where(np.arange(own.size) < seen_from, own.weight, _UNSEEN))
        alone = build(own, effects)
        alone = replace(alone, free=np.zeros_like(alone.free), active=optimum.problem.active[:, [i]])
        local = np.where(alone.active, optimum.local[:, [i]], 0.0)
        seen = minimize(alone, fitted.shared, local, tolerance=tolerance, iterations=15)
        if seen is not None:
            out[i] = seen.residual[seen_from:]
    return out
