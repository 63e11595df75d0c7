"""Fourth question: is one of them it? Evidence, nested and twin effects, the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stepid.diagnosis.partial import partial_lead, same_law
from stepid.diagnosis.result import Verdict
from stepid.diagnosis.selection.backward import plainer, replaced, simplified
from stepid.diagnosis.selection.beam import STRONG, Race, extend, finish, first_pairs, generalize, pairs, swap
from stepid.diagnosis.selection.candidate import Candidate, at_floor, is_white, linear_candidate
from stepid.diagnosis.selection.racing import Progress, final, includes, settled, singles, widen
from stepid.diagnosis.selection.split import translated
from stepid.diagnosis.wording import effect_names, length
from stepid.effects.base import Effect
from stepid.fitting.covariance import estimates
from stepid.fitting.input_fault import InputFault, find_input_fault
from stepid.fitting.multistart import Contender, FitContext
from stepid.fitting.outlier_run import Suspect, find_suspect

_PURE = 2.5  # beyond which two effects are tried, and no effect is named that is as free as a disturbance in time
_GATE = 5.0  # below this the linear residual is white and nothing is searched
_TIE = 10.0  # a difference of evidence that does not decide
_MISTAKE = 50.0  # by which a mistake in one run must explain better than an effect that explains everything
_HINT = 5.0  # χ² that a more general effect must gain to count as a rival
_FAINT = 1.05  # below this ratio to the floor only an undisputed name is given
_SURE = 1.03  # times the floor below which the first race is enough
_FAR = 1.5  # times the floor that the best single effect must leave for pairs to race before all singles have
_NEAR = 1.15  # times the floor that a named effect may leave: real plants are never quite the model


@dataclass(frozen=True)
class Judgment:
    """The verdict with what led to it.

    `suspect` is a run to leave out, `doubt` one to look at; `fault` is an input that is not what the records say.
    """

    verdict: Verdict
    chosen: Candidate
    alternatives: tuple[Candidate, ...]
    ranking: tuple[Candidate, ...]
    reasons: tuple[str, ...]
    suspect: Suspect | None = None
    doubt: Suspect | None = None
    fault: InputFault | None = None


def _believable(context: FitContext, linear: Candidate, best: Candidate) -> bool:
    """Tell whether a fit is close enough to the floor for its name; the more effects it needs, the closer."""
    if _slowest(best) * float(np.max(context.records.time)) < 1.0:
        return False  # a "period" longer than every record can imitate anything slow
    if any(e.never_rests for e in best.effects) and best.structure > _PURE and not is_white(context, best, _PURE):
        return False  # a sine with a phase and a start a run comes near many a disturbance that is none
    if len(best.effects) == 1:
        return at_floor(context, best) or best.optimum.rms <= _NEAR * context.floor
    faint = linear.optimum.rms < 2.0 * context.floor and len(best.effects) > 2
    return at_floor(context, best) and not faint


def _slowest(found: Candidate) -> float:
    """Lowest frequency [Hz] among the effects' parameters, infinite where there is none."""
    own = found.optimum.shared[found.optimum.problem.layout.linear.stop :]
    units = [q.unit for e in found.effects for q in e.parameters]
    return min((float(v) for v, unit in zip(own, units, strict=True) if unit == "Hz"), default=math.inf)


