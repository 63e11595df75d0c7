"""A candidate fitted to all samples, with the initial states that it needs and no more."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

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
    """The fit with the runs at rest where they may be, if that costs less than what the initial states are worth.

    What a few steps from there leave tells whether to go on. Derivatives do not: a cart that begins where friction just
    holds it is set free by the least push.
    """
    problem = best.problem
    active = problem.active.copy()
    active[:2] &= context.records.moving
    active[problem.layout.own_states] &= context.records.moving
    if np.array_equal(active, problem.active):
        return best
    counts = effective_samples(context.records, problem.residual(best.solved))
    price = float((problem.active & ~active).sum(axis=0) @ np.log(counts))  # what is free in both costs the same
    worth, least = price / float(counts.sum()), max(best.cost, context.rounding_cost)
    most = least * math.exp(worth)
    problem, local = replace(problem, active=active), np.where(active, best.local, 0.0)
    held = minimize(problem, best.shared, local, tolerance=context.tolerance, iterations=effort.begin)
    if held is None or held.cost > least * math.exp(effort.stuck * worth):
        return best
    held = minimize(
        problem,
        held.shared,
        held.local,
        tolerance=context.tolerance,
        iterations=effort.polishing,
        aim=most,
        solved=held.solved,
    )
    return best if held is None or held.cost >= most else held
