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

from stepid.core.base import Array
from stepid.fitting.coordinates import Coordinates
from stepid.simulation.layout import ParameterLayout
from stepid.simulation.records import Index, Records
from stepid.simulation.simulator import STEEPEST, Simulator, Solved

_CRAWL = 5  # steps that together gain less than the tolerance: the rest is not worth its time
_MOST_DAMPING = 1e12
_GROWTH = 4.0  # of the damping after a step that failed; twice as much after each further one
_HOPE = 4.0  # times what a step promises, that each of those to come may bring: in valleys the promise grows
_ROUNDING = 1e-13  # of the typical displacement: no larger difference of all readings is more than rounding


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


class _Columns:
    """Which parameters enter which run: those of a run enter that run only; runs without any are one block."""

    def __init__(self, problem: Problem) -> None:
        self.active = active = problem.active
        free = np.flatnonzero(problem.free)
        own = active.sum(axis=0)
        self.n_shared, most = free.size, int(own.max(initial=0))
        self.columns = np.zeros((own.size, most + free.size), dtype=np.intp)
        for r, count in enumerate(own):
            self.columns[r, :count] = problem.layout.n_global + np.flatnonzero(active[:, r])
            self.columns[r, count : count + free.size] = free
        self.own, (self.owners,) = own, np.nonzero(own)
        self.block = np.where(own > 0, np.cumsum(own > 0) - 1, self.owners.size)
        self.sizes = np.append(own[self.owners], 0)  # of each block, that of runs without own parameters last


class _Linearized:
    """The fit to first order about a point, each run reduced to a triangle."""

    def __init__(
        self, problem: Problem, columns: _Columns, slopes: tuple[Array, Array], residual: Array, steps: Array
    ) -> None:
        from stepid.simulation.triangles import reduce_runs

        r, self._columns = problem.records, columns
        n, blocks, width = columns.n_shared, columns.sizes.size, columns.columns.shape[1] + 1
        self._triangles = np.zeros((blocks, width, width))
        size, own_size, self.pull = np.zeros(n), np.zeros((blocks, width - 1 - n)), np.zeros(n)
        with np.errstate(all="ignore"):  # plain Python would warn of a runaway
            self.finite = reduce_runs(
                *slopes, residual, r.weight, r.bounds, columns.columns, columns.own, columns.block,
                self._triangles, size, own_size, self.pull,
            )  # fmt: skip
        size, own_size = np.sqrt(size), np.sqrt(own_size)
        seen = size * steps[problem.free] > _ROUNDING * problem.simulator.scale
        self._size = np.where(seen, size, np.inf)
        self._own_size = np.where(own_size > 1e-14 * own_size.max(initial=1e-300), own_size, np.inf)

    def step(
        self, damping: float, blocked: npt.NDArray[np.bool_], held: npt.NDArray[np.bool_]
    ) -> tuple[Array, Array, float]:
        """Damped step of the global and of the per-run parameters, and the decrease of the cost that it promises.

        Global parameters that are blocked and per-run ones that are held, shape (Q, R), stay.
        """
        from stepid.simulation.triangles import damped_step

        c = self._columns
        size, own_size = np.where(blocked, np.inf, self._size), self._own_size.copy()
        for run, sizes in zip(c.owners, own_size, strict=False):
            still = held[c.active[:, run], run]
            sizes[: still.size][still] = np.inf
        shared, own = np.zeros(c.n_shared), np.zeros_like(own_size)
        gain = damped_step(self._triangles, c.sizes, damping, size, own_size, shared, own)
        local = np.zeros(c.active.shape)
        for run, steps, count in zip(c.owners, own, c.sizes, strict=False):
            local[c.active[:, run], run] = steps[:count]
        return shared, local, gain


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
    residual, cost = problem.weigh(solved)
    columns = _Columns(problem)
    damping, growth, converged, accepted = 1e-4, _GROWTH, False, 0
    costs = [cost]
    linearized: _Linearized | None = None
    for _ in range(3 * iterations):
        if accepted >= iterations:
            break
        if linearized is None:
            inner = Coordinates(problem, shared, solved)
            linearized = _Linearized(problem, columns, inner.slopes(shared, solved), residual, inner.steps(shared))
            if not linearized.finite:  # a runaway's edge: nothing to follow
                break
            blocked = _blocked(problem, shared, linearized.pull)
        delta, own, predicted = linearized.step(damping, blocked, np.zeros_like(problem.active))
        held = _held(problem, local, own)
        if held.any():
            delta, own, predicted = linearized.step(damping, blocked, held)
        if predicted <= max(tolerance, 1e-10 * cost):
            converged = True
            break
        if growth == _GROWTH and cost - _HOPE * predicted * (iterations - accepted) > aim:
            break
        trial, trial_local = inner.moved(shared, delta), _within(problem, local + own)
        new = problem.solve(trial, trial_local)
        fresh, fresh_cost = problem.weigh(new) if new is not None else (residual, np.inf)
        if new is not None and fresh_cost < cost:
            gain = (cost - fresh_cost) / predicted
            damping *= max(1 / 10, 1 - (2 * min(gain, 1.0) - 1) ** 3)
            damping, growth = max(damping, 1e-12), _GROWTH
            accepted += 1
            converged = cost - fresh_cost <= max(tolerance, 1e-9 * cost) and gain > 0.25
            costs.append(fresh_cost)
            slow = accepted > _CRAWL and costs[-1 - _CRAWL] - fresh_cost <= tolerance
            converged = converged or slow  # along a curved valley every step promises more than it brings
            shared, local, solved, residual, cost, linearized = trial, trial_local, new, fresh, fresh_cost, None
        else:
            damping, growth = max(damping * growth, 1e-3), growth * 2
            converged = damping > _MOST_DAMPING
        if converged:
            break
    return Optimum(problem, shared, local, solved, cost, converged, accepted)


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
