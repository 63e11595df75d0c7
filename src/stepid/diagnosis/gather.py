"""What speaks for and against an answer, gathered once: the verdict's rules only read it.

What a rule asks for that is not here yet becomes a method here; the tests' `made_up_evidence.Told` answers it, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from stepid.core.estimate import Estimate
from stepid.diagnosis.calibration import PROBABILITY
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import Weighed, at_floor, bought_by_freedom, chosen_at, is_white, weigh
from stepid.diagnosis.exchangeable import Condition, followed_condition
from stepid.diagnosis.free_law import followed
from stepid.diagnosis.lead import Leads
from stepid.diagnosis.left_out import LeftOut
from stepid.diagnosis.loud_noise import is_noise
from stepid.diagnosis.refutation import refuted
from stepid.diagnosis.selection.candidate import Candidate, includes, is_free
from stepid.diagnosis.shared_weight import weight_of
from stepid.diagnosis.states import patchwork, states_of_all
from stepid.diagnosis.vetoes import barred, imitators, open_parameters, undetermined, unseen
from stepid.fitting.input_fault import InputFault
from stepid.fitting.multistart import FitContext
from stepid.fitting.profile import limited
from stepid.fitting.random_effects import sizes_of_scatter
from stepid.fitting.record_fault import RecordFault

if TYPE_CHECKING:
    from stepid.diagnosis.verdict import Answer


@dataclass(frozen=True)
class EvidenceRecord:
    """One campaign's evidence.

    Parameters
    ----------
    context : FitContext
    criteria : Criteria
    candidates : tuple of Candidate
        All that were fitted to all samples, the linear plant among them.
    input_fault : InputFault or None
    faults : tuple of RecordFault
        Of single runs and of the readings.
    """

    context: FitContext
    criteria: Criteria
    candidates: tuple[Candidate, ...]
    input_fault: InputFault | None = None
    faults: tuple[RecordFault, ...] = ()

    @cached_property
    def weighed(self) -> tuple[Weighed, ...]:
        """All candidates, best first."""
        return tuple(weigh(self.context, self.candidates))

    @cached_property
    def linear(self) -> Candidate:
        """The linear plant."""
        return next(c for c in self.candidates if not c.effects and not c.deviations)

    @cached_property
    def best(self) -> Candidate:
        """The simplest of the best: a further effect must earn more than chance does, and imitators stand back.

        So does one whose scatter is `systematic`, a law, where another whose is not is more likely.
        A linear plant whose runs differ, and no worse than a tie, is simpler than a law that takes the place of that.
        """
        able = tuple(w for w in self.weighed if not self.imitators(w.candidate)) or self.weighed
        found = self.simplest(able)
        if not self.at_floor(found.candidate):
            return self.simplest(self.weighed).candidate
        if self.systematic(found.candidate):
            likelier = (w for w in able if w.loss < found.loss and self.at_floor(w.candidate))
            found = self.simplest(tuple(w for w in likelier if not self.systematic(w.candidate)) or (found,))
        if not found.candidate.effects:
            return found.candidate
        near = tuple(w for w in self._scattered if w in able and w.loss < found.loss + self.criteria.tie)
        return self.simplest(near or (found,)).candidate

    @property
    def plain(self) -> Candidate:
        """The simplest of the best linear plants, whose runs may differ."""
        return self.simplest(tuple(w for w in self.weighed if not w.candidate.effects)).candidate

    @cached_property
    def without_free(self) -> EvidenceRecord:
        """The same without candidates that have a freedom of their own in every run."""
        return replace(self, candidates=tuple(c for c in self.candidates if not is_free(c)))

    @cached_property
    def _scattered(self) -> tuple[Weighed, ...]:
        """Linear plants that are enough where runs differ, by no law."""
        plain = (w for w in self.weighed if w.candidate.deviations and not w.candidate.effects)
        return tuple(w for w in plain if self.at_floor(w.candidate) and not self.systematic(w.candidate))

    @property
    def likeliest(self) -> Candidate:
        """The candidate of most evidence, also where it cannot be named."""
        return self.weighed[0].candidate

    def simplest(self, weighed: tuple[Weighed, ...]) -> Weighed:
        """The best of some, where each further effect or condition must earn more than chance does."""
        return min(weighed, key=lambda w: w.loss + chosen_at(self.criteria, w.candidate))

    def at_floor(self, found: Candidate) -> bool:
        """Tell whether a candidate leaves nothing but noise."""
        return at_floor(self.context, self.criteria, found)

    @cached_property
    def white(self) -> bool:
        """Whether the linear plant leaves noise of the floor's size, white where the readings' noise is."""
        colored = self.context.colored is not None
        return self.at_floor(self.linear) and (colored or is_white(self.context, self.linear, self.criteria.white))

    @property
    def faint(self) -> float:
        """Times the floor that the linear plant must leave for a name: more where colored noise is known less well."""
        return self.criteria.faint if self.context.colored is None else self.criteria.near

    def times(self, found: Candidate) -> float:
        """RMS over the noise floor."""
        return found.optimum.rms / self.context.floor

    @cached_property
    def rivals(self) -> tuple[Candidate, ...]:
        """Candidates that the data do not tell from the best, no effect `unseen`, best first, one for each set."""
        best = self.best
        own = next(w.loss for w in self.weighed if w.candidate is best)
        out: dict[frozenset[str], Candidate] = {}
        for w in self.weighed:
            other = w.candidate
            names = frozenset(other.names)
            needless = len(other.effects) > len(best.effects) and not self._takes_scatter(other)
            if names == frozenset(best.names) or names in out or not names or needless:
                continue
            if self._rivals(other, w.loss - own) and not self.unseen(other):
                out[names] = other
        return tuple(out.values())

    def _takes_scatter(self, other: Candidate) -> bool:
        """Tell whether one effect more takes most of what runs differ by under the best: it is a law, or they do."""
        best = self.best
        further = includes(other.effects, best.effects) and len(other.effects) == len(best.effects) + 1
        if not (further and best.deviations >= other.deviations):
            return False
        own, less = (sizes_of_scatter(c.optimum) for c in (best, other))
        return any(less.get(kind, 0.0) < size / 2 for kind, size in own.items())

    def _rivals(self, other: Candidate, loss: float) -> bool:
        best, criteria = self.best, self.criteria
        if len(other.effects) <= len(best.effects) and includes(other.effects, best.effects):
            # more general: a rival only where its freedom buys some fit, or where nothing fixes it
            bought = bought_by_freedom(self.context, self.candidates, best, other)
            if loss < 2 * criteria.tie and (bought > criteria.rival or self._is_open(other, best)):
                return True
            # of the noise's size: what sets the laws apart is below it
            return loss < criteria.tie and not (self.undetermined or best.deviations) and self.times(self.linear) < 2
        return loss < criteria.tie

    @cached_property
    def simpler(self) -> tuple[Candidate, ...]:
        """The nearest candidate of as many, simpler effects that the best one contains, and that leads.

        Where no run can be left out, one that comes near the floor.
        """
        names, best = frozenset(self.best.names), self.best
        inside = [w.candidate for w in self.weighed if includes(best.effects, w.candidate.effects)]
        alike = [c for c in inside if len(c.effects) == len(best.effects) and frozenset(c.names) != names]
        alike = [c for c in alike if not self.unseen(c)]
        return next(((c,) for c in alike if self._stands_alone(c)), ())

    def _stands_alone(self, found: Candidate) -> bool:
        """Tell whether a candidate predicts, or comes near the floor where no run can be left out."""
        if self.judges(found):
            return self.leads.predicts(found)
        return self.times(found) <= 2 * self.criteria.near

    def stands_for(self, simple: Candidate, general: Candidate) -> bool:
        """Tell whether a candidate is inside another of as many effects whose freedom the data leave open."""
        alike = len(general.effects) == len(simple.effects) and includes(general.effects, simple.effects)
        return alike and self._is_open(general, simple)

    def _is_open(self, found: Candidate, simpler: Candidate) -> bool:
        """Tell whether the data leave open all that `found` has beyond `simpler`, which then stands for it."""
        open_ = undetermined(self.context, self.criteria, found)  # that a strength is not zero says nothing of the rest
        more = (e for e in found.effects if e.name not in simpler.names)
        return all(f"{e.name}.{q.name}" in open_ for e in more for q in e.parameters)

    def probability(self, answer: Answer) -> float | None:
        """Probability that an answer holds the truth; None where no effect is named."""
        return PROBABILITY.get(answer.rule) if answer.verdict in ("named", "ambiguous") else None

    @cached_property
    def undetermined(self) -> tuple[str, ...]:
        """Parameters of the best candidate's effects that the data do not determine."""
        return self.open(self.best)

    def open(self, found: Candidate) -> tuple[str, ...]:
        """Parameters of a candidate's effects that the data leave open on the side on which the effect is absent."""
        return open_parameters(self.context, self.criteria, found)

    def limited(self, found: Candidate) -> dict[str, Estimate]:
        """Parameters that the data limit on that side only, where no rest remains that would limit them, too."""
        names = undetermined(self.context, self.criteria, found) if self.at_floor(found) else ()
        return limited(found.optimum, found.effects, self.context.floor, names) if names else {}

    def imitators(self, found: Candidate) -> dict[str, str]:
        """Effects that a linear parameter, or what the records do not tell from it, can stand in for."""
        return imitators(self.context, self.criteria, found)

    def unseen(self, found: Candidate) -> dict[str, str]:
        """Effects of which the records are too short to show what sets them apart."""
        return unseen(self.context, self.criteria, found)

    def barred(self, found: Candidate) -> bool:
        """Tell whether a candidate may not be named: something else stands in for an effect, or it is open."""
        return barred(self.context, self.criteria, found)

    @cached_property
    def leads(self) -> Leads:
        """Candidates that may lead where a rest remains."""
        return Leads(self)

    @property
    def lead(self) -> Candidate:
        """The best of them, with no more in it than takes a notable part."""
        return self.leads.best

    def beside(self, lead: Candidate) -> tuple[Candidate, ...]:
        """Candidates that the data do not tell from a lead."""
        return self.leads.beside(lead)

    @property
    def sure_part(self) -> Candidate | None:
        """What may be named of the best, where not all of it may."""
        return self.leads.sure_part

    def outdone(self, lead: Candidate) -> bool:
        """Tell whether another oscillation beside the plant's own outdoes a lead."""
        return self.leads.outdone(lead)

    def rival_elsewhere(self, lead: Candidate) -> Candidate | None:
        """A law of another state that what is missing beside a lead may have put behind it, None where none is."""
        return self.leads.rival_elsewhere(lead)

    def refuted(self, lead: Candidate) -> str:
        """The state of which a law of another shape refutes a lead, '' where none does."""
        return refuted(self, lead)

    def states(self, found: Candidate) -> tuple[frozenset[str], ...]:
        """States that each effect of a candidate is a law of."""
        return states_of_all(self.context, found.optimum)

    def followed(self, found: Candidate) -> str:
        """The state that what is as small as the noise follows by more than chance, '' where there is none."""
        part = self.left_out.part_of_effects(found)
        return law.state if (law := followed(self.context, self.criteria, found, part)) else ""

    def is_noise(self, found: Candidate) -> bool:
        """Tell whether a rest is noise: there where the cart rests, too, and no part of it follows a law."""
        return is_noise(self.context, self.criteria, found)

    def judges(self, found: Candidate) -> bool:
        """Tell whether what a candidate takes on runs left out says anything."""
        return self.left_out.judges(found)

    def systematic(self, found: Candidate) -> Condition | None:
        """Condition that what runs differ by under a candidate goes with, more than drawn runs would."""
        one = followed_condition(found.optimum, self.context.floor) if found.deviations else None
        return one if one is not None and one.beyond > self.criteria.shape else None

    def patchwork(self, found: Candidate) -> str:
        """The state of which effects of a candidate together follow a law of any shape, '' where there is none."""
        return patchwork(self.context, found.optimum, self.states(found))

    def weight(self, *found: Candidate) -> float:
        """Weight of all candidates that hold the effects of one of some, or effects that contain them."""
        return weight_of(self, found)

    @cached_property
    def left_out(self) -> LeftOut:
        """What candidates predict of runs that their fit did not see."""
        return LeftOut(self)

    def share(self, found: Candidate) -> tuple[float, float]:
        """Share of the misfit's repeatable power that a candidate takes on runs left out, 0 without any; steadiness."""
        return self.left_out.share(found)

    def share_of_free(self, found: Candidate) -> float:
        """Share of what its other effects leave that a candidate's effects with a freedom in every run take there."""
        return self.left_out.share_of_free(found)
