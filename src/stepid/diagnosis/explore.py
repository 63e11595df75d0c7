"""Search a campaign, look again at its readings by what the best answer leaves, and search on where that tells more."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor, block_means, is_white, less_likely_by, weigh
from stepid.diagnosis.progress import Progress
from stepid.diagnosis.refine import refined
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.proposal import Proposal
from stepid.diagnosis.selection.search import Search
from stepid.effects.base import Effect
from stepid.effects.drive import acts_on_input
from stepid.fitting.deviations import with_deviations
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.problem import build
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.run_fault import accuse

_LOOKS = 3  # at the readings
_STEPS = 8  # of a fit that was at its end


class Found(NamedTuple):
    """What a search found, and the records as they were seen in the end."""

    context: FitContext
    candidates: tuple[Candidate, ...]

    @property
    def best(self) -> Candidate:
        """The candidate that leaves least."""
        return min(self.candidates, key=lambda c: c.optimum.cost)

    @property
    def single(self) -> list[Candidate]:
        """The single effect that leaves least with all runs alike: a larger set, or conditions, can follow a fault."""
        alone = [c for c in self.candidates if len(c.effects) == 1 and not c.deviations]
        return sorted(alone, key=lambda c: c.optimum.cost)[:1]

    @property
    def likeliest(self) -> Candidate:
        """The candidate of most evidence."""
        return weigh(self.context, self.candidates)[0].candidate

    @property
    def simpler(self) -> list[Candidate]:
        """Candidates with effects that are no more complex than the likeliest, the simplest first."""
        most = self.likeliest.complexity
        able = [c for c in self.candidates if c.effects and c.complexity <= most]
        return sorted(able, key=lambda c: (c.complexity, c.optimum.cost))


def outweighs(cost: float, plain: Optimum, found: Found, criteria: Criteria) -> bool:
    """Tell whether one fault of one run beside a plain fit, which leaves `cost` [m²], is better than what was found.

    One effect in the whole plant is the likelier of two as good answers; several that are needed for one fault are not,
    nor are conditions that differ in all runs.
    """
    return _ahead(cost, plain, found, criteria) > 0


def _ahead(cost: float, plain: Optimum, found: Found, criteria: Criteria) -> float:
    """QBIC by which it is, beyond what it must be."""
    best = found.likeliest
    one = len(best.effects) == 1 and not best.deviations
    return -less_likely_by(found.context, plain, best.optimum, cost=cost, more=1) - (criteria.tie if one else 0.0)


def fault_beside(found: Found, criteria: Criteria) -> RecordFault | None:
    """One fault of one run, beside fewer of the likeliest answer's effects or conditions: those can take its part.

    Of several sets the one of most evidence with its fault: beside more effects another fault may do, too.
    """
    told: list[tuple[float, RecordFault]] = []
    for names in _fewer(found.likeliest):
        plain = _alike(found, names)
        one = None if plain is None else accuse(plain, found.context.floor, sure=criteria.size)
        if plain and one and (ahead := _ahead(one.cost, plain, found, criteria)) > 0:
            told.append((ahead, one.fault))
    return max(told, key=lambda one: one[0])[1] if told else None


def _fewer(best: Candidate) -> list[tuple[str, ...]]:
    """Sets of effects to hold a fault against: those of an answer, where its conditions differ, and fewer of them.

    Or simpler laws inside one of them: a general law can take a fault's part.
    """
    names, whole = best.names, [best.names] if best.deviations and best.effects else []
    inside = [(name,) for effect in best.effects for name in effect.contains if whole or len(names) > 1]
    return whole + [some for n in range(len(names) - 1, 0, -1) for some in combinations(names, n)] + inside


def _alike(found: Found, names: tuple[str, ...]) -> Optimum | None:
    """Some effects with conditions alike in all runs, from where the search fitted them; None where it did not."""
    fitted = [c for c in found.candidates if c.key[0] == frozenset(names)]
    if not fitted:
        return None
    nearest = min(fitted, key=lambda c: len(c.deviations))
    return nearest.alike(found.context)


def linear_candidate(context: FitContext) -> Candidate:
    """The plain plant as a candidate."""
    return Candidate((), frozenset(), context.linear, block_means(context, context.linear))


def explored(
    context: FitContext,
    catalogue: tuple[Effect, ...],
    criteria: Criteria,
    effort: Effort,
    tell: Callable[[Progress], object],
) -> Found:
    """Search; where the linear plant leaves white noise there is nothing to search for."""
    if context.by_weights is not None:  # one effect may be as good an answer, several are not
        effort = effort.model_copy(update={"rounds": 1})

    def searched(context: FitContext) -> Found:
        linear = linear_candidate(context)
        if at_floor(context, criteria, linear) and is_white(context, linear, criteria.white):
            return Found(context, (linear,))
        return Found(context, tuple(_search(context, catalogue, criteria, effort, tell)))

    found = searched(context)
    for _ in range(_LOOKS):
        again = refined(found.context, found.best, found.likeliest, found.simpler)
        if again is None:
            break
        same = Found(again, _fitted_again(again, found.candidates))
        found = same if _stands(found, same, criteria) else searched(again)
    return found


def _stands(before: Found, after: Found, criteria: Criteria) -> bool:
    """Tell whether another look at the readings leaves the answer: no further search can tell more then.

    The likeliest candidate has the same effects, whichever conditions differ, and no rest has come to light: where one
    was left before, the search went on for longer than it would now.
    """
    rest = [not at_floor(found.context, criteria, found.best) for found in (before, after)]
    return before.likeliest.key[0] == after.likeliest.key[0] and rest[0] >= rest[1]


def _fitted_again(context: FitContext, candidates: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """The same candidates, fitted to the readings as they are seen now."""
    out = []
    for c in candidates:
        if not c.effects and not c.deviations:  # one fit of the plain plant for all who ask
            out.append(linear_candidate(context))
            continue
        if c.optimum.problem.records is context.records:  # another noise floor only
            out.append(replace(c, structure=block_means(context, c.optimum)))
            continue
        problem = with_deviations(build(context.records, c.effects, workers=context.workers), c.deviations)
        problem = replace(problem, active=problem.active & c.optimum.problem.active)  # who is at rest stays so
        local = np.where(problem.active, c.optimum.local, 0.0)
        fitted = minimize(problem, c.optimum.shared, local, tolerance=context.tolerance, iterations=_STEPS)
        if fitted is not None:
            out.append(replace(c, optimum=fitted, structure=block_means(context, fitted)))
    return tuple(out)


def _search(
    context: FitContext,
    catalogue: tuple[Effect, ...],
    criteria: Criteria,
    effort: Effort,
    tell: Callable[[Progress], object],
) -> list[Candidate]:
    def told(search: Search, proposal: Proposal) -> None:
        words = " + ".join([*(e.name for e in proposal.effects), *sorted(proposal.deviations)]) or "linear model"
        done, queue = search.fits.count - 1, search.queue  # this one is not
        best = search.standings.best.names
        tell(Progress(words, best=best, done=done, left=queue.left, promise=queue.promise))

    if not context.records.driven.any():
        catalogue = tuple(e for e in catalogue if not acts_on_input(e))
    return Search(context, catalogue, criteria=criteria, effort=effort, tell=told).run()
