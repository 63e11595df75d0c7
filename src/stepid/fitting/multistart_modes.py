"""Own states that begin anywhere: they adapt first; a faint mode that its start moves may stand for a strong one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stepid.core.base import Array
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize

_STRONGER = 10.0  # times as strong: a mode of the same frequency that is heavier
_ADAPT = 3  # steps


def adapted(problem: Problem, shared: Array, local: Array) -> Array:
    """Local parameters, shape (Q, R), a few steps on, the shared ones held: from wrong own states these go astray."""
    held = replace(problem, free=np.zeros_like(problem.free))
    found = minimize(held, shared, local, iterations=_ADAPT)
    return found.local if found else local


def stronger(optimum: Optimum, *, tolerance: float, iterations: int = 20) -> Optimum:
    """Fit again with effects whose own states begin anywhere so many times as strong; the better one.

    As long as its own start moves it, a mode that hardly acts on the cart leaves as little as one that does: from there
    is no way downhill.

    Parameters
    ----------
    optimum : Optimum
        Of a model with such effects and runs that begin in motion; others come back as they are.
    tolerance : float
        m², of the fit, and by which it has to be better.
    iterations : int
        At most so many steps.
    """
    problem, shared, local = optimum.problem, optimum.shared.copy(), optimum.local.copy()
    of = problem.layout
    for effect, place, rows in zip(of.effects, of.values, of.effect_states, strict=True):
        if effect.n_extra and problem.active[rows].any():
            shared[place] = effect.faint(tuple(map(float, shared[place])), _STRONGER)
            local[rows] = 0.0
    if np.array_equal(shared, optimum.shared):
        return optimum
    begun = adapted(problem, shared, local)
    found = minimize(problem, shared, begun, tolerance=tolerance, iterations=iterations)
    return found if found is not None and found.cost < optimum.cost - tolerance else optimum
