"""Evidence that is gathered: rivals, leads, weights and shares."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from made_up_evidence import FLOOR, RUNS, SAMPLES, candidate, evidence
from stepid.diagnosis import free_law, gather, lead, left_out, states, vetoes
from stepid.diagnosis.free_law import FreeLaw
from stepid.diagnosis.selection.candidate import Candidate, includes
from stepid.effects import resolve

LINEAR = candidate(times=10.0)
FRICTION = candidate(["coulomb_friction"])
PLAY = candidate(["free_play"])


@pytest.fixture(autouse=True)
def _all_is_determined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    monkeypatch.setattr(left_out, "starts_kept", lambda *_: frozenset())
    monkeypatch.setattr(left_out, "judging", lambda *_: range(RUNS))
    monkeypatch.setattr(left_out, "held_out_residuals", as_much_as_is_left)
    monkeypatch.setattr(left_out, "repeatability", lambda *_: None)


def as_much_as_is_left(optimum: Any, **_: object) -> dict[int, np.ndarray]:
    """Of a run left out a candidate leaves as much as of all."""
    return {i: optimum.residual[SAMPLES * i : SAMPLES * (i + 1)] for i in range(RUNS)}


def test_rivals_are_no_larger_than_the_best_and_told_once() -> None:
    two = candidate(["cogging", "sensor_drift"])
    again = replace(candidate(["free_play"]), deviations=frozenset({"gain"}))
    e = evidence(FRICTION, PLAY, again, two)
    assert [c.names for c in e.rivals] == [("free_play",)]


def test_the_order_of_effects_is_no_difference() -> None:
    e = evidence(candidate(["cogging", "sensor_drift"]), candidate(["sensor_drift", "cogging"]))
    assert e.rivals == ()


def test_an_imitator_is_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    imitated = {"cogging": "the spring"}
    monkeypatch.setattr(gather, "imitators", lambda *a: imitated if "cogging" in a[2].names else {})
    e = evidence(candidate(["cogging"], times=2.0), candidate(["quadratic_damping"], times=2.5))
    assert e.likeliest.names == e.best.names == ("cogging",)  # where nothing is at the floor, none is named by that
    assert e.lead.names == ("quadratic_damping",)
    assert e.weight(e.lead) > 0.99
    e = evidence(candidate(["cogging"]), candidate(["cubic_stiffness"], times=1.04))
    assert e.likeliest.names == ("cogging",)
    assert e.best.names == ("cubic_stiffness",)


def test_a_lead_has_two_effects_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    three = candidate(["cogging", "free_play", "sensor_drift"], times=1.5)
    assert evidence(three, candidate(["cogging", "free_play"], times=2.0)).lead.names == ("cogging", "free_play")


def test_a_lead_has_no_more_in_it_than_takes_a_notable_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    alone, pair = (candidate(n, times=t) for n, t in ((["free_play"], 3.0), (["free_play", "cogging"], 2.5)))
    assert evidence(alone, pair).best is pair
    assert evidence(alone, pair).lead is alone
    much = candidate(["free_play", "cogging"], times=1.2)
    assert evidence(alone, much).lead is much


def test_of_laws_as_good_the_simplest_leads_and_its_twins_stand_beside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    simple, general, twin = (
        candidate([n], times=3.0) for n in ("quadratic_damping", "power_damping", "position_dependent_damping")
    )
    e = evidence(general, simple, twin, candidate(["cogging"], times=4.0))
    assert e.lead is simple
    assert e.beside(e.lead) == (twin,)
    assert e.weight(e.lead, *e.beside(e.lead)) > 0.99


def test_the_weight_of_a_law_holds_that_of_the_laws_that_contain_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    simple, general, other = (candidate([n]) for n in ("coulomb_friction", "stribeck_friction", "free_play"))
    e = evidence(simple, general, other)
    assert e.weight(simple) == pytest.approx(1 - e.weight(other))
    assert e.weight(general) < e.weight(simple)


def test_what_may_not_be_named_takes_no_weight_however_much_it_explains(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        gather, "imitators", lambda *told: {"cogging": "the spring"} if "cogging" in told[2].names else {}
    )
    imitator, better, worse = (
        candidate([name], times=times)
        for name, times in (("cogging", 1.0), ("free_play", 7.0), ("coulomb_friction", 9.0))
    )
    e = evidence(imitator, better, worse)
    losses = [w.loss for w in e.weighed]
    assert losses[1] > 1400  # beyond the smallest weight beside the imitator's
    assert losses[2] - losses[1] > 20
    assert e.weight(better) == pytest.approx(1.0, abs=1e-4)


def test_a_share_is_of_what_repeats(monkeypatch: pytest.MonkeyPatch) -> None:
    e = evidence(FRICTION)
    before = {i: np.full(100, 10 * FLOOR) for i in range(RUNS)}
    after = {i: np.full(100, (4 if i else 2) * FLOOR) for i in range(RUNS)}
    monkeypatch.setattr(
        left_out, "held_out_residuals", lambda optimum, **_: after if optimum is FRICTION.optimum else before
    )
    share, steady = e.share(FRICTION)
    assert share == pytest.approx(1 - (3 * 15 + 3) / (4 * 99))
    assert steady == pytest.approx((1 - 15 / 99) / (1 - 3 / 99))


def test_a_run_that_shows_no_misfit_says_nothing_of_how_steady_an_answer_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """A release shows nothing of what acts on the drive: by chance it had made the answer unsteady."""
    e = evidence(FRICTION)
    before = {i: np.full(100, (10.0 if i else 1.05) * FLOOR) for i in range(RUNS)}
    after = {i: np.full(100, (2.0 if i else 1.05) * FLOOR) for i in range(RUNS)}
    monkeypatch.setattr(
        left_out, "held_out_residuals", lambda optimum, **_: after if optimum is FRICTION.optimum else before
    )
    assert e.share(FRICTION)[1] == pytest.approx(1.0)


def test_two_fits_are_held_against_runs_that_judge_both(monkeypatch: pytest.MonkeyPatch) -> None:
    able = {id(FRICTION.optimum): [1], id(LINEAR.optimum): [0, 1, 2]}
    asked: list[list[int]] = []

    def left(optimum: Any, *, among: list[int], **_: object) -> dict[int, np.ndarray]:
        asked.append(among)
        return dict.fromkeys(among, optimum.residual[:SAMPLES])

    monkeypatch.setattr(left_out, "judging", lambda optimum, *_: able[id(optimum)])
    monkeypatch.setattr(left_out, "held_out_residuals", left)
    before, after = evidence(FRICTION).left_out.of_two(LINEAR.optimum, FRICTION.optimum)
    assert (asked, [*before], [*after]) == ([[1], [1]], [1], [1])


def test_what_repeats_differ_by_is_what_free_conditions_leave_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gains that differ by 10 floors and are free are in neither residual: what is left is no repeats'."""
    e = evidence(FRICTION)
    before, after = ({i: np.full(100, times * FLOOR) for i in range(RUNS)} for times in (15.0, 9.0))
    monkeypatch.setattr(
        left_out, "held_out_residuals", lambda optimum, **_: after if optimum is FRICTION.optimum else before
    )
    asked: list[Any] = []
    monkeypatch.setattr(left_out, "repeatability", lambda records, left: asked.append(left))
    assert e.share(FRICTION)[0] == pytest.approx(1 - (81 - 1) / (225 - 1))
    assert asked[0] is e.linear.optimum.residual


