"""Whether a law of any shape refutes a lead: made-up laws, and those of plants with one more law than the lead."""

from __future__ import annotations

from typing import Any

import pytest

import stepid
from hidden.campaigns import Request, make_campaigns
from made_up_evidence import LINEAR, candidate, evidence, law_of, leaving, with_rest
from stepid.diagnosis import gather, refutation
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.free_law import FreeLaw, beside, free_laws
from stepid.diagnosis.left_out import LeftOut
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects

CRITERIA = Criteria()


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
    e = leaving(law_of("position", 0.1, share=share, beyond=0.0), names=names, states=states, monkeypatch=monkeypatch)
    assert e.refuted(e.candidates[0]) == told


def test_runs_that_differ_hide_no_shape(monkeypatch: pytest.MonkeyPatch) -> None:
    """The law of any shape is fitted to what the lead leaves with conditions alike in all runs, and with its own."""
    lead, alike = (
        candidate(["cubic_stiffness"], times=3.0, deviations=["gain"]),
        candidate(["cubic_stiffness"], times=4.0),
    )
    e = evidence(lead)
    with_rest(e)
    asked = []
    monkeypatch.setattr(refutation, "free_laws", lambda _, optimum: asked.append(optimum) or ())
    near: list[tuple[Any, float]] = []
    fitted = "stepid.diagnosis.selection.candidate.without_deviations"
    monkeypatch.setattr(fitted, lambda *given: near.append(given) or alike.optimum)
    monkeypatch.setattr(gather, "states_of_all", lambda *_: (frozenset({"position"}),))
    monkeypatch.setattr(LeftOut, "part_of_effects", lambda *_: 1.0)
    assert e.refuted(lead) == ""
    assert asked == [alike.optimum, lead.optimum]
    assert near == [(lead.optimum, 1e-3 * lead.optimum.cost)]  # as near as matters beside what it leaves


