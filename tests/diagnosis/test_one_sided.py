"""Effects whose size the data limit on one side only: they are there, and are named with that limit."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import stepid
from hidden.sets import one
from made_up_evidence import FRICTION, LINEAR, Kept, Told, candidate, context, evidence
from stepid.diagnosis import verdict, vetoes
from stepid.effects import resolve
from stepid.fitting import profile
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects

GAP = stepid.Estimate(value=8e-4, unit="m", limits=(4.3e-4, None))
ABSENT_ABOVE = ("actuator_saturation.level", "actuator_rate_limit.rate")
STOPS, POWERS = "b9461d2e9bb4d3c3e5c1e75cf8543ccd655503bb", "aa3bf92e2cd506e43e6812e0d261d55a83510e6a"
DRAW = "52e0608e075b9f8b3619b4054892972722112f87"


def test_an_estimate_says_at_least_or_at_most() -> None:
    assert str(GAP) == "at least 0.43 mm"
    assert GAP.shown == ("at least 0.43", "mm")
    assert str(stepid.Estimate(value=1.0, unit="V", limits=(None, 1.25))) == "at most 1.3 V"
    assert GAP.interval is None
    assert GAP.one_sided == ("at least", 4.3e-4)
    assert stepid.Estimate(value=1.0, uncertainty=0.5, limits=(0.0, 3.0)).one_sided is None
    assert stepid.Estimate.model_validate_json(GAP.model_dump_json()) == GAP


def test_a_limit_where_the_cost_is_flat_and_then_steep(monkeypatch: pytest.MonkeyPatch) -> None:
    """No parabola leads there: the limit lies between the last place within and the first beyond."""
    edge = 0.4
    monkeypatch.setattr(
        profile,
        "minimize",
        lambda held, shared, local, **_: SimpleNamespace(
            cost=1.0 + 1e6 * max(edge - shared[0], 0.0) ** 2, shared=shared, local=local
        ),
    )
    monkeypatch.setattr(profile, "replace", lambda problem, **_: problem)
    problem = SimpleNamespace(free=np.array([True]), lower=np.array([0.0]), upper=np.array([np.inf]))
    flat: Any = SimpleNamespace(problem=problem, shared=np.array([1.0]), local=None, cost=1.0)
    end = profile._limit(flat, 0, -0.5, wanted=1.0)
    assert end is not None
    assert edge - 0.05 < end <= edge


def test_a_gap_that_is_never_crossed_has_a_least_width() -> None:
    """The cart leaves the play once in each run: what it crosses is at most the whole, so the gap is no less."""
    campaign, truth = one("single-all", 9, DRAW)
    context, effects = prepare(campaign), resolve(["free_play"])
    optimum = fit_effects(context, effects)
    assert optimum is not None
    found = profile.limited(optimum, effects, context.floor, ("free_play.gap",))["free_play.gap"]
    true = truth["parameters"]["free_play.gap"]
    assert found.limits is not None
    assert found.limits[0] is not None
    assert 0.5 * true < found.limits[0] < true
    assert (found.limits[1], found.uncertainty) == (None, None)
    assert profile.limited(optimum, effects, context.floor, ()) == {}
    told = stepid.fit(campaign, effects=["free_play"]).parameters["free_play.gap"]
    assert told.one_sided == ("at least", pytest.approx(found.limits[0], rel=0.1))


def test_it_is_named_with_that_limit() -> None:
    campaign, truth = one("single-all", 9, DRAW)
    d = stepid.diagnose(campaign)
    assert (d.verdict, d.effects) == ("named", ("free_play",))
    assert any("on one side only: at least" in reason for reason in d.reasons)
    limits = d.parameters["free_play.gap"].limits
    assert limits is not None
    assert limits[0] is not None
    assert limits[0] < truth["parameters"]["free_play.gap"]
    assert "at least" in str(d)
    assert not any("do not determine" in note for note in d.notes)


@pytest.mark.parametrize(
    ("name", "end", "limits"),
    [
        ("free_play.gap", 4e-4, (4e-4, None)),
        ("free_play.gap", 0.0, None),  # it may be absent
        ("free_play.gap", None, None),
        ("sensor_drift.rate", 4e-4, (4e-4, None)),
        ("sensor_drift.rate", -1e-5, None),  # beyond absence
        ("actuator_lag.time_constant", 1e-5, None),  # its bound, which is as good as absence
        ("actuator_saturation.level", 9e-4, (None, 9e-4)),  # absent where it is high
        ("actuator_rate_limit.rate", 9e-4, (None, 9e-4)),
    ],
)
def test_a_strength_has_a_limit_on_the_side_of_absence(
    monkeypatch: pytest.MonkeyPatch, name: str, end: float | None, limits: Any
) -> None:
    effects = resolve([name.split(".")[0]])
    layout = SimpleNamespace(values=(slice(0, 1),))
    ends = effects[0].parameters[0].lower, effects[0].parameters[0].upper
    problem = SimpleNamespace(layout=layout, free=np.array([True]), lower=ends[:1], upper=ends[1:])
    asked: list[float] = []

    def limit(optimum: Any, index: int, distance: float, wanted: float) -> float | None:
        asked.append(distance)
        return end

    monkeypatch.setattr(profile, "_limit", limit)
    for vague in (True, False):
        near = SimpleNamespace(
            level=1e-5, excess=np.ones(1), open=np.array([False]), noise=np.array([[1e-3**2 * vague]])
        )
        monkeypatch.setattr(profile, "uncertain", lambda *_, near=near: near)
        found = profile.limited(Kept(problem=problem, shared=np.array([8e-4])), effects, 1e-5, (name,))
        assert {n: e.limits for n, e in found.items()} == ({name: limits} if vague and limits else {})
    assert asked == [4e-4 if name in ABSENT_ABOVE else -4e-4]  # what the curvature tells is not asked for


@pytest.mark.parametrize(
    ("end", "weights", "within", "there"),
    [
        (3e-4, 0.0, 1.0, True),
        (3e-4, 0.0, 0.6, False),
        (3e-4, 4e-4, 1.0, False),  # what the weights add reaches none
        (0.0, 0.0, 1.0, False),
        (None, 0.0, 1.0, False),
    ],
)
def test_a_strength_is_there_where_its_limit_comes_before_none(
    monkeypatch: pytest.MonkeyPatch, end: float | None, weights: float, within: float, there: bool
) -> None:
    """Whatever the curvature says of it: the way from 0.8 mm to none is 0.8 mm."""
    problem = SimpleNamespace(
        layout=SimpleNamespace(values=(slice(0, 1),)), free=np.array([True]), lower=[-1.0], upper=[np.inf]
    )
    name = "free_play.gap"
    told = stepid.Estimate(value=8e-4, uncertainty=5e-4, parts={"noise": 5e-4, "weights": weights})
    near = SimpleNamespace(level=1e-5, excess=np.ones(1))
    monkeypatch.setattr(profile, "estimates", lambda *_: ({name: told}, None))
    monkeypatch.setattr(profile, "uncertain", lambda *_: near)
    monkeypatch.setattr(profile, "_limit", lambda *_: end)
    optimum: Any = Kept(problem=problem, shared=np.array([8e-4]))
    found = profile.present(optimum, resolve(["free_play"]), 1e-5, (name,), within)
    assert found == ({name} if there else set())
    assert profile.present(optimum, resolve(["free_play"]), 1e-5, (), within) == set()


@pytest.mark.parametrize(
    ("draw", "number", "effect"),
    [(STOPS, 79, "end_stop"), pytest.param(POWERS, 159, "power_damping", marks=pytest.mark.slow)],
)
def test_a_strength_is_determined_by_its_likelihood(draw: str, number: int, effect: str) -> None:
    """The curvature leaves the stop's stiffness and the coefficient beside its exponent open by half of them."""
    campaign, truth = one("single-all", number, draw)
    d = stepid.diagnose(campaign)
    assert (truth["effects"], d.verdict, d.effects) == ((effect,), "named", (effect,))


