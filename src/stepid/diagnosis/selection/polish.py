"""A candidate fitted to all samples, with the initial states that it needs and no more."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stepid.diagnosis.evidence import effective_samples
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.selection.effort import Effort
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import FitContext


def polished(
    context: FitContext, fitted: CandidateFit, effort: Effort, others: Iterable[Candidate] = ()
) -> Optimum | None:
    """Converge a candidate on all samples, with its initial states free and at rest; the better of the two.

    Where a rest remains it goes no further than one of the `others` that has no more in it and leaves less.
    """
    noise = context.full_noise_cost
    beaten = (1 + effort.spread) * max(_least(fitted, others), 2 * noise)
    excess = fitted.excess
    for iterations in (effort.begin, effort.polishing):
        fitted.polish(iterations=iterations, tolerance=max(context.tolerance, effort.enough * excess))
        if fitted.polished is None or fitted.polished.converged or fitted.polished.cost > beaten:
            break
        excess = max(excess, fitted.polished.cost - noise)
    best = fitted.polished
    if best is None:
        return None
    if fitted.rested is None or fitted.rested[0] is not best:
        fitted.rested = best, _at_rest(context, best, effort)
    return fitted.rested[1]


def _least(fitted: CandidateFit, others: Iterable[Candidate]) -> float:
    """Cost of the best of other sets with no more effects and no other conditions, m²."""
    return min(
        (
            c.optimum.cost
            for c in others
            if c.names != fitted.names and len(c.effects) <= len(fitted.names) and c.deviations <= fitted.deviations
        ),
        default=math.inf,
    )


def _at_rest(context: FitContext, best: Optimum, effort: Effort) -> Optimum:
    """The fit with the runs at rest where they may be, if that costs less than what the initial states are worth."""
    problem = best.problem
    active = problem.active.copy()
    active[:2] &= context.records.moving
    active[problem.layout.own_states] &= context.records.moving
    if np.array_equal(active, problem.active):
        return best
    counts = effective_samples(context.records, problem.residual(best.solved))
    price = float((problem.active & ~active).sum(axis=0) @ np.log(counts))  # what is free in both costs the same
    worth, least = price / float(counts.sum()), max(best.cost, context.rounding_cost)
    if not _worth_holding(context, best, active, least * math.exp(effort.stuck * worth)):
        return best
    most = least * math.exp(worth)
    held = minimize(
        replace(problem, active=active),
        best.shared,
        np.where(active, best.local, 0.0),
        tolerance=context.tolerance,
        iterations=effort.polishing,
        aim=most,
    )
    return best if held is None or held.cost >= most else held


def _worth_holding(context: FitContext, best: Optimum, active: npt.NDArray[np.bool_], most: float) -> bool:
    """Tell whether initial states may be those at rest: by one linearized step, that leaves at most so much [m²]."""
    problem = best.problem
    jacobian, residual = problem.jacobian(best.solved), problem.residual(best.solved)
    if not np.isfinite(jacobian).all() or best.cost < context.rounding_cost:
        return True  # at a runaway's edge nothing is linear; below rounding there is room
    where = np.argwhere(problem.active)
    kept = np.concatenate([np.ones(int(problem.free.sum()), dtype=bool), active[where[:, 0], where[:, 1]]])
    own = best.local[where[:, 0], where[:, 1]][~kept[-len(where) :]]
    residual = residual + jacobian[:, ~kept] @ own
    size = np.linalg.norm(jacobian, axis=0)
    size[size == 0] = np.inf
    q = np.linalg.qr((jacobian / size)[:, kept])[0]
    left = residual - q @ (q.T @ residual)
    return float(left @ left) < most
