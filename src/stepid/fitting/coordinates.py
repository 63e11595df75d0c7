"""Coordinates in which the steps of a fit are straight."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stepid.core.base import Array
from stepid.simulation.simulator import Solved

if TYPE_CHECKING:
    from stepid.fitting.levenberg_marquardt import Problem

_FOLDS = 5.0  # natural logarithm by which a step may change a coefficient


class Coordinates:
    """Where steps are straight: of a power of the speed, the logarithm of its force at the motion's own speed.

    The force at a speed that occurs hardly depends on the exponent, the coefficient does by orders of magnitude: in
    these two a fit creeps along a curved valley.
    """

    def __init__(self, problem: Problem, shared: Array, solved: Solved) -> None:
        places = zip(problem.simulator.effects, problem.layout.values, strict=True)
        powers = [(at.start + e.power[0], at.start + e.power[1]) for e, at in places if e.power is not None]
        self._powers = [(c, p) for c, p in powers if problem.free[c] and problem.free[p] and shared[c] > 0]
        self._problem = problem
        speed = float(np.sqrt(np.mean(solved.states[1] ** 2))) if self._powers else 1.0
        self._log = math.log(max(speed, 1e-300))

    def slopes(self, shared: Array, solved: Solved) -> tuple[Array, Array]:
        """Derivatives of the reading by these."""
        by_shared, by_local = solved.derivatives
        if self._powers:
            by_shared = by_shared.copy()
        for c, p in self._powers:
            by_shared[c] *= shared[c]
            by_shared[p] -= self._log * by_shared[c]
        return by_shared, by_local

    def steps(self, shared: Array) -> Array:
        """Steps of these, by which derivatives of the reading are told from differences."""
        out: Array = self._problem.simulator.steps(shared)[: shared.size].copy()
        for c, _ in self._powers:
            out[c] /= shared[c]
        return out

    def moved(self, shared: Array, delta: Array) -> Array:
        """Global parameters a step away, within their bounds."""
        problem, out = self._problem, shared.copy()
        out[problem.free] += delta
        out = np.clip(out, problem.lower, problem.upper)
        step = np.zeros(shared.size)
        step[problem.free] = delta
        for c, p in self._powers:
            change = step[c] - self._log * (out[p] - shared[p])
            out[c] = shared[c] * math.exp(min(max(change, -_FOLDS), _FOLDS))
        return out
