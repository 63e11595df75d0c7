"""The joint fit on campaigns of the hidden simulator: truth, bad input, files."""

from __future__ import annotations

import pickle
from functools import cache
from typing import Any

import numpy as np
import pytest

import stepid
from closed_form import Plant, make_run
from hidden.campaigns import make_campaign
from stepid.errors import InputError, UndeterminedError

PLANT = Plant(0.95, 216.0, 8.0)
SEEDS = {
    "coulomb_friction": 9000,
    "load_proportional_friction": 9001,
    "quadratic_damping": 9005,
    "position_dependent_damping": 9006,
    "cubic_stiffness": 9007,
    "quadratic_stiffness": 9008,
    "free_play": 9009,
    "end_stop": 9010,
    "flexible_coupling": 9012,
    "actuator_lag": 9013,
    "input_delay": 9014,
    "actuator_saturation": 9016,
    "periodic_disturbance": 6101,
    "sensor_drift": 9019,
}


def truths(truth: dict[str, Any]) -> dict[str, float]:
    """A hidden campaign's truth under the names of `Fit.parameters`."""
    return {
        "base_mass": truth["base_mass"],
        "force_gain": truth["force_gain"],
        **{f"stiffness[{k}]": v for k, v in truth["stiffness"].items()},
        **{f"damping[{k}]": v for k, v in truth["damping"].items()},
        **truth["parameters"],
    }


@cache
def linear_campaign(noise: float = 2e-5) -> stepid.Campaign:
    rng = np.random.default_rng(8)
    runs = [
        make_run(PLANT, added, name=f"case {i}", count=220, noise=noise, rng=rng)
        for i, added in enumerate((0.0, 0.5, 1.5))
    ]
    return stepid.Campaign(name="linear", experiments=tuple(runs))


@pytest.mark.parametrize("name", SEEDS)
def test_the_truth_is_recovered_within_its_uncertainty(name: str) -> None:
    campaign, truth = make_campaign(SEEDS[name], (name,), r0=5.0, kind="five")
    found = stepid.fit(campaign, effects=(name,))
    assert found.converged
    assert found.rms < 1.1 * found.noise
    samples = sum(e.time.size for e in campaign.experiments)
    spread = np.sqrt(3.63 / (2 * samples))  # of a standard deviation from eighth differences: 1 + 2 Σρ² = 3.63
    assert abs(found.noise / truth["noise_rms"] - 1) < 4 * spread
    wanted = truths(truth)
    assert wanted.keys() == found.parameters.keys()
    for key, value in wanted.items():
        estimate = found.parameters[key]
        if estimate.uncertainty is None:
            # where friction may hold the cart anywhere, steps that do not come back leave the gain open
            assert key == "force_gain"
            assert name in {"coulomb_friction", "load_proportional_friction"}
            continue
        assert abs(estimate.value - value) < 4 * estimate.uncertainty, f"{key}: {estimate}, truth {value:.5g}"
    plain = stepid.fit(campaign)
    assert plain.rms > 3 * found.rms


def test_a_linear_plant_is_recovered() -> None:
    found = stepid.fit(linear_campaign())
    expected = {"base_mass": 0.95, "stiffness[medium]": 216.0, "damping[1/2 turn]": 8.0, "force_gain": 7.8}
    assert list(found.parameters) == list(expected)
    for key, value in expected.items():
        estimate = found.parameters[key]
        assert estimate.uncertainty is not None
        assert estimate.uncertainty < 0.01 * value
        assert abs(estimate.value - value) < 4 * estimate.uncertainty
    assert found.rms == pytest.approx(2e-5, rel=0.08)
    assert found.correlation.shape == (4, 4)
    np.testing.assert_allclose(np.diag(found.correlation), 1.0)
    np.testing.assert_allclose(found.correlation, found.correlation.T, atol=1e-12)
    assert np.abs(found.correlation).max() <= 1 + 1e-9


def test_a_fit_without_noise_is_exact() -> None:
    found = stepid.fit(linear_campaign(0.0))
    assert found.parameters["base_mass"].value == pytest.approx(0.95, rel=1e-6)
    assert found.rms < 1e-9


def test_a_fit_simulates_what_it_says_it_leaves() -> None:
    campaign, _ = make_campaign(SEEDS["coulomb_friction"], ("coulomb_friction",), r0=5.0, kind="five")
    found = stepid.fit(campaign, effects=("coulomb_friction",))
    positions = stepid.simulate(found.model, campaign)
    off = {e.name: positions[e.name] - e.position for e in campaign.experiments}
    for name, residual in off.items():
        assert np.sqrt(np.mean(residual**2)) == pytest.approx(found.run_rms[name], rel=1e-3)
    assert np.sqrt(np.mean(np.concatenate(list(off.values())) ** 2)) == pytest.approx(found.rms, rel=1e-3)


def test_fits_and_models_go_to_files_and_back() -> None:
    found = stepid.fit(linear_campaign(), effects=("coulomb_friction",))
    assert stepid.Fit.model_validate_json(found.model_dump_json()) == found
    assert stepid.PlantModel.model_validate_json(found.model.model_dump_json()) == found.model
    assert pickle.loads(pickle.dumps(found)) == found


def test_masses_are_undetermined_without_a_mass_difference() -> None:
    one = stepid.Campaign(name="one", experiments=linear_campaign().experiments[1:2])
    found = stepid.fit(one)
    assert found.parameters["base_mass"].uncertainty is None
    assert "undetermined" in str(found.parameters["base_mass"])
    assert any("every parameter is per unit mass" in note for note in found.notes)
    assert not any("per unit mass" in note for note in stepid.fit(linear_campaign()).notes)
    ratio = found.parameters["stiffness[medium]"].value / (found.parameters["base_mass"].value + 0.5)
    assert ratio == pytest.approx(216.0 / 1.45, rel=0.02)


def test_one_run_is_not_diagnosed() -> None:
    one = stepid.Campaign(name="alone", experiments=linear_campaign().experiments[:1])
    with pytest.raises(UndeterminedError, match=r"'alone' has one run.*Add a run with another added mass"):
        stepid.diagnose(one)


def test_an_unknown_effect_is_named_with_the_catalogue() -> None:
    with pytest.raises(InputError, match=r"no effect called 'coulomb'.*coulomb_friction"):
        stepid.fit(linear_campaign(), effects=("coulomb",))
    with pytest.raises(InputError, match="'free_play' is named twice"):
        stepid.fit(linear_campaign(), effects=("free_play", "free_play"))


@pytest.mark.parametrize("route", [stepid.fit, stepid.diagnose])
def test_a_run_that_never_moves_is_left_out_by_name(route: Any) -> None:
    experiments = linear_campaign().experiments
    still = [e.model_copy(update={"position": np.zeros(220)}) for e in experiments]
    found = route(stepid.Campaign(name="one still", experiments=(experiments[0], still[1], experiments[2])))
    assert any("Run 'case 1' is left out: nothing moves" in note for note in found.notes)
    with pytest.raises(InputError, match=r"'all still': no run can be used.*'case 2' is left out.*drive was on"):
        route(stepid.Campaign(name="all still", experiments=tuple(still)))


def test_any_number_of_threads_gives_the_same_fit() -> None:
    campaign = stepid.datasets.lab_campaign()
    few = stepid.Campaign(name="two", experiments=campaign.experiments[:2])
    one, two = (stepid.fit(few, effects=["cubic_stiffness"], workers=n) for n in (1, 2))
    assert one == two
    with pytest.raises(InputError, match=r"workers = 0 is no number of threads.*1 or more"):
        stepid.fit(few, workers=0)
