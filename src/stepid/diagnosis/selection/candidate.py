"""A set of effects fitted to all data, and what speaks for it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import Contender, FitContext
from stepid.fitting.noise_floor import structure, succession

_WHITE = 6.0  # standard deviations of structure that noise may show
_TOLD = 1.2  # times the floor that white noise may leave: a few hundred samples tell it that well
_ROOM = 6.0  # times the price of the starting displacements that holding them at zero may seem to cost


@dataclass(frozen=True)
class Candidate:
    """A set of effects, fitted to all data.

    `evidence` is its χ² plus the price of its parameters (BIC); smaller is better.
    """

    effects: tuple[Effect, ...]
    optimum: Optimum
    evidence: float
    structure: float

    @property
    def names(self) -> tuple[str, ...]:
        """Canonical names."""
        return tuple(e.name for e in self.effects)

    @property
    def combination(self) -> frozenset[str]:
        """The names, whatever their order."""
        return frozenset(self.names)


def evidence(optimum: Optimum, floor: float) -> float:
    """χ² plus log(n) a shared parameter and log(n of the run) a parameter of a run (BIC)."""
    problem = optimum.problem
    records = problem.records
    counts = np.add.reduceat(records.weight**2, records.first)
    price = float(problem.free.sum()) * math.log(float(counts.sum()))
    price += float(np.sum(problem.active * np.log(np.maximum(counts, 2.0))))
    return optimum.cost / floor**2 + price


def candidate(context: FitContext, effects: tuple[Effect, ...], optimum: Optimum) -> Candidate:
    """Judge a fit."""
    records = context.records
    white = structure(records, optimum.problem.residual(optimum.solved), context.floor, context.period)
    return Candidate(effects, optimum, evidence(optimum, context.floor), white)


def at_floor(context: FitContext, found: Candidate) -> bool:
    """Tell whether a fit leaves nothing but noise."""
    n = float((context.records.weight**2).sum())
    times = found.optimum.rms / context.floor
    if found.structure >= _WHITE or times > _TOLD:
        return False
    if times <= 1.05 + 3.0 / math.sqrt(2.0 * n):
        return True
    return is_white(context, found, 3.0)  # the floor is known to some percent only


def is_white(context: FitContext, found: Candidate, deviations: float) -> bool:
    """Tell whether a residual is as white as noise of its own size, within so many standard deviations."""
    ratio, count = succession(context.records, found.optimum.residual)
    return ratio < 1.0 + deviations / math.sqrt(max(count, 1))


def polish(context: FitContext, contender: Contender, *, enough: float = 0.05) -> Candidate | None:
    """Converge a contender on all samples, with the starting states free and at rest; keep the better.

    It has converged where a step promises less than `enough` χ².
    """
    tolerance = enough * context.floor**2
    if contender.excess > 0.4 * contender.cost:
        tolerance = max(tolerance, 0.002 * contender.excess)
    for _ in range(3):
        contender.polish(laps=15, tolerance=tolerance)
        if contender.polished is None or contender.polished.converged:
            break
    best = contender.polished
    if best is None:
        return None
    if contender.judged is None or contender.judged[0] is not best:
        contender.judged = best, _simpler_start(context, contender, best, enough)
    found: Candidate = contender.judged[1]
    return found


def _simpler_start(context: FitContext, contender: Contender, best: Optimum, enough: float) -> Candidate:
    """Judge a fit with the starting states free, and at rest where that may do as well; the better."""
    found = candidate(context, contender.effects, best)
    problem = best.problem
    active = problem.active.copy()
    active[:2] = context.records.moving
    active[problem.layout.own_states] = False
    if not np.array_equal(active, problem.active):
        if not _worth_holding(context, best, active):
            return found
        local = np.where(active, best.local, 0.0)
        held = minimize(
            replace(problem, active=active),
            best.shared,
            local,
            tolerance=enough * context.floor**2,
            iterations=12,
        )
        if held is not None:
            other = candidate(context, contender.effects, held)
            if other.evidence < found.evidence:
                found = other
    return found


def _worth_holding(context: FitContext, best: Optimum, active: npt.NDArray[np.bool_]) -> bool:
    """Tell whether starting states may be those at rest: by one linearized step, with room for its error."""
    problem = best.problem
    jacobian, residual = problem.jacobian(best.solved), problem.residual(best.solved)
    if not np.isfinite(jacobian).all():  # at a runaway's edge nothing is linear
        return True
    where = np.argwhere(problem.active)
    kept = np.concatenate([np.ones(int(problem.free.sum()), dtype=bool), active[where[:, 0], where[:, 1]]])
    own = best.local[where[:, 0], where[:, 1]][~kept[-len(where) :]]
    residual = residual + jacobian[:, ~kept] @ own
    size = np.linalg.norm(jacobian, axis=0)
    size[size == 0] = np.inf
    q = np.linalg.qr((jacobian / size)[:, kept])[0]
    left = residual - q @ (q.T @ residual)
    price = own.size * math.log(context.records.size)
    return bool(float(left @ left) - best.cost < _ROOM * price * context.floor**2)


def linear_candidate(context: FitContext) -> Candidate:
    """The plain plant as a candidate."""
    return candidate(context, (), context.linear)
