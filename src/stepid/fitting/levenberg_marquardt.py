"""Levenberg–Marquardt over all records, rest positions projected out, a runaway a rejected step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.simulation.trajectory import Simulator, Solved

_MOST_DAMPING = 1e12
_STEEPEST = 1e120
_MARCHES = 3  # trials a fit that may be simulated sample by sample, where Newton does not settle on them
_WORTH = 0.02  # share of the cost that such a trial must promise


@dataclass(frozen=True)
class Problem:
    """What is fitted: which shared and local parameters are free, and the bounds of the shared ones."""

    simulator: Simulator
    free: npt.NDArray[np.bool_]
    lower: Array
    upper: Array
    active: npt.NDArray[np.bool_]  # (Q, R)

    @property
    def wanted(self) -> npt.NDArray[np.bool_]:
        """Parameters that are fitted, in any run: only their sensitivities are needed, shape (P + Q,)."""
        return np.concatenate([self.free, self.active.any(axis=1)])

    def residual(self, solved: Solved) -> Array:
        """Measured minus simulated, each run's rest position fitted, times the weights, m."""
        r = self.simulator.records
        return r.weighted(r.position - solved.reading)

    def jacobian(self, solved: Solved) -> Array:
        """Derivative of the simulated reading by the free parameters, shape (S, columns); ±inf at a runaway's edge."""
        assert solved.shared is not None
        assert solved.local is not None
        r = self.simulator.records
        with np.errstate(all="ignore"):
            parts = [r.weighted(solved.shared[self.free]).T]
            local = r.weighted(solved.local)
        where = np.argwhere(self.active)
        if where.size:
            block = np.zeros((r.size, len(where)))
            pieces = r.pieces()
            for column, (q, run) in enumerate(where):
                block[pieces[run], column] = local[q, pieces[run]]
            parts.append(block)
        out: Array = np.concatenate(parts, axis=1)
        out[np.abs(out) > _STEEPEST] = np.inf  # its square would overflow
        return out


@dataclass(frozen=True)
class Optimum:
    """Where a fit ended."""

    problem: Problem
    shared: Array
    local: Array
    solved: Solved
    cost: float  # sum of squared residuals, m²
    converged: bool
    iterations: int

    @property
    def residual(self) -> Array:
        """Measured minus simulated, unweighted, m, shape (S,)."""
        r = self.problem.simulator.records
        return r.centered(r.position - self.solved.reading)

    @property
    def rms(self) -> float:
        """Root mean square of the unweighted residual, m."""
        return float(np.sqrt(np.mean(self.residual**2)))


def evaluate(
    problem: Problem, shared: Array, local: Array, start: Array | None, *, march: bool = False
) -> Solved | None:
    """Solve all records at a point, marching where Newton does not settle (or at once)."""
    sim = problem.simulator
    solved = None if march else sim.solve(shared, local, start=start, wanted=problem.wanted)
    if solved is None and not sim.law.linear:
        marched = sim.march(shared[None], local[None])[0]
        if np.isfinite(marched).all() and np.abs(marched[0]).max() < 1e3:
            solved = sim.solve(shared, local, start=marched, wanted=problem.wanted)
    return solved


