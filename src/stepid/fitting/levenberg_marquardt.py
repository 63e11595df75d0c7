"""Levenberg–Marquardt over all records, rest positions projected out, a runaway a rejected step.

It stands in the place of scipy's `least_squares` because it ends at the same cost in less time: 1.5 times as fast
in all and 1.1 to 1.7 times by effect on four runs (benchmarks/least_squares.py). Its time is proportional to the number
of runs, whose own parameters it eliminates run by run; a dense Jacobian's is not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array, Index
from stepid.fitting.coordinates import Coordinates
from stepid.fitting.damped_step import Columns, Linearized, Step
from stepid.simulation.layout import ParameterLayout
from stepid.simulation.records import Records
from stepid.simulation.simulator import STEEPEST, Simulator, Solved

_CRAWL = 5  # steps that together gain less than the tolerance: the rest is not worth its time
_MOST_DAMPING = 1e12
_GROWTH = 4.0  # of the damping after a step that failed; twice as much after each further one
_HOPE = 4.0  # times what a step promises, that each of those to come may bring: in valleys the promise grows


@dataclass(frozen=True)
class Problem:
    """What is fitted: which global and per-run parameters are free, and their bounds: `most` is that of a run's own."""

    simulator: Simulator
    free: npt.NDArray[np.bool_]
    lower: Array
    upper: Array
    active: npt.NDArray[np.bool_]  # (Q, R)
    most: Array | None = None  # (Q, R)

    @property
    def records(self) -> Records:
        """What is fitted to."""
        return self.simulator.records

    @property
    def layout(self) -> ParameterLayout:
        """Where each parameter stands."""
        return self.simulator.layout

    def residual(self, solved: Solved) -> Array:
        """Measured minus simulated, each run's rest position fitted, times the weights, m."""
        return self.weigh(solved)[0]

    def weigh(self, solved: Solved) -> tuple[Array, float]:
        """The residual, and its square [m²]."""
        from stepid.simulation.triangles import weigh

        r = self.records
        out = np.empty(r.size)
        cost = weigh(r.position, solved.reading, r.weight, r.bounds, out)
        return out, cost

    def solve(self, shared: Array, local: Array) -> Solved | None:
        """Simulate all records, ready for the derivatives by what is free; None where the plant runs away."""
        solved = self.simulator.solve(shared, local)
        if solved is None:
            return None
        here = shared.copy(), local.copy(), solved.reading, self.free, self.active, solved.states
        return replace(solved, derive=partial(self.simulator.derivatives, *here))

    def blocks(self, solved: Solved) -> Iterator[tuple[slice, Index, Array]]:
        """Each run's samples, its columns of the Jacobian (its own, then the global ones), and these, row by row."""
        (shared, local), free, weight = solved.derivatives, np.flatnonzero(self.free), self.records.weight
        place = free.size - 1 + np.cumsum(self.active).reshape(self.active.shape)
        for run, piece in enumerate(self.records.pieces()):
            own, w = np.flatnonzero(self.active[:, run]), weight[piece]
            rows = np.concatenate([local[own, piece], shared[free, piece]])
            with np.errstate(all="ignore"):
                rows -= (rows @ (w**2 / np.sum(w**2)))[:, None]
                rows *= w
                rows[~(np.abs(rows) < STEEPEST)] = np.inf
            yield piece, np.append(place[own, run], np.arange(free.size)), rows

    def jacobian(self, solved: Solved) -> Array:
        """Derivative of the simulated reading by the free parameters, shape (S, columns); ±inf at a runaway's edge."""
        out = np.zeros((int(self.free.sum() + self.active.sum()), self.records.size))
        for piece, columns, rows in self.blocks(solved):
            out[columns, piece] = rows
        return out.T


@dataclass(frozen=True, eq=False)
class Optimum:
    """Where a fit ended."""

    problem: Problem
    shared: Array
    local: Array
    solved: Solved
    cost: float  # sum of squared residuals, m²
    converged: bool
    iterations: int

    @cached_property
    def residual(self) -> Array:
        """Measured minus simulated, unweighted, m, shape (S,)."""
        r = self.problem.records
        out = r.centered(r.position - self.solved.reading)
        out.setflags(write=False)
        return out

    @cached_property
    def rms(self) -> float:
        """Root mean square of the unweighted residual, m, of the readings that count."""
        return float(np.sqrt(np.mean(self.residual[self.problem.records.trusted] ** 2)))