@pytest.mark.parametrize(
    ("with_them", "without", "part", "told"),
    [
        (0.9, 0.4, 1.0, "position"),
        (0.4, 0.9, 1.0, "position"),
        (0.4, 0.4, 1.0, ""),
        (0.9, 0.4, 3.0, ""),  # as rough as a law is that has so much to explain
        (0.4, 0.9, 3.0, "position"),  # of what all runs leave, with runs alike
    ],
)
def test_a_shape_that_either_fit_shows_refutes(
    with_them: float, without: float, part: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What runs differ by drowns a shape where it is left, and may take a part of one where it is not."""
    lead, alike = candidate(["cubic_stiffness"], deviations=["gain"], times=3.0), candidate(times=4.0)
    e = evidence(lead)
    with_rest(e)
    shares = {alike.optimum: without, lead.optimum: with_them}
    monkeypatch.setattr(
        refutation, "free_laws", lambda _, fit: (law_of("position", 2.0, share=shares[fit], beyond=0.0),)
    )
    monkeypatch.setattr("stepid.diagnosis.selection.candidate.without_deviations", lambda *_: alike.optimum)
    monkeypatch.setattr(gather, "states_of_all", lambda *_: (frozenset({"position"}),))
    monkeypatch.setattr(LeftOut, "part_of_effects", lambda *_: part)
    assert e.refuted(lead) == told


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
    law = law_of("velocity", parts, share=0.8, change=change)
    e = leaving(law, names=["viscoelastic_spring"], states=[""], monkeypatch=monkeypatch)
    monkeypatch.setattr(gather, "states_of_all", lambda *_: (states,))
    assert e.refuted(e.lead) == told


@pytest.mark.parametrize(
    ("left", "other", "told"),
    [(0.0, 3.6, ""), (0.9, 3.6, ""), (1.1, 3.6, "position"), (0.0, 3.4, "position")],  # the last: one does as the other
)
def test_a_law_refutes_by_what_it_takes_beside_the_strongest(
    left: float, other: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    drag, spring = law_of("velocity", 3.0, share=0.9), law_of("position", 2.0, share=0.6)
    e = leaving(spring, drag, states=["position"], monkeypatch=monkeypatch)
    taken = law_of("position", left, share=0.6), drag._replace(beyond=other)
    monkeypatch.setattr(refutation, "beside", lambda *of: taken if of[2:] == (spring, drag) else ())
    assert e.refuted(e.lead) == told


@pytest.mark.parametrize(
    ("law", "refuted"),
    [
        (law_of("position", 1.1), "position"),
        (law_of("position", 1.0), ""),  # as rough as real laws are
        (law_of("position", 2.0, beyond=CRITERIA.shape), ""),  # as chance may take
        (law_of("position", 2.0, beyond=CRITERIA.shape + 0.01), "position"),
        (law_of("position", 2.0, share=0.5, beyond=0.0), ""),  # half is not most
        (law_of("position", 2.0, share=0.51, beyond=0.0), "position"),
        (law_of("velocity", 2.0, change=CRITERIA.open), ""),  # what changes by half may be there
        (law_of("velocity", 2.0, change=-0.51), "velocity"),
        (law_of("position and velocity", 2.0), ""),  # more than the lead is a law of
    ],
)
def test_a_lead_is_refuted_beyond_its_limits_only(law: FreeLaw, refuted: str, monkeypatch: pytest.MonkeyPatch) -> None:
    e = leaving(law, states=("position",), monkeypatch=monkeypatch)
    assert e.refuted(e.lead) == refuted


def test_overtones_are_the_leads_own_whatever_it_is_a_law_of(monkeypatch: pytest.MonkeyPatch) -> None:
    law = law_of("time", 2.0)._replace(own=True)
    e = leaving(law, states=("position",), monkeypatch=monkeypatch)
    assert e.refuted(e.lead) == "time"
    e = leaving(law._replace(own=False), states=("position",), monkeypatch=monkeypatch)
    assert e.refuted(e.lead) == ""


def test_the_law_that_takes_most_refutes(monkeypatch: pytest.MonkeyPatch) -> None:
    laws = [law_of("velocity", 2.0, change=1.0), law_of("position", 3.0), law_of("input and time", 2.5, change=1.0)]
    e = leaving(*laws, states=("position",), monkeypatch=monkeypatch)
    assert e.refuted(e.lead) == "position"


def test_a_law_of_the_state_of_one_of_two_effects_is_no_patchwork(monkeypatch: pytest.MonkeyPatch) -> None:
    slight = law_of("position", 0.1, share=0.9)._replace(changes=(0.0, 0.0))
    for states, refuted in ((("position", "position"), "position"), (("position", "velocity"), "")):
        e = leaving(slight, states=states, monkeypatch=monkeypatch)
        assert e.refuted(e.lead) == refuted


def test_roughness_is_a_share_of_the_misfit_without_the_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    half = 0.5 * LINEAR.optimum.cost
    for noise, refuted in ((half, "position"), (0.0, "")):
        e = leaving(law_of("position", 0.75), states=("position",), monkeypatch=monkeypatch, noise=noise)
        assert e.refuted(e.lead) == refuted


@pytest.mark.parametrize(
    ("law", "refuted"),
    [
        (law_of("position", 0.001, beyond=CRITERIA.shape + 0.01), "position"),  # exact laws leave only noise
        (law_of("position", 0.001, beyond=CRITERIA.shape), ""),
        (law_of("position", 0.001, share=0.9, beyond=0.0), ""),  # most of next to nothing
        (law_of("velocity", 0.001, change=0.6), "velocity"),
        (law_of("velocity", 0.001, change=0.4), ""),
    ],
)
def test_a_lead_as_small_as_the_noise_has_no_room_for_roughness(
    law: FreeLaw, refuted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    e = leaving(law, states=("position",), monkeypatch=monkeypatch)
    assert e.refuted(candidate(["cubic_stiffness"])) == refuted


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


@pytest.mark.slow
def test_a_law_is_none_of_the_catalogues_where_gains_differ_as_well() -> None:
    """An eddy brake beside gains that differ had been power damping, which led with 97 % on runs left out."""
    request = Request(94392106157978, (), "eddy_brake", None, "four", ("gain",))
    found = stepid.diagnose(make_campaigns([request])[0][0])
    assert found.effects == ()
    assert "velocity" in found.summary()
