"""Where friction held each run, with which phase it began, when it stopped: past the separate minima."""

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


def other_turns(optimum: Optimum, *, tolerance: float, iterations: int = 20) -> Optimum:
    """Fit again as if runs stopped a half swing or two earlier or later, until nothing is gained.

    Dry friction takes as much of a free swing's amplitude in each half swing (4 F/k a cycle), until it holds the cart:
    a stop after n of them says that it is about 1/n of the most that would let the cart go. Each whole number has a
    minimum of its own, and no descent leads from one to the next.

    Parameters
    ----------
    optimum : Optimum
        Of a model with dry friction; others come back as they are, and so does one in which no run stops.
    tolerance : float
        m², of the fits.
    iterations : int
        At most so many steps a fit.
    """
    problem, dry = optimum.problem, _dry_values(optimum.problem)
    if not dry:
        return optimum
    begun = None
    for _ in range(_ROUNDS):
        if optimum is begun or not (n := _half_swings(optimum)):
            break
        begun = optimum
        for other in (n + more for more in (-2, -1, 1, 2) if n + more > 0):
            shared = begun.shared.copy()
            shared[dry] *= n / other
            found = minimize(problem, shared, begun.local, tolerance=tolerance, iterations=iterations)
            if found is not None and found.cost < (1 - _GAIN) * optimum.cost:
                optimum = found
    return optimum


def _half_swings(optimum: Optimum) -> float:
    """Half swings to a stop, the mean of all stops in the fitted motion; 0 where no run stops."""
    turns = stops = 0
    for piece in optimum.problem.records.pieces():
        velocity = optimum.solved.states[1, piece]
        moving = velocity != 0
        stops += int(np.sum(moving[:-1] & ~moving[1:]))
        turns += int(np.sum(np.diff(np.sign(velocity[moving])) != 0))
    return 1 + turns / stops if stops else 0.0


def _dry_values(problem: Problem) -> list[int]:
    """Places of the dry effects' parameters among the shared ones."""
    values = zip(problem.simulator.effects, problem.layout.values, strict=True)
    return [i for effect, place in values if effect.dry for i in range(place.start, place.stop)]