def judge(context: FitContext, catalogue: tuple[Effect, ...], progress: Progress) -> Judgment:
    """Search the catalogue for what the linear plant is missing."""
    linear = linear_candidate(context)
    floor, rms = context.floor, linear.optimum.rms
    times = f"The linear model leaves {length(rms)}, {rms / floor:.3g} times the noise floor of {length(floor)}"
    fault = find_input_fault(context)
    if fault is not None:  # what any effect would be fitted to is wrong
        return Judgment("unexplained", linear, (), (linear,), (f"{times}.", fault.words), fault=fault)
    if linear.structure < _GATE and rms < 1.1 * floor:
        return Judgment("adequate", linear, (), (linear,), (f"{times}, and its residual is as white as noise.",))
    alone = singles(context, catalogue, progress)
    ranked = final(context, alone)
    reasons = [f"{times}."]
    if not ranked:
        return Judgment("unexplained", linear, (), (linear,), (*reasons, "No effect of the catalogue could be fitted."))
    best = ranked[0]
    suspect = find_suspect(context, [linear.optimum, *(c.optimum for c in ranked[:2])])
    beaten = suspect is not None and (not at_floor(context, best) or suspect.evidence < best.evidence - _MISTAKE)
    if suspect is not None and beaten and suspect.settles:
        leave = suspect if suspect.sure else None
        return Judgment("unexplained", linear, (), (*ranked, linear), (*reasons, suspect.words), leave, suspect)
    race = None
    if best.optimum.rms > _FAR * floor and suspect is None:  # no single effect is near: two may be
        race = first_pairs(context, alone, catalogue, progress)
    explained = race is not None and race.explained()
    if not explained and (best.optimum.rms > _SURE * floor or best.structure > _GATE):
        # nearly right is not right: let more compete
        alone = widen(context, alone, catalogue, progress)
        ranked = final(context, alone, count=4)
        best = ranked[0]
    leader = next((c for c in alone if c.effects == best.effects), None)
    if leader is not None and not (at_floor(context, best) and is_white(context, best, _PURE)):
        ranked = _accept(ranked, translated(context, leader, catalogue, progress))
        best = ranked[0]
    if not at_floor(context, best) or best.structure > _PURE:
        most = 2 if suspect is not None else 3  # where one run is to blame, ever more effects say little
        ranked = _combine(context, alone, ranked, catalogue, progress, race, most=most)
        ranked = simplified(context, ranked)
    known = [c.effects for c in ranked if c.evidence < ranked[0].evidence + STRONG]
    ranked = replaced(ranked, plainer(context, ranked[0], known, catalogue))
    best = ranked[0]
    everything = tuple(sorted([*ranked, linear], key=lambda c: c.evidence))
    gain = linear.evidence - best.evidence
    if gain < STRONG:
        reasons.append(f"The best candidate, {_title(best)}, gains too little evidence ({gain:.0f}) to be believed.")
        verdict: Verdict = "adequate" if at_floor(context, linear) else "unexplained"
        return Judgment(verdict, linear, (), everything, tuple(reasons))
    if suspect is not None and suspect.mistake is not None and not suspect.rivals:
        unlike = suspect.mistake.single or not at_floor(context, best)  # else an effect of the plant looks like it
        if unlike and suspect.evidence < best.evidence - _MISTAKE:
            return Judgment("unexplained", linear, (), everything, (*reasons, suspect.words), None, suspect)
        if suspect.evidence < best.evidence + _TIE:
            reasons.append(f"A mistake would explain it as well: {suspect.words}")
    rivals = _rivals(context, ranked)
    if not _believable(context, linear, best):
        partial, near = partial_lead(context, linear, ranked)
        if partial is not None:
            words = f"it leaves {length(partial.optimum.rms)}, {partial.optimum.rms / floor:.3g} times the floor"
            reasons.append(
                f"{_title(partial)} alone explains most of the gap, in runs left out of the fit too; {words}: more is "
                "missing, and what repeated runs differ by is no property of the plant."
            )
            if near:
                reasons.append("Not much worse alone: " + ", ".join(_title(c) for c in near) + ".")
            twins = (*near, *(c for c in same_law(context, partial, ranked) if c not in near))
            return Judgment("ambiguous" if near else "named", partial, twins, everything, tuple(reasons))
        reasons.append(
            f"Even the best, {_title(best)}, leaves {best.optimum.rms / floor:.3g} times the floor: "
            "what is missing is not in the catalogue, or is more than it can combine."
        )
        reasons += [suspect.words] if suspect is not None else []
        return Judgment("unexplained", linear, (), everything, tuple(reasons), None, suspect)
    nested = [c for c in rivals if includes(best.effects, c.effects)]
    if nested:  # a law of more parameters leads by too little: the simpler one is named, the rest is undetermined
        best, *rivals = [nested[0], best, *(c for c in rivals if c is not nested[0])]
    reasons.append(f"With {_title(best)} it leaves {best.optimum.rms / floor:.3g} times the floor.")
    foreign = [c for c in rivals if not includes(c.effects, best.effects) and c not in same_law(context, best, ranked)]
    if foreign and rms < _FAINT * floor:
        reasons.append("The gap is too faint to tell its causes apart.")
        return Judgment("adequate", linear, (), everything, tuple(reasons))
    twins = same_law(context, best, ranked)
    if not foreign and twins and best.names != ("coulomb_friction",) and "load_proportional_friction" in best.names:
        best = next((c for c in twins if c.evidence < best.evidence + 1.0), best)
        rivals = [c for c in [ranked[0], *rivals] if c is not best]
    if foreign:
        best, *rest = sorted([best, *rivals], key=lambda c: (int(c.optimum.problem.free.sum()), c.evidence))
        rivals = rest
        reasons.append("The data cannot tell it from " + ", ".join(_title(c) for c in rivals) + ".")
        return Judgment("ambiguous", best, tuple(rivals), everything, tuple(reasons))
    others = [c for c in ranked if c is not best and c not in rivals and not includes(c.effects, best.effects)]
    if others:
        reasons.append(
            f"The next best, {_title(others[0])}, is {others[0].evidence - best.evidence:.0f} worse in evidence."
        )
    if rivals:
        reasons.append(
            "The data leave open whether it is "
            + " or ".join(_title(c) for c in rivals)
            + " instead, which is more general."
        )
    return Judgment("named", best, tuple(rivals), everything, tuple(reasons))