def test_includes() -> None:
    coulomb, stribeck, play = resolve(["coulomb_friction", "stribeck_friction", "free_play"])
    assert includes((stribeck,), (coulomb,))
    assert includes((coulomb, play), (coulomb,))
    assert not includes((coulomb,), (stribeck,))
    assert includes((coulomb,), ())


def test_the_law_that_weighty_candidates_share_leads() -> None:
    laws = (["sine_stiffness", "asymmetric_friction"], ["sine_stiffness", "coulomb_friction"])
    best, shared = (candidate(names, times=3.0 + 0.01 * i) for i, names in enumerate(laws))
    e = evidence(best, shared, candidate(["sine_stiffness", "coulomb_friction", "flexible_coupling"], times=2.9))
    assert e.weight(best) < e.criteria.sure <= e.weight(shared)
    assert e.lead.names == shared.names


def test_three_laws_of_one_state_are_a_patchwork(monkeypatch: pytest.MonkeyPatch) -> None:
    three, mixed = (candidate(["cogging", "end_stop", other]) for other in ("cubic_stiffness", "quadratic_damping"))
    velocity = {"quadratic_damping": "velocity"}
    monkeypatch.setattr(
        gather, "states_of_all", lambda _, o: tuple(frozenset({velocity.get(n, "position")}) for n in o.names)
    )
    monkeypatch.setattr(states, "cancelling", lambda *_: "")
    for found in (three, mixed, PLAY):
        found.optimum.names = found.names  # type: ignore[attr-defined]
    e = evidence(three)
    assert [e.patchwork(c) for c in (three, mixed, PLAY)] == ["position", "", ""]


