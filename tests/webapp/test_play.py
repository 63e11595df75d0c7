"""Playing: knobs begin at the fit, every effect of the catalogue can be turned, and answers what simulate answers."""

from __future__ import annotations

import re

import numpy as np
import pytest

import stepid
from stepid.core.estimate import Estimate
from stepid.core.quantities import CART, quantities_of
from stepid.core.words import length
from stepid.webapp import pictures, play
from stepid.webapp.play import NONE, Bench


@pytest.fixture(scope="module")
def bench() -> Bench:
    return play.bench(stepid.datasets.lab_campaign()[["case 4", "case 5"]])


def values(at: Bench, run: str, effect: str) -> dict[str, float]:
    return {knob.key: knob.value for knob in play.knobs(at, run, effect)}


def test_without_an_effect_it_is_the_linear_fit(bench: Bench) -> None:
    model = play.turned(bench, "case 4", NONE, values(bench, "case 4", NONE))
    assert model == bench.linear
    simulated, said = play.response(bench, "case 4", model)
    assert simulated is not None
    expected = stepid.simulate(bench.linear, bench.campaign)["case 4"]
    np.testing.assert_allclose(simulated, expected, rtol=0, atol=1e-9)
    left = np.sqrt(np.mean((bench.campaign["case 4"].position - simulated) ** 2))
    assert said == f"{length(left)} RMS are left."


@pytest.mark.parametrize("effect", [effect.name for effect in stepid.effects.CATALOGUE])
def test_every_effect_has_knobs_whose_ends_can_be_reached(bench: Bench, effect: str) -> None:
    knobs = play.knobs(bench, "case 5", effect)
    assert all(knob.low <= knob.value <= knob.high and 0 < knob.step < knob.high - knob.low for knob in knobs)
    for end in ("low", "value", "high"):
        turned = {k.key: getattr(k, end) if "." in k.key else k.value for k in knobs}
        simulated, said = play.response(bench, "case 5", play.turned(bench, "case 5", effect, turned))
        assert said
        assert simulated is None or np.isfinite(simulated).all()
        drawn = pictures.played(bench.campaign["case 5"], simulated, reach=play.reach(bench, "case 5"), say=CART)
        assert len(drawn["data"]) == (1 if simulated is None else 3)


def test_knobs_are_shown_in_the_units_of_the_tables(bench: Bench) -> None:
    for effect in stepid.effects.CATALOGUE:
        for parameter, knob in zip(effect.parameters, play.knobs(bench, "case 5", effect.name)[4:], strict=True):
            shown, unit = Estimate(value=knob.value or knob.high, unit=parameter.unit).shown
            assert knob.label.endswith(f" [{unit}]" if unit else parameter.name.replace("_", " "))
            number = (knob.value or knob.high) / knob.scale
            assert float(shown.removesuffix(" (undetermined)")) == pytest.approx(number, rel=1e-4)
    (delay,) = play.knobs(bench, "case 5", "input_delay")[4:]
    assert delay.label == "delay [ms]"
    assert delay.scale == 1e-3


def test_a_fit_turns_the_knobs_to_the_best(bench: Bench) -> None:
    best = play.best(bench, "coulomb_friction")
    found = values(best, "case 4", "coulomb_friction")
    assert found["coulomb_friction.level"] == pytest.approx(0.3, abs=0.03)
    simulated, _ = play.response(best, "case 4", play.turned(best, "case 4", "coulomb_friction", found))
    assert simulated is not None
    left = np.sqrt(np.mean((bench.campaign["case 4"].position - simulated) ** 2))
    assert left < 40e-6
    assert values(best, "case 4", NONE) == values(bench, "case 4", NONE)


def test_what_runs_away_is_said(bench: Bench) -> None:
    turned = values(bench, "case 4", "cubic_stiffness") | {"cubic_stiffness.coefficient": -1e9}
    simulated, said = play.response(bench, "case 4", play.turned(bench, "case 4", "cubic_stiffness", turned))
    assert simulated is None
    assert "runs away" in said


def test_a_plant_that_turns_is_spoken_of_in_its_own_units(bench: Bench) -> None:
    turning = bench.campaign.model_copy(update={"motion": "rotation", "input_unit": "N·m"})
    at = play.bench(turning)
    assert {knob.key: knob.value for knob in play.knobs(at, "case 4", NONE)} == values(bench, "case 4", NONE)
    labels = [knob.label for knob in play.knobs(at, "case 4", "coulomb_friction")]
    simulated, said = play.response(at, "case 4", at.linear)
    say = quantities_of(turning)
    drawn = [
        pictures.record(turning["case 4"], say),
        pictures.played(turning["case 4"], simulated, reach=play.reach(at, "case 4"), say=say),
        *pictures.verified(stepid.verify(stepid.identify(turning), turning)).values(),
    ]
    texts = re.findall(r"[^'\"]*\[[^]]*\][^'\"]*", str([one["layout"] for one in drawn])) + labels + [said]
    assert any("kg·m²" in text for text in texts)
    assert any("rad" in text for text in texts)
    assert not [text for text in texts if re.search(r"\bmm\b|µm|\bkg\b(?!·m²)|/m\b|\[V\]", text)]
