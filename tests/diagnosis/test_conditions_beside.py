"""Conditions that differ from run to run beside an effect: which effects they are tried beside, and what is a law."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

import stepid
from hidden.sets import one
from made_up_evidence import candidate, evidence, losing
from made_up_search import PAIR, a_search, node, nothing_imitates
from stepid.diagnosis import gather, vetoes
from stepid.diagnosis.exchangeable import Condition
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.selection.conditions import first_of


def keyed(name: str) -> Any:
    return SimpleNamespace(key=(frozenset({name}), frozenset({"damping"} if name == "stop" else ())))


def proposed(base: Any, left: float, *conditions: str, move: str = "deviate") -> Any:
    return SimpleNamespace(base=base.key, left=left, deviations=base.key[1].union(conditions), move=move)


def test_conditions_are_tried_beside_what_leaves_least_and_where_one_promises_most() -> None:
    lag, play, stop, drift = map(keyed, ("lag", "play", "stop", "drift"))
    nodes: Any = [play, stop, lag, drift]
    proposals = [
        proposed(play, 3.0, "gain"),
        proposed(play, 0.0, "gain", "start_time"),  # all together promise everything
        proposed(stop, 2.0, "start_time"),
        proposed(stop, 9.0, "gain"),
        proposed(lag, 1.0, "gain"),
        proposed(lag, 0.1, move="drop"),
        proposed(keyed("other"), 0.5, "gain"),
    ]
    assert first_of(nodes, proposals, "deviate", 1) == [play, lag]  # what leaves least, what promises most
    assert first_of(nodes, proposals, "deviate", 2) == [play, stop, lag]  # each once
    assert first_of(nodes, proposals, "deviate", 9) == nodes


@pytest.mark.slow
def test_an_effect_that_takes_less_than_others_is_found_beside_the_gain() -> None:
    """Three others leave less without it, and conditions of the start alone leave only noise."""
    campaign, _ = one("perturbed-single", 59, "573aee971d4e6d76b37b656fc32aaab41d9f1886")
    found = stepid.diagnose(campaign)
    assert found.effects == ("actuator_lag",)
    assert found.scatter["gain"].deviation == pytest.approx(0.0134, rel=0.25)


LAW = Condition("gain", "the size of the input", 9.0)
STILL = candidate(["actuator_dead_zone"], deviations=["gain"])
SCATTERED = losing(STILL, 13.0, [], deviations=["gain"])  # more than a tie, less than a further effect must earn


@pytest.fixture
def _gains_follow_the_input(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    monkeypatch.setattr(EvidenceRecord, "systematic", lambda _, found: LAW if found is SCATTERED else None)


@pytest.mark.usefixtures("_gains_follow_the_input")
def test_a_scatter_that_is_a_law_stands_back_behind_what_is_more_likely() -> None:
    assert evidence(SCATTERED, STILL).best is STILL
    for qbic, stands_back in ((-1.0, True), (1.0, False)):
        other = losing(SCATTERED, qbic, ["actuator_dead_zone"], deviations=["gain"])
        assert (evidence(SCATTERED, other).best is other) == stands_back


def test_a_scatter_that_is_drawn_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    monkeypatch.setattr(EvidenceRecord, "systematic", lambda *_: None)
    assert evidence(SCATTERED, STILL).best is SCATTERED


LATE = candidate(["coulomb_friction"], deviations=["start_time"])
DELAYED = losing(LATE, -13.0, ["coulomb_friction", "input_delay"], deviations=["start_time"])


@pytest.mark.parametrize("late", [True, False])
def test_start_times_that_are_all_as_late_are_a_delay_that_has_its_price(
    late: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Less than a further effect must earn decides then: what the start times share is one already."""
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    monkeypatch.setattr(EvidenceRecord, "systematic", lambda *_: None)
    monkeypatch.setattr("stepid.diagnosis.evidence.starts_late", lambda optimum: late and optimum is LATE.optimum)
    assert evidence(LATE, DELAYED).best is (DELAYED if late else LATE)


@pytest.mark.parametrize(("spread", "told"), [(0.02, True), (0.06, False)])
def test_an_effect_that_takes_most_of_the_scatter_is_as_good_an_answer(
    spread: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The runs differ, or it is a law: the larger set is no worse, and costs less than chance would have it earn."""
    best = candidate(["quadratic_damping"], deviations=["gain"])
    larger = losing(best, 3.0, ["quadratic_damping", "actuator_dead_zone"], deviations=["gain"])
    other = losing(best, 3.0, ["coulomb_friction", "actuator_dead_zone"], deviations=["gain"])
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    monkeypatch.setattr(EvidenceRecord, "systematic", lambda *_: None)
    sizes = {id(best.optimum): 0.1}
    monkeypatch.setattr(gather, "sizes_of_scatter", lambda optimum: {"gain": sizes.get(id(optimum), spread)})
    e = evidence(best, larger, other)
    assert e.best is best
    assert [c.names for c in e.rivals] == ([larger.names] if told else [])


@pytest.mark.parametrize(("deviations", "dropped"), [(["gain"], ["gain"]), ([], [])])
def test_where_a_rest_remains_what_runs_differ_by_is_dropped_and_no_effect(
    deviations: list[str], dropped: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Conditions may do what an effect did that was added since."""
    nothing_imitates(monkeypatch)
    found: Any = a_search(lead=1.0)
    best, alike = candidate(PAIR, times=8.0, deviations=deviations), candidate(PAIR, times=8.0)
    found.standings.candidates = {best.key: best}
    found.standings.nodes[best.key] = node(*PAIR, cost=1.0)
    fewer = SimpleNamespace(move="drop", base=best.key, key=alike.key, name="gain")
    smaller = SimpleNamespace(move="drop", base=best.key, key=candidate(PAIR[:1]).key, name="an effect")
    monkeypatch.setattr(found.queue, "expand", lambda *_: True)
    monkeypatch.setattr(found.queue, "rivals", lambda *_: [fewer, smaller])
    fitted: list[str] = []

    def fit_all(proposals: Any) -> None:
        fitted.extend(p.name for p in proposals)
        found.standings.candidates = {alike.key: alike}

    monkeypatch.setattr(found.fits, "try_all", fit_all)
    monkeypatch.setattr(found.fits, "polish_best", lambda: best)
    assert found._simplify() is bool(dropped)
    assert fitted == dropped
