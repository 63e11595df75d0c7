"""Where a rest remains laws of one state are told apart no finer than real laws are rough."""

from __future__ import annotations

import pytest

from made_up_evidence import candidate, evidence
from stepid.diagnosis import gather, vetoes
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.left_out import LeftOut
from stepid.diagnosis.selection.candidate import Candidate


def test_where_a_rest_remains_a_law_of_the_same_state_as_rough_as_real_ones_stands_beside(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    states = {"quadratic_damping": frozenset({"velocity"})}
    told = lambda _, optimum: (states.get(optimum.name, frozenset({"position"})),)  # noqa: E731
    monkeypatch.setattr(gather, "states_of_all", told)

    def law(name: str, left: float) -> Candidate:
        """Leaves so many floors squared of a misfit of 99."""
        found = candidate([name], times=left**0.5)
        found.optimum.name = name
        return found

    lead, alike, rougher = law("cubic_stiffness", 9.0), law("sine_stiffness", 9.25), law("quadratic_stiffness", 9.6)
    damping = law("quadratic_damping", 9.45)
    e = evidence(lead, alike, rougher, damping)
    assert e.lead is lead
    assert min(w.loss for w in e.weighed if w.candidate is alike) > e.criteria.tie
    assert e.beside(e.lead) == (alike,)
    strict = evidence(lead, alike, criteria=Criteria(rough=0.002))
    assert strict.beside(strict.lead) == ()
    found = [Candidate(c.effects, frozenset({"gain"}), c.optimum, 0.0) for c in (lead, alike)]
    for part, beside in ((1.0, (found[1],)), (0.5, ())):  # of what the gains leave it to explain
        monkeypatch.setattr(LeftOut, "part_of_effects", lambda *_, told=part: told)
        assert evidence(*found).beside(found[0]) == beside
    near = evidence(law("cubic_stiffness", 1.1), law("sine_stiffness", 1.18))  # no rest remains
    assert near.lead.names == ("cubic_stiffness",)
    assert near.beside(near.lead) == ()