def minimize(
    problem: Problem,
    shared: Array,
    local: Array,
    *,
    tolerance: float = 0.0,
    iterations: int = 40,
    aim: float = np.inf,
    solved: Solved | None = None,
) -> Optimum | None:
    """Fit the free parameters by Levenberg–Marquardt on QR factorizations, run by run.

    Parameters
    ----------
    problem : Problem
    shared : array, shape (P,)
    local : array, shape (Q, R)
    tolerance : float
        m², predicted decrease of the cost at which to stop.
    iterations : int
        At most so many accepted steps, and three times as many tries.
    aim : float
        m², cost that makes a difference: where the steps left do not promise it, the fit ends, not converged.
    solved : Solved, optional
        The start, simulated by this problem, where that is known.

    Returns
    -------
    Optimum or None
        None where the start itself cannot be simulated.
    """
    shared, local = np.clip(shared, problem.lower, problem.upper), _within(problem, local)
    solved = solved or problem.solve(shared, local)
    if solved is None:
        return None
    at = _Descent(problem, shared, local, solved)
    for _ in range(3 * iterations):
        if at.accepted >= iterations or not at.linearize():
            break
        step = at.step()
        if step.promised <= max(tolerance, 1e-10 * at.cost):
            at.converged = True
            break
        if at.growth == _GROWTH and at.cost - _HOPE * step.promised * (iterations - at.accepted) > aim:
            break
        at.take(step, tolerance)
        if at.converged:
            break
    return Optimum(problem, at.shared, at.local, at.solved, at.cost, at.converged, at.accepted)


class _Descent:
    """Where a fit is by now, and how far its next step may go."""

    def __init__(self, problem: Problem, shared: Array, local: Array, solved: Solved) -> None:
        self.problem, self.shared, self.local, self.solved = problem, shared, local, solved
        self.residual, self.cost = problem.weigh(solved)
        self.converged, self.accepted = False, 0
        self.growth, self._damping = _GROWTH, 1e-4
        self._costs, self._columns = [self.cost], Columns(problem)
        self._linearized: Linearized | None = None

    def linearize(self) -> bool:
        """Linearize about where the fit is, where that is not done; False at a runaway's edge: nothing to follow."""
        if self._linearized is None:
            self._inner = Coordinates(self.problem, self.shared, self.solved)
            slopes, steps = self._inner.slopes(self.shared, self.solved), self._inner.steps(self.shared)
            self._linearized = Linearized(self.problem, self._columns, slopes, self.residual, steps)
            if not self._linearized.finite:
                return False
            self._blocked = _blocked(self.problem, self.shared, self._linearized.pull)
        return True

    def step(self) -> Step:
        """The next step, in the coordinates of the last linearization; what sits at a bound stays there."""
        assert self._linearized is not None
        none = np.zeros_like(self.problem.active)
        step = self._linearized.step(self._damping, self._blocked, none)
        held = _held(self.problem, self.local, step.local)
        return self._linearized.step(self._damping, self._blocked, held) if held.any() else step

    def take(self, step: Step, tolerance: float) -> None:
        """Go there if that leaves less, or shorten the next step."""
        shared = self._inner.moved(self.shared, step.inner)
        local = _within(self.problem, self.local + step.local)
        solved = self.problem.solve(shared, local)
        residual, cost = self.problem.weigh(solved) if solved is not None else (self.residual, np.inf)
        if solved is None or not cost < self.cost:
            self._damping, self.growth = max(self._damping * self.growth, 1e-3), self.growth * 2
            self.converged = self._damping > _MOST_DAMPING
            return
        gained = self.cost - cost
        kept = gained / step.promised
        self._damping *= max(1 / 10, 1 - (2 * min(kept, 1.0) - 1) ** 3)
        self._damping, self.growth = max(self._damping, 1e-12), _GROWTH
        self.accepted += 1
        self._costs.append(cost)
        # along a curved valley every step promises more than it brings
        slow = self.accepted > _CRAWL and self._costs[-1 - _CRAWL] - cost <= tolerance
        self.converged = slow or (gained <= max(tolerance, 1e-9 * self.cost) and kept > 0.25)
        self.shared, self.local, self.solved = shared, local, solved
        self.residual, self.cost, self._linearized = residual, cost, None


def _within(problem: Problem, local: Array) -> Array:
    """Per-run parameters within their bounds."""
    return local if problem.most is None else np.clip(local, -problem.most, problem.most)


def _held(problem: Problem, local: Array, step: Array) -> npt.NDArray[np.bool_]:
    """Per-run parameters that sit at a bound that their step pushes against, shape (Q, R)."""
    if problem.most is None:
        return np.zeros_like(problem.active)
    out: npt.NDArray[np.bool_] = (np.abs(local) >= problem.most) & (local * step > 0)
    return out


def _blocked(problem: Problem, shared: Array, pull: Array) -> npt.NDArray[np.bool_]:
    """Free global parameters that sit at a bound that the gradient pushes against."""
    free = problem.free
    low, high = shared[free] <= problem.lower[free], shared[free] >= problem.upper[free]
    out: npt.NDArray[np.bool_] = (low & (pull <= 0)) | (high & (pull >= 0))
    return out
