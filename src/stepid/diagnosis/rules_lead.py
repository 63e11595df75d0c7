"""The rule of what leads where a rest remains, and the answers that others make of it."""

from __future__ import annotations

from dataclasses import replace

from stepid.core.words import length
from stepid.diagnosis.evidence import predicts
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.rule import Answer
from stepid.diagnosis.selection.candidate import Candidate, includes
from stepid.diagnosis.verdict_words import OUTDONE, as_well, better, title
from stepid.diagnosis.wording import taken_in_words


def leads(e: EvidenceRecord, part: Candidate | None = None) -> Answer | None:
    """One effect or two, or a part of the best, predict most of the misfit on runs left out; a rest remains."""
    lead = part or e.lead
    beside = e.beside(lead) if lead.effects else ()
    if not lead.effects or (not part and e.weight(lead, *beside) < e.criteria.sure) or e.open(lead):
        return None
    taken = e.share(lead)
    if not predicts(e.criteria, len(lead.effects), taken):
        return None
    said: tuple[str, ...] = (f"{taken_in_words(lead.names, taken[0])}.",)
    state = e.refuted(lead)
    if state:
        return Answer("unexplained", lead, (), (*said, better(state)))
    if e.outdone(lead):
        return Answer("unexplained", lead, (), (*said, OUTDONE))
    rival = e.rival_elsewhere(lead)
    if rival is not None:
        return Answer("unexplained", lead, (), (*said, as_well(lead, rival)))
    more = "" if e.at_floor(lead) else ": more is missing"
    said += (f"What is left, {length(lead.optimum.rms)}, is {e.times(lead):.3g} times the noise floor{more}.",)
    return with_rivals(e, lead, beside, said) or Answer("named", lead, (), said)


def with_rivals(
    e: EvidenceRecord, found: Candidate, rivals: tuple[Candidate, ...], said: tuple[str, ...]
) -> Answer | None:
    """The answer where others are as good: a more general law that is open as a whole does not dispute the name."""
    if not rivals:
        return None
    others = " or ".join(title(c) for c in rivals)
    undisputed = all(e.stands_for(found, c) for c in rivals)
    words = f"These data do not tell it from {others}, a more general law." if undisputed else ""
    words = words or f"These data do not tell it from {others}."
    return Answer("named" if undisputed else "ambiguous", found, rivals, (*said, words))


def inside(e: EvidenceRecord) -> Answer | None:
    """What leads, where the best leaves only noise by effects that cannot be named: they describe a rest, no plant.

    It is a part of the best. Where what leads is none, that which may be named of the best is asked.
    """
    found = leads(e)
    if found is None or not is_part(found.shown, e.best):
        found = leads(e, e.sure_part) if e.sure_part else None
    return replace(found, rule=leads.__name__) if found else None


def is_part(found: Candidate, best: Candidate) -> bool:
    """Tell whether a candidate has fewer effects than the best, and all of them are in it."""
    return len(found.effects) < len(best.effects) and includes(best.effects, found.effects)


def only_a_lead(e: EvidenceRecord, said: str) -> Answer:
    """What leads, where the best leaves only noise and yet is no answer, for a reason that is told."""
    found = leads(e)
    if found is None:
        return Answer("unexplained", e.best, (), (said,))
    return replace(found, reasons=(*found.reasons, said), rule=leads.__name__)
