"""Where friction held each run at its start: a scan past the separate minima, run by run."""

from __future__ import annotations

import numpy as np

from stepid._base import Array
from stepid.engine.least_squares import Optimum, minimize

_COUNT = 17  # displacements tried a run
_REACH = 1.5  # times the largest displacement found so far
_ROUNDS = 5
_KICKS = (0.98, 1.02)  # factors of the effects' parameters that lead out of a minimum where no displacement does
_GAIN = 1e-3  # relative decrease of the cost that is worth another round


def scan_displacements(optimum: Optimum) -> Array:
    """Best starting displacement of each run at rest, all else as it is, shape (Q, R) of the local parameters.

    Given the shared parameters the runs are independent, so that one batch tries the whole grid on every run. Each
    pattern of sticking has its own minimum; a descent from one displacement seldom finds the best.
    """
    problem = optimum.problem
    records = problem.simulator.records
    own = problem.active[0] & ~records.moving
    reach = _REACH * float(np.abs(optimum.local[0, own]).max(initial=0.0))
    tried = np.repeat(optimum.local[None], _COUNT + 1, axis=0)
    tried[:-1, 0, own] = np.linspace(-reach, reach, _COUNT)[:, None]  # the last copy stays as it was
    shared = np.repeat(optimum.shared[None], _COUNT + 1, axis=0)
    sim = problem.simulator
    states = sim.march(shared, tried)
    out = optimum.local.copy()
    reading = np.array([x[0] + sim.reading(optimum.shared, t) for x, t in zip(states, tried, strict=True)])
    with np.errstate(all="ignore"):
        square = records.weighted(records.position - reading) ** 2
        cost = np.nan_to_num(np.add.reduceat(square, records.first, axis=1), nan=np.inf)
    best = np.argmin(cost, axis=0)
    out[0, own] = tried[best, 0, np.arange(len(records.runs))][own]
    return out


def resettle(optimum: Optimum, *, tolerance: float, iterations: int = 20) -> Optimum:
    """Fit again from the best starting displacements, and from slightly other effects, until nothing is gained.

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
    if not np.any(problem.active[0] & ~problem.simulator.records.moving):
        return optimum
    kicks = iter(_KICKS)
    for _ in range(_ROUNDS):
        shared, local = optimum.shared, scan_displacements(optimum)
        if np.array_equal(local, optimum.local):
            kick = next(kicks, None)
            if kick is None:
                break
            shared = shared.copy()
            shared[problem.simulator.n_linear :] *= kick
        found = minimize(problem, shared, local, tolerance=tolerance, iterations=iterations)
        if found is not None and found.cost < (1 - _GAIN) * optimum.cost:
            optimum = found
    return optimum
