"""Whether a law of any shape refutes a lead: made-up laws, and those of plants with one more law than the lead."""

from __future__ import annotations

import pytest

import stepid
from hidden.campaigns import Request, make_campaigns
from made_up_evidence import candidate, evidence
from stepid.diagnosis import gather, refutation
from stepid.diagnosis.free_law import FreeLaw, beside, free_laws
from stepid.effects import resolve
from stepid.fitting.fit import fit_effects, prepare

LINEAR = candidate(times=10.0)


@pytest.mark.parametrize(
    ("names", "states", "share", "told"),
    [
        (["cogging", "cubic_stiffness"], ["position", "position"], 0.9, "position"),  # two follow what neither is
        (["cogging", "quadratic_damping"], ["position", "velocity"], 0.9, ""),
        (["cogging", "cubic_stiffness"], ["position", "position"], 0.4, ""),
        (["cubic_stiffness"], ["position"], 0.9, ""),  # one may be rough
        (["quadratic_damping"], ["velocity"], 0.9, ""),
    ],
)
def test_two_laws_of_one_state_leave_no_rest_of_it(
    names: list[str], states: list[str], share: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    lead = candidate(names, times=3.0)
    e = evidence(lead)
    e.context.coarse_linear, e.context.noise_cost = LINEAR.optimum, 0.0
    slight = 0.1 * e.criteria.rough * LINEAR.optimum.cost
    monkeypatch.setattr(refutation, "free_laws", lambda *_: (FreeLaw("position", share, slight),))
    monkeypatch.setattr(gather, "states_of_all", lambda *_: tuple(frozenset({s}) for s in states))
    assert e.refuted(lead) == told


@pytest.mark.parametrize(
    ("beyond", "state", "told"), [(9.0, "position", "position"), (3.0, "position", ""), (9.0, "velocity", "")]
)
def test_a_law_of_the_leads_own_state_takes_more_than_chance(
    beyond: float, state: str, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    lead = candidate(["cubic_stiffness"], times=3.0)
    e = evidence(lead)
    e.context.coarse_linear, e.context.noise_cost = LINEAR.optimum, 0.0
    much = FreeLaw(state, 0.2, 2 * e.criteria.rough * LINEAR.optimum.cost, beyond, changes=(0.0,))
    monkeypatch.setattr(
        refutation, "free_laws", lambda *_: (much, FreeLaw("velocity", 0.3, much.power, changes=(0.0,)))
    )
    monkeypatch.setattr(gather, "states_of_all", lambda *_: (frozenset({"position"}),))
    assert e.refuted(lead) == told


def test_runs_that_differ_hide_no_shape(monkeypatch: pytest.MonkeyPatch) -> None:
    """The law of any shape is fitted to what the lead leaves with conditions alike in all runs."""
    lead, alike = (
        candidate(["cubic_stiffness"], times=3.0, deviations=["gain"]),
        candidate(["cubic_stiffness"], times=4.0),
    )
    e = evidence(lead)
    e.context.coarse_linear, e.context.noise_cost = LINEAR.optimum, 0.0
    asked = []
    monkeypatch.setattr(refutation, "free_laws", lambda _, optimum: asked.append(optimum) or ())
    monkeypatch.setattr(refutation, "without_deviations", lambda *_: alike.optimum)
    monkeypatch.setattr(gather, "states_of_all", lambda *_: (frozenset({"position"}),))
    assert e.refuted(lead) == ""
    assert asked == [alike.optimum]


@pytest.mark.parametrize(
    ("change", "parts", "states", "told"),
    [
        (-0.98, 2.0, frozenset(), "velocity"),  # a law of any shape does without the memory that the lead has
        (1.5, 2.0, frozenset({"position"}), "velocity"),  # what doubles is not there either
        (-0.2, 2.0, frozenset(), ""),  # more is missing, and the lead stays what it is
        (-0.98, 0.5, frozenset(), ""),  # of too little
        (-0.98, 0.5, frozenset({"velocity"}), ""),  # the law can be the lead
    ],
)
def test_an_effect_stays_what_it_is_beside_a_law_of_another_state(
    change: float, parts: float, states: frozenset[str], told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    lead = candidate(["viscoelastic_spring"], times=3.0)
    e = evidence(lead)
    e.context.coarse_linear, e.context.noise_cost = LINEAR.optimum, 0.0
    law = FreeLaw("velocity", 0.8, parts * e.criteria.rough * LINEAR.optimum.cost, 9.0, changes=(change,))
    monkeypatch.setattr(refutation, "free_laws", lambda *_: (law,))
    monkeypatch.setattr(gather, "states_of_all", lambda *_: (states,))
    assert e.refuted(lead) == told


@pytest.mark.parametrize(
    ("left", "other", "told"),
    [(0.0, 3.6, ""), (0.9, 3.6, ""), (1.1, 3.6, "position"), (0.0, 3.4, "position")],  # the last: one does as the other
)
def test_a_law_refutes_by_what_it_takes_beside_the_strongest(
    left: float, other: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    lead = candidate(["cubic_stiffness"], times=3.0)
    e = evidence(lead)
    e.context.coarse_linear, e.context.noise_cost = LINEAR.optimum, 0.0
    rough = e.criteria.rough * LINEAR.optimum.cost
    drag = FreeLaw("velocity", 0.9, 3 * rough, 9.0, changes=(0.0,))
    spring = FreeLaw("position", 0.6, 2 * rough, 9.0, changes=(0.0,))
    monkeypatch.setattr(refutation, "free_laws", lambda *_: (spring, drag))
    taken = spring._replace(power=left * rough), drag._replace(beyond=other)
    monkeypatch.setattr(refutation, "beside", lambda *of: taken if of[2:] == (spring, drag) else ())
    monkeypatch.setattr(gather, "states_of_all", lambda *_: (frozenset({"position"}),))
    assert e.refuted(lead) == told


@pytest.mark.parametrize(("drags", "remains"), [(True, False), (False, True)])
def test_beside_the_law_that_is_missing_no_other_takes_anything(drags: bool, remains: bool) -> None:
    """A cubic spring leaves the drag, or the end stop: laws of both states follow either, but not beside its own."""
    hidden = ("cubic_stiffness", "quadratic_damping" if drags else "end_stop")
    context = prepare(make_campaigns([Request(11, hidden, None, None, "release")])[0][0])
    fitted = fit_effects(context, resolve(["cubic_stiffness"]))
    assert fitted is not None
    laws = {law.state: law for law in free_laws(context, fitted)}
    spring, drag = laws["position"], laws["velocity"]
    whole = context.coarse_linear.cost - context.noise_cost
    assert (spring.power > 0.005 * whole, drag.power > 0.005 * whole) == (True, True)
    of_spring, of_drag = beside(context, fitted, spring, drag)
    assert (of_spring.power > 0.005 * whole) == remains
    assert (of_drag.power > 0.005 * whole) != remains


def test_a_law_that_is_not_asked_is_what_it_was() -> None:
    context = prepare(make_campaigns([Request(3, ("cubic_stiffness",), None, 8.0, "four")])[0][0])
    law, none = free_laws(context, context.linear)[0], FreeLaw("temperature", 0.5, 1.0)
    assert beside(context, context.linear, law, none) == (law, none)


@pytest.mark.slow
def test_a_law_that_another_stands_in_for_refutes() -> None:
    """An eddy brake had been power damping: where inputs are alike, a drive that changes with velocity is as good."""
    found = stepid.diagnose(make_campaigns([Request(12, (), "eddy_brake", 30.0, None)])[0][0])
    assert found.effects == ()
