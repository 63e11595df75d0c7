"""Weights and the encoder's scale are known within an uncertainty only: the joint fit's intervals hold all of it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import stepid
from closed_form import Plant, draw_plant, make_campaign
from stepid.effects import CATALOGUE
from stepid.effects.base import Parameter
from stepid.fitting.added_masses import weight_errors
from stepid.simulation.magnitudes import lengths
from stepid.simulation.records import lay_out

NAMES = ("base_mass", "stiffness[medium]", "damping[1/2 turn]", "force_gain")
PLANT = Plant(base_mass=0.95, stiffness=216.0, damping=12.0)


@cache
def made(**fields: float) -> stepid.Campaign:
    rng = np.random.default_rng(14)
    return make_campaign(PLANT, rng, noise=2e-5, weight_spread=fields.pop("spread", 0.0)).model_copy(update=fields)


def scores(count: int) -> np.ndarray:
    """Errors over standard uncertainties of campaigns with their own plant and weights, shape (count, 4)."""
    out = []
    for number in range(count):
        rng = np.random.default_rng([14, number])
        plant = draw_plant(rng)
        found = stepid.fit(make_campaign(plant, rng, noise=2e-5, weight_spread=0.005))
        truth = plant.base_mass, plant.stiffness, plant.damping, plant.gain
        of = [found.parameters[name] for name in NAMES]
        out.append([(e.value - true) / (e.uncertainty or 0.0) for e, true in zip(of, truth, strict=True)])
        assert found.rms < 1.15 * found.noise
        assert not found.notes
    return np.array(out)


@pytest.mark.parametrize("count", [12, pytest.param(200, marks=pytest.mark.slow)])
def test_intervals_cover_where_weights_are_drawn_from_their_uncertainty(count: int) -> None:
    z = scores(count)
    spread = np.sqrt(np.mean(z**2, axis=0))
    slack = 3 / np.sqrt(2 * count)
    assert np.all((spread > 1 - slack) & (spread < 1 + slack)), spread


def test_what_an_uncertainty_is_made_of() -> None:
    found = stepid.fit(made(scale_uncertainty=0.003))
    for name in NAMES:
        e = found.parameters[name]
        assert e.uncertainty == pytest.approx(np.sqrt(sum(part**2 for part in e.parts.values())))
        assert e.parts["weights"] == pytest.approx(0.005 * e.value, rel=0.1)  # √4 weights in 2 kg
    assert "scale" not in found.parameters["stiffness[medium]"].parts  # it follows from times and masses
    gain = found.parameters["force_gain"]
    assert gain.parts["scale"] == pytest.approx(0.003 * gain.value)
    text = found.summary()
    assert "by weights" in text
    assert "by scale" in text
    assert "95 % interval" in text
    assert "by weights" in found._repr_html_()
    assert repr(found).startswith("Fit(linear, 4 parameters")


def test_exact_weights_have_no_part_and_leave_the_answer() -> None:
    exact, known = stepid.fit(made(weight_uncertainty=1e-9)), stepid.fit(made())
    for name in NAMES:
        one, other = exact.parameters[name], known.parameters[name]
        assert one.uncertainty is not None
        assert one.parts.get("weights", 0.0) < 1e-3 * one.uncertainty
        assert abs(other.value - one.value) < 3 * one.uncertainty
    assert exact.rms == pytest.approx(known.rms, rel=2e-3)


def test_the_model_of_a_fit_carries_the_masses_that_were_found() -> None:
    whole = made(spread=0.005)
    found = stepid.fit(whole)
    assert any(state.deviations for state in found.model.runs.values())
    said = stepid.simulate(found.model, whole)
    left = np.concatenate(
        [e.position - e.position.mean() - said[e.name] + said[e.name].mean() for e in whole.experiments]
    )
    assert np.sqrt(np.mean(left**2)) == pytest.approx(found.rms, rel=1e-3)


def test_a_weight_that_is_far_off_is_told_and_not_believed() -> None:
    whole = made()
    runs = list(whole.experiments)
    runs[1] = runs[1].model_copy(update={"added_mass": 0.6})
    found = stepid.fit(whole.model_copy(update={"experiments": tuple(runs)}))
    assert any("disagrees with the others" in note and "kg added" in note for note in found.notes)
    assert any("More than noise is left" in note and "stepid.diagnose" in note for note in found.notes)


def test_runs_that_carry_the_same_weights_share_their_error() -> None:
    whole = made()
    twin = whole.experiments[1].model_copy(update={"name": "again"})
    errors = weight_errors(lay_out(whole.model_copy(update={"experiments": (*whole.experiments, twin)})))
    np.testing.assert_allclose(errors.spread[1], errors.spread[4])
    np.testing.assert_allclose(np.sum(errors.spread**2, axis=1), 5e-6 * np.array([0, 1, 3, 4, 1]) * 5)


def test_weights_far_lighter_than_their_uncertainty_are_told() -> None:
    whole = made()
    runs = tuple(run.model_copy(update={"added_mass": 1e-6 * run.added_mass}) for run in whole)
    light = whole.model_copy(update={"experiments": runs})
    (note,) = stepid.fit(light).notes
    assert note.startswith("The largest added mass, 2e-06 kg, is taken as known to 1e-05 kg only")
    assert "State the weight_uncertainty" in note
    assert not stepid.fit(light.model_copy(update={"weight_uncertainty": 5e-9})).notes


def test_no_weights_count_where_no_run_differs_in_mass() -> None:
    found = stepid.fit(made().model_copy(update={"experiments": made().experiments[1:2]}))
    assert all("weights" not in e.parts for e in found.parameters.values())


def test_a_longer_scale_changes_what_it_says_it_changes() -> None:
    whole = made()
    longer = [e.model_copy(update={"position": 1.01 * e.position}) for e in whole.experiments]
    one, two = stepid.fit(whole), stepid.fit(whole.model_copy(update={"experiments": tuple(longer)}))
    gain = one.parameters["force_gain"].value
    assert two.parameters["force_gain"].value == pytest.approx(1.01 * gain, rel=1e-6)
    assert two.parameters["stiffness[medium]"].value == pytest.approx(one.parameters["stiffness[medium]"].value)


def test_powers_of_a_length_in_parameters() -> None:
    by_name = {e.name: e.parameters for e in CATALOGUE}
    assert lengths((Parameter("a", "N/m³"), Parameter("b", "N"), Parameter("c", "kg")), np.ones(3)).tolist() == [
        -2,
        1,
        0,
    ]
    assert lengths(by_name["power_damping"], np.array([2.0, 1.5])).tolist() == [-1.0, 0.0]
    assert lengths(by_name["load_proportional_friction"], np.array([0.1])).tolist() == [0.1]


def test_friction_that_is_not_there_has_an_interval_from_zero_on() -> None:
    found = stepid.fit(made(), effects=("coulomb_friction",)).parameters["coulomb_friction.level"]
    assert found.limits == found.interval
    assert found.interval is not None
    assert found.uncertainty is not None
    low, high = found.interval
    assert low == 0.0
    assert 0.5 * found.uncertainty < high - found.value < 6 * found.uncertainty


def test_an_interval_is_the_limits_where_there_are_any() -> None:
    assert stepid.Estimate(value=1.0, uncertainty=0.5).interval == pytest.approx((0.02, 1.98))
    assert stepid.Estimate(value=1.0, uncertainty=0.5, limits=(0.0, 3.0)).interval == (0.0, 3.0)
    assert stepid.Estimate(value=1.0).interval is None
