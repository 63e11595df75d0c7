"""Whether a law of any shape refutes a lead: what a lead leaves has another shape, or makes of the lead another law."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.free_law import FreeLaw, allowed, beside, free_laws
from stepid.diagnosis.selection.candidate import Candidate
from stepid.fitting.levenberg_marquardt import Optimum

if TYPE_CHECKING:
    from stepid.diagnosis.gather import EvidenceRecord

_States = tuple[frozenset[str], ...]


def refuted(told: EvidenceRecord, lead: Candidate) -> str:
    """The state of which a law of another shape refutes a lead, '' where none does.

    It takes most of the rest, or more than chance does, and more than real laws are rough. Of the lead's own state
    it shows another shape; two effects of one state follow one that neither has. Beside a law of another state an
    effect must keep its size, or stands in for that law. Its parameters must be the same in all conditions.

    The law that takes most is asked as it is, others for what they take beside it, where it is needed beside them: what
    is missing changes the whole motion, so that each state shows some of it.

    Where runs differ both fits are asked: conditions that do may take a part of a shape, and where they are alike what
    runs differ by may drown it. What they explain is no misfit of the lead's, which is rough by what it has to explain.
    """
    parts = {lead.alike(told.context): 1.0, lead.optimum: told.left_out.part_of_effects(lead)}
    return next(filter(None, (_refuted_by(told, lead, fit, part) for fit, part in parts.items())), "")


def _refuted_by(told: EvidenceRecord, lead: Candidate, fit: Optimum, part: float) -> str:
    """The state of which a law of another shape refutes a lead by what one of its fits leaves, '' where none does.

    `part` is that of the misfit's power which is left to the lead to explain.
    """
    states = told.states(lead)
    chance, rough = allowed(told.context, told.criteria, lead, noise=told.at_floor(lead), part=part)
    laws = sorted(free_laws(told.context, fit), key=lambda one: -one.power)
    for law in laws:
        if not law.is_seen(chance, rough):
            continue
        own = law.own or any(law.states <= state for state in states)
        if own and len(states) > 1 and set(states) == {law.states}:
            return law.state
        if law.power <= rough or not (own or _replaces(law, states, told.criteria)):
            continue
        if law is laws[0] or law.own or _stands(told, fit, law, laws[0], rough):
            return law.state
    return ""


def _stands(told: EvidenceRecord, fit: Optimum, law: FreeLaw, strongest: FreeLaw, rough: float) -> bool:
    """Tell whether a law takes something beside the strongest, or that no more beside it than chance does."""
    own, needed = beside(told.context, fit, law, strongest)
    return own.power > rough or needed.beyond <= told.criteria.shape


def _replaces(law: FreeLaw, states: _States, criteria: Criteria) -> bool:
    """Tell whether a law of any shape leaves an effect of another state not what it is."""
    changes = zip(states, law.changes, strict=True)
    return any(state != law.states and abs(change) > criteria.open for state, change in changes)