@pytest.mark.parametrize(("every", "told"), [(4.0, "position"), (3.0, "")])
def test_a_law_among_decimated_samples_is_one_of_all_samples(
    every: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    e = evidence(FRICTION)
    e.context.decimated = object()

    def laws(context: Any, _: Any, records: Any = None) -> tuple[FreeLaw, ...]:
        return (FreeLaw("position", 0.1, 1e-12, 9.0 if records is None else every),)

    monkeypatch.setattr(free_law, "free_laws", laws)
    assert e.followed(FRICTION) == told


@pytest.mark.parametrize(("beyond", "told"), [(4.0, "velocity"), (3.0, "")])
def test_what_a_complete_model_leaves_follows_no_state(
    beyond: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What takes less by chance is no law, however much it takes."""
    laws = FreeLaw("position", 0.9, 1.0, 1.0), FreeLaw("velocity", 0.1, 1e-12, beyond)
    monkeypatch.setattr(free_law, "free_laws", lambda *_: laws)
    assert evidence(FRICTION).followed(FRICTION) == told


def test_a_law_that_takes_too_little_hides_none_that_takes_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside noise that is not known a law has to take power as well: the most certain one may not."""
    laws = FreeLaw("time", 0.1, 1e-30, 9.0, own=True), FreeLaw("velocity", 0.2, 1.0, 7.0)
    monkeypatch.setattr(free_law, "free_laws", lambda *_: laws)
    monkeypatch.setattr(free_law, "allowed", lambda *_, **__: (5.0, 1e-20))
    assert evidence(FRICTION).followed(FRICTION) == "velocity"


def predicting(monkeypatch: pytest.MonkeyPatch, *those: Candidate) -> None:
    """Of runs left out some candidates leave as much as of all, and the others as much as the linear plant."""
    optima = [c.optimum for c in (LINEAR, *those)]

    def left(optimum: Any, **_: object) -> dict[int, np.ndarray]:
        known = any(optimum is one for one in optima)
        return as_much_as_is_left(optimum if known else LINEAR.optimum)

    monkeypatch.setattr(left_out, "starts_kept", lambda *_: frozenset())
    monkeypatch.setattr(left_out, "held_out_residuals", left)


def test_one_effect_leads_in_the_place_of_two_if_it_predicts_or_they_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    alone, pair = candidate(["free_play"], times=3.0), candidate(["free_play", "cogging"], times=2.5)
    for able, leading in (((alone, pair), alone), ((pair,), pair), ((alone,), alone)):
        predicting(monkeypatch, *able)
        assert evidence(alone, pair, LINEAR).lead is leading
    much = candidate(["free_play", "cogging"], times=1.2)
    for able, leading in (((alone, much), much), ((much,), much), ((alone,), alone), ((), much)):
        predicting(monkeypatch, *able)
        assert evidence(alone, much, LINEAR).lead is leading


@pytest.mark.parametrize("names", [["free_play"], ["free_play", "cogging"]])
def test_conditions_that_differ_lead_only_if_they_predict(names: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    alike, free = candidate(names, times=2.0), candidate(names, times=1.5, deviations=["damping"])
    for able, leading in (((alike, free), free), ((alike,), alike), ((), free)):
        predicting(monkeypatch, *able)
        monkeypatch.setattr(left_out.LeftOut, "_with", lambda *_: LINEAR.optimum)
        assert evidence(alike, free, LINEAR).lead is leading


@pytest.mark.parametrize("late", [False, True])
def test_conditions_stand_in_for_an_effect_unless_all_runs_start_late(
    late: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair = candidate(["free_play", "cogging"], times=2.0)
    alone = candidate(["free_play"], times=2.1, deviations=["start_time"])
    predicting(monkeypatch, alone, pair)
    monkeypatch.setattr(left_out.LeftOut, "_with", lambda *_: alone.optimum)
    monkeypatch.setattr(lead, "starts_late", lambda optimum: late and optimum is alone.optimum)
    assert evidence(alone, pair, LINEAR).lead is (pair if late else alone)