def test_the_verdict_says_on_which_side() -> None:
    found = verdict.complete(Told(sized={"coulomb_friction.level": GAP}))  # type: ignore[arg-type]
    assert found is not None
    assert found.verdict == "named"
    assert "The data limit the level of Coulomb friction on one side only: at least 0.43 mm." in found.reasons


def test_what_is_not_seen_is_not_named_at_the_floor() -> None:
    told: dict[str, Any] = {"too_short": {"coulomb_friction": "a slow shift of the rest position"}}
    alone = verdict.complete_but_open(Told(**told, lead=candidate()))  # type: ignore[arg-type]
    assert alone is not None
    assert alone.verdict == "unexplained"
    assert "Coulomb friction cannot be told from a slow shift of the rest position here." in alone.reasons[0]
    play = candidate(["free_play"])
    beside = verdict.complete_but_open(Told(**told, rivals=(play,)))  # type: ignore[arg-type]
    assert beside is not None
    assert (beside.verdict, beside.shown, beside.alternatives) == ("named", play, ())
    assert verdict.complete_but_open(Told()) is None  # type: ignore[arg-type]
    assert beside.reasons[-1].startswith("Free play leaves ")
    neither = verdict.complete_but_open(Told(**told, rivals=(play,), not_nameable=(play.names,), lead=candidate()))  # type: ignore[arg-type]
    assert neither is not None
    assert neither.verdict == "unexplained"
    alone_with_weights = verdict.weights_are_enough(Told(not_nameable=(FRICTION.names,), context=weighed()))  # type: ignore[arg-type]
    assert alone_with_weights is not None
    assert alone_with_weights.verdict == "adequate"


def weighed() -> Any:
    """A context in which errors of the weights are enough."""
    return SimpleNamespace(**vars(context()) | {"by_weights": LINEAR.optimum})


def test_an_open_pair_counts_for_what_it_holds_and_disputes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    one, other = candidate(["coulomb_friction"], times=1.5), candidate(["quadratic_damping"], times=1.4)
    pair = candidate(["coulomb_friction", "free_play"], times=1.3)
    told = evidence(one, other, pair)
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))
    assert told.weight(one) == pytest.approx(1.0)  # the pair holds it, and is better
    openly = {"free_play.gap": stepid.Estimate(value=1e-3, unit="m")}
    monkeypatch.setattr(vetoes, "estimates", lambda found, *_: (openly if found is pair.optimum else {}, None))
    assert evidence(one, other, pair).weight(one) == pytest.approx(1.0)
    assert evidence(one, other, pair).weight(other) == pytest.approx(1.0)  # what is open speaks for no other
    assert evidence(one, other, pair).weight(pair) == 0.0
