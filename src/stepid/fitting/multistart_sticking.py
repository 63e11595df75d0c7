"""How each run began: where friction held it, with which phase. A scan past the separate minima, run by run."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.problem import PHASES, best_by_run, phase_rows

_COUNT = 17  # displacements tried a run
_REACH = 1.5  # times the largest displacement found so far, or what is left where there is none
_ROUNDS = 6
_ELSEWHERE = ((1.0, 0.0), (0.98, 1.0), (1.02, 1.0))
"""Factors of a dry effect's parameters, and of the displacements found: they lead out of minima that no scan leaves.

Displacements that are all as wrong as the rest position are such a one: no run leaves it alone.
"""
_GAIN = 1e-3  # relative decrease of the cost that is worth another round


def scan_starts(optimum: Optimum) -> Array:
    """Best starting displacement of each run at rest, or best phase, all else as it is: local parameters, shape (Q, R).

    Given the shared parameters the runs are independent, so that one batch tries the whole grid on every run. Each
    pattern of sticking has its own minimum; a descent from one start seldom finds the best.
    """
    problem, local = optimum.problem, optimum.local
    own = _held(problem)
    reach = _REACH * (float(np.abs(local[0, own]).max(initial=0.0)) or float(np.abs(optimum.residual).max()))
    moved = np.repeat(local[None], _COUNT, axis=0)
    moved[:, 0, own] = np.linspace(-reach, reach, _COUNT)[:, None]
    tried = [local[None], moved]
    for row in phase_rows(problem):
        turned = np.repeat(local[None], PHASES, axis=0)
        turned[:, row] += 2 * np.pi * np.arange(PHASES)[:, None] / PHASES
        tried.append(turned)
    best: Array = best_by_run(problem, optimum.shared[None], np.concatenate(tried)[None])[0]
    return best


def _held(problem: Problem) -> Array:
    """Runs at rest that need not have begun at zero."""
    held: Array = problem.active[0] & ~problem.records.moving
    return held


def other_sticking(optimum: Optimum, *, tolerance: float, iterations: int = 20) -> Optimum:
    """Fit again from the best starts of the runs, and from elsewhere, until nothing is gained.

    Parameters
    ----------
    optimum : Optimum
        Of a model with dry friction or play; others come back as they are.
    tolerance : float
        m², of the fits.
    iterations : int
        At most so many steps a fit.
    """
    problem = optimum.problem
    if not (_held(problem).any() or (phase_rows(problem) and any(e.reverses for e in problem.simulator.effects))):
        return optimum
    elsewhere, stuck = iter(_ELSEWHERE), False
    for _ in range(_ROUNDS):
        shared, local = optimum.shared, optimum.local if stuck else scan_starts(optimum)
        if np.array_equal(local, optimum.local):
            factors = next(elsewhere, None)
            if factors is None:
                break
            shared, local = shared.copy(), local.copy()
            kick, displaced = factors
            shared[_dry_values(problem)] *= kick
            local[0, _held(problem)] *= displaced
        found = minimize(problem, shared, local, tolerance=tolerance, iterations=iterations)
        if found is not None and found.cost < (1 - _GAIN) * optimum.cost:
            optimum, stuck = found, False
        else:
            stuck = True
    return optimum


def _dry_values(problem: Problem) -> list[int]:
    """Places of the dry effects' parameters among the shared ones."""
    values = zip(problem.simulator.effects, problem.layout.values, strict=True)
    return [i for effect, place in values if effect.dry for i in range(place.start, place.stop)]