def minimize(
    problem: Problem,
    shared: Array,
    local: Array,
    *,
    start: Array | None = None,
    tolerance: float = 0.0,
    iterations: int = 40,
) -> Optimum | None:
    """Fit the free parameters by Levenberg–Marquardt on a QR factorization.

    Parameters
    ----------
    problem : Problem
    shared : array, shape (P,)
    local : array, shape (Q, R)
    start : array, shape (d, S), optional
        A nearby trajectory.
    tolerance : float
        m², predicted decrease of the cost at which to stop.
    iterations : int
        At most so many accepted steps, and three times as many tries.

    Returns
    -------
    Optimum or None
        None where the start itself cannot be simulated.
    """
    free, active = problem.free, problem.active
    n_free = int(free.sum())
    shared = np.clip(shared, problem.lower, problem.upper)
    solved = evaluate(problem, shared, local, start)
    if solved is None or not np.isfinite(solved.reading).all():
        return None
    residual = problem.residual(solved)
    cost = float(residual @ residual)
    damping, growth, converged, accepted = 1e-4, 4.0, False, 0
    factored, marches = None, _MARCHES
    for _ in range(3 * iterations):
        if accepted >= iterations:
            break
        if factored is None:
            jacobian = problem.jacobian(solved)
            if not np.isfinite(jacobian).all():  # a runaway's edge: nothing to follow
                break
            scale = np.linalg.norm(jacobian, axis=0)
            at_bound = _blocked(problem, shared, jacobian, residual)
            scale[scale <= 1e-14 * scale.max(initial=1e-300)] = np.inf
            usable = np.where(at_bound, np.inf, scale)
            q, r = np.linalg.qr(jacobian / usable)
            factored = (usable, r, q.T @ residual)
        usable, r, projected = factored
        stacked = np.concatenate([r, np.sqrt(damping) * np.eye(len(usable))])
        step = np.linalg.lstsq(stacked, np.concatenate([projected, np.zeros(len(usable))]), rcond=None)[0]
        predicted = float(projected @ projected - np.sum((projected - r @ step) ** 2))
        if predicted <= max(tolerance, 1e-10 * cost):
            converged = True
            break
        delta = step / usable
        trial = shared.copy()
        trial[free] += delta[:n_free]
        trial = np.clip(trial, problem.lower, problem.upper)
        trial_local = local.copy()
        trial_local[active] += delta[n_free:]
        new = evaluate_near(problem, solved, trial, trial_local, trial - shared, trial_local - local)
        if new is None and marches and not problem.simulator.law.linear and predicted > _WORTH * cost:
            marches -= 1
            new = evaluate(problem, trial, trial_local, None, march=True)
        fresh = problem.residual(new) if new is not None else None
        fresh_cost = float(fresh @ fresh) if fresh is not None else np.inf
        if new is not None and fresh is not None and fresh_cost < cost:
            gain = (cost - fresh_cost) / predicted
            damping *= max(1 / 10, 1 - (2 * min(gain, 1.0) - 1) ** 3)
            damping, growth = max(damping, 1e-12), 4.0
            accepted += 1
            small = cost - fresh_cost <= max(tolerance, 1e-9 * cost) and gain > 0.25
            shared, local, solved, residual, cost, factored = trial, trial_local, new, fresh, fresh_cost, None
            if small:
                converged = True
                break
        else:
            damping, growth = max(damping * growth, 1e-3), growth * 2
            if damping > _MOST_DAMPING:
                converged = True
                break
    return Optimum(problem, shared, local, solved, cost, converged, accepted)


def evaluate_near(
    problem: Problem, solved: Solved, shared: Array, local: Array, change: Array, local_change: Array
) -> Solved | None:
    """Solve at a point near a solved one, starting from its tangent's prediction."""
    assert solved.tangent is not None
    sim = problem.simulator
    with np.errstate(all="ignore"):  # a step that overflows is found out below
        start = solved.states + np.tensordot(change, solved.tangent[: sim.n_shared], 1)
        if np.any(local_change):
            run = sim.records.run
            for q in range(sim.n_local):
                start = start + local_change[q, run] * solved.tangent[sim.n_shared + q]
    return sim.solve(shared, local, start=start, wanted=problem.wanted)


def _blocked(problem: Problem, shared: Array, jacobian: Array, residual: Array) -> npt.NDArray[np.bool_]:
    """Columns whose parameter sits at a bound that the gradient pushes against."""
    blocked = np.zeros(jacobian.shape[1], dtype=bool)
    pull = residual @ jacobian
    for column, index in enumerate(np.flatnonzero(problem.free)):
        blocked[column] = (shared[index] <= problem.lower[index] and pull[column] <= 0) or (
            shared[index] >= problem.upper[index] and pull[column] >= 0
        )
    return blocked
