"""What may lead where a rest remains: one effect or two, with no more in them than the data bear."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

from stepid.diagnosis.evidence import Weighed, least_share, part_left, predicts
from stepid.diagnosis.selection.candidate import LEADING, Candidate, includes
from stepid.diagnosis.vetoes import effects_of
from stepid.effects.swing import OWN
from stepid.fitting.mean_of_runs import starts_late

if TYPE_CHECKING:
    from stepid.diagnosis.gather import EvidenceRecord


class Leads:
    """Candidates that may lead.

    Parameters
    ----------
    evidence : EvidenceRecord
    """

    def __init__(self, evidence: EvidenceRecord) -> None:
        self._told = evidence

    @cached_property
    def able(self) -> tuple[Weighed, ...]:
        """Candidates of two effects at most, none of them an imitator, best first."""
        few = [w for w in self._told.weighed if len(w.candidate.effects) <= LEADING]
        able = [w for w in few if not self._told.imitators(w.candidate)]
        lowest = min(w.loss for w in able)
        return tuple(w._replace(loss=w.loss - lowest) for w in able)

    @cached_property
    def best(self) -> Candidate:
        """The best of those that may lead where a rest remains, with no more in it than takes a notable part."""
        best = self._predicting(self._simpler_law(self._told.simplest(self.able).candidate))
        best = self._predicting(self._without_trifle(best))
        return self._shared_law(self._determined(best) if len(best.effects) > 1 else best)

    def _shared_law(self, best: Candidate) -> Candidate:
        """The simpler law inside that weighty candidates share, where the best's own weight is not enough."""
        if self._told.weight(best) >= self._told.criteria.sure:
            return best
        inside = [w.candidate for w in self.able if len(w.candidate.effects) == len(best.effects)]
        inside = [
            c for c in inside if includes(best.effects, c.effects) and self._told.weight(c) >= self._told.criteria.sure
        ]
        return inside[0] if inside else best

    def _predicting(self, found: Candidate) -> Candidate:
        """The same effects with conditions alike in all runs, where free ones do not predict and they lead without."""
        if not (found.effects and found.deviations) or self.predicts(found):
            return found
        alike = [
            w.candidate for w in self.able if w.candidate.key[0] == found.key[0]
            and w.candidate.deviations < found.deviations and self._takes(self._told.linear, w.candidate)
        ]  # fmt: skip
        return next(filter(self.predicts, alike), found)

    def predicts(self, found: Candidate) -> bool:
        """Tell whether effects take enough on runs left out, and as much in each of them."""
        return predicts(self._told.criteria, len(found.effects), self._told.share(found))

    def _takes(self, before: Candidate, after: Candidate) -> bool:
        """Tell whether one candidate takes as much as a lead has to of what another with fewer effects leaves."""
        more = len(after.effects) - len(before.effects)
        return self.taken(before, after) >= least_share(self._told.criteria, more)

    def _determined(self, pair: Candidate) -> Candidate:
        """One effect of two where the other is open: an effect that the data do not determine explains a rest only."""
        open_ = effects_of(self._told.open(pair))
        named = [name for name in pair.names if name not in open_]
        alone = [w.candidate for w in self.able if w.candidate.names == tuple(named)]
        return alone[0] if open_ and alone else pair

    def _loss(self, found: Candidate) -> float:
        return next(w.loss for w in self.able if w.candidate is found)

    def _simpler_law(self, best: Candidate) -> Candidate:
        """The simplest law inside a candidate that the data do not tell from it."""
        near = [
            w.candidate
            for w in self.able
            if abs(w.loss - self._loss(best)) < self._told.criteria.tie
            and w.candidate.deviations == best.deviations
            and len(w.candidate.effects) == len(best.effects)
            and includes(best.effects, w.candidate.effects)
        ]
        return min(near, key=lambda c: (sum(len(e.parameters) for e in c.effects), self._loss(c)))

    def _without_trifle(self, pair: Candidate) -> Candidate:
        """One effect of two, where it leads, and the other takes no such part of what it leaves or does not predict.

        The one may have conditions that differ from run to run: what these can stand in for is no effect. A delay that
        all runs share is one, though start times follow it.
        """
        if len(pair.effects) < 2:
            return pair
        inside = [
            w.candidate for w in self.able if len(w.candidate.effects) == 1
            and includes(pair.effects, w.candidate.effects) and self._takes(self._told.linear, w.candidate)
        ]  # fmt: skip
        trifles = [c for c in inside if not self._takes(c, pair) and not (c.deviations and starts_late(c.optimum))]
        found = next(filter(self.predicts, trifles), None)
        if found is not None or self.predicts(pair):
            return found or pair
        others = (c for c in inside if c not in trifles)
        return next(filter(self.predicts, others), trifles[0] if trifles else pair)

    def taken(self, before: Candidate, after: Candidate) -> float:
        """Share of the power above the floor that one candidate leaves, which another takes."""
        return 1.0 - part_left(before.optimum.rms**2, after.optimum.rms**2, self._told.context.floor**2)

    def _rough(self, lead: Candidate) -> float:
        """Power by which real laws are rough that explain what conditions leave to a lead, m²."""
        told = self._told
        whole = told.linear.optimum.rms**2 - told.context.floor**2
        return told.criteria.rough * told.left_out.part_of_effects(lead) * whole

    @cached_property
    def sure_part(self) -> Candidate | None:
        """What may be named of the best without its other effects, where the candidates that hold it weigh enough."""
        told, best = self._told, self._told.best
        names = frozenset(best.names) - effects_of(told.open(best)) - told.imitators(best).keys()
        alone = (w.candidate for w in self.able if w.candidate.key[0] == names and len(names) < len(best.names))
        part = next((c for c in alone if c.effects and c.deviations <= best.deviations), None)
        if part is None:
            return None
        part = self._predicting(self._without_trifle(part))
        held = (w.weight for w in told.weighed if includes(w.candidate.effects, part.effects))  # nameable or not
        return part if math.fsum(held) >= told.criteria.sure else None

    def outdone(self, lead: Candidate) -> bool:
        """Tell whether as few effects halve what a lead leaves, of which one stands in for the plant's own oscillation.

        That oscillation then changes as no law of the catalogue lets it, which the lead only comes near to: by more
        than real laws are rough, and though another law may stand beside it.
        """
        if self._told.at_floor(lead):
            return False
        every = [w.candidate for w in self._told.weighed if w.candidate.deviations <= lead.deviations]
        nearest = min(self._holding(lead), key=lambda c: c.optimum.rms, default=lead)
        most = nearest.optimum.rms**2 - self._rough(lead)
        few = (c for c in every if len(c.effects) <= len(lead.effects))
        halving = (c for c in few if self.taken(nearest, c) > 0.5 and c.optimum.rms**2 < most)
        return any(OWN in self._told.imitators(c).values() for c in halving)

    def rival_elsewhere(self, lead: Candidate) -> Candidate | None:
        """A law of another state in a lead's place that leaves less than twice as much beyond the noise.

        What is missing in either is then more than what sets them apart, and may be what lets the one lead. It is
        found where the lead, alone or as a part of the best, leaves only noise.
        """
        best = self._told.best
        if self._told.at_floor(lead) or (self._told.at_floor(best) and includes(best.effects, lead.effects)):
            return None
        states = frozenset(self._told.states(lead))
        for other in (w.candidate for w in self.able):
            few = 0 < len(other.effects) <= len(lead.effects) and other.deviations <= lead.deviations
            if not few or includes(other.effects, lead.effects) or includes(lead.effects, other.effects):
                continue
            apart = states.isdisjoint(self._told.states(other))
            if apart and self.taken(lead, other) > -1.0 and not self._told.barred(other):
                return other
        return None

    def _holding(self, lead: Candidate) -> Iterator[Candidate]:
        """Candidates that may lead and hold a lead, alone or beside a law that the data determine."""
        for found in (w.candidate for w in self.able):
            holds = includes(found.effects, lead.effects) and found.deviations <= lead.deviations
            if holds and (found is lead or not self._told.open(found)):
                yield found

    def beside(self, lead: Candidate) -> tuple[Candidate, ...]:
        """Candidates that the data do not tell from a lead: its twins, and more general laws with more evidence."""
        own = self._loss(lead)
        out: dict[frozenset[str], Candidate] = {}
        for w in self.able:
            other, names = w.candidate, frozenset(w.candidate.names)
            if len(names) != len(lead.effects) or names == frozenset(lead.names):
                continue
            near = abs(w.loss - own) < self._told.criteria.tie
            if (near and w.loss < own) or (
                (near or self._as_rough(lead, other)) and not includes(other.effects, lead.effects)
            ):
                out.setdefault(names, other)
        return tuple(out.values())

    def _as_rough(self, lead: Candidate, other: Candidate) -> bool:
        """Tell whether another law of one state in the lead's place leaves no more beyond it than real laws are rough.

        Where a rest remains it holds both, and what is missing decides between them.
        """
        told = self._told
        more = other.optimum.rms**2 - lead.optimum.rms**2
        if told.at_floor(lead) or other.deviations != lead.deviations or more > self._rough(lead):
            return False
        own, others = (set(zip(c.names, told.states(c), strict=True)) for c in (lead, other))
        states = [[state for _, state in few] for few in (own - others, others - own)]
        return states[0] == states[1] and len(states[0]) == 1 and bool(states[0][0]) and not told.barred(other)