def _combine(
    context: FitContext,
    alone: list[Contender],
    ranked: list[Candidate],
    catalogue: tuple[Effect, ...],
    progress: Progress,
    race: Race | None,
    *,
    most: int,
) -> list[Candidate]:
    """Try two effects, then three where as many are allowed, while the floor is not reached."""
    twos = pairs(context, alone, catalogue, progress, race)
    if twos and settled(context, twos[:1]):
        twos = sorted([*twos, *swap(context, twos, catalogue, progress)], key=lambda c: c.cost)
    done = finish(context, twos)
    ranked = _accept(ranked, done)
    if done and len(ranked[0].effects) == 2:
        wider = generalize(context, twos[0], catalogue, progress)
        ranked = _accept(ranked, finish(context, [twos[0], *wider]))
    if most > 2 and done and not at_floor(context, ranked[0]) and len(ranked[0].effects) == 2:
        threes = extend(context, twos[:2], catalogue, progress)
        ranked = _accept(ranked, finish(context, threes, 2))
    return ranked


def _accept(ranked: list[Candidate], more: list[Candidate]) -> list[Candidate]:
    """Add combinations to a ranking; a further effect leads only where its evidence is strong."""
    best, known = ranked[0], {c.combination for c in ranked}
    more = [c for c in more if c.combination not in known]
    leads = [c for c in more if len(c.effects) <= len(best.effects) or c.evidence < best.evidence - STRONG]
    follows = [c for c in more if c not in leads and c.evidence > best.evidence]
    return sorted([*ranked, *leads, *follows], key=lambda c: c.evidence)


def _rivals(context: FitContext, ranked: list[Candidate]) -> list[Candidate]:
    """Candidates that the data do not tell from the best."""
    best = ranked[0]
    out = []
    for other in ranked[1:]:
        if len(other.effects) > len(best.effects):
            continue
        if includes(other.effects, best.effects):
            # more general: a rival only where its freedom buys some fit, or where nothing fixes it
            bought = (best.optimum.cost - other.optimum.cost) / context.floor**2
            near = other.evidence - best.evidence < 2 * _TIE and (bought > _HINT or _is_open(context, other, best))
            # one may be fitted with fewer parameters of the runs: then the simpler one is not nested in it
            if near or (other.evidence - best.evidence < _TIE and _freedom(other) < _freedom(best)):
                out.append(other)
        elif other.evidence - best.evidence < _TIE:
            out.append(other)
    return out


def _freedom(found: Candidate) -> int:
    """Count fitted parameters, those of the runs included."""
    return int(found.optimum.problem.free.sum() + found.optimum.problem.active.sum())


def _is_open(context: FitContext, found: Candidate, simpler: Candidate) -> bool:
    """Tell whether the data leave open what `found` has beyond `simpler`, which then stands for all of it."""
    values, _ = estimates(found.optimum, found.effects, context.floor)
    more = set(found.names) - set(simpler.names)
    own = [e for name, e in values.items() if name.split(".")[0] in more]
    return all(e.uncertainty is None or e.uncertainty > 0.3 * abs(e.value) for e in own)


def _title(found: Candidate) -> str:
    return effect_names(found.names) or "nothing"
