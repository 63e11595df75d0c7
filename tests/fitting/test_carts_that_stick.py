"""Fits to carts that a step moves once, until friction holds them."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.fitting.fit import prepare
from stepid.fitting.problem import fit_linear, within_weights
from sticking_carts import campaign


@pytest.mark.parametrize("runs", [1, 2, 4])
def test_a_linear_plant_is_always_found(runs: int) -> None:
    for seed in range(25):
        linear = prepare(campaign(seed, runs)).linear
        assert np.isfinite(linear.rms)
        assert linear.rms < float(np.std(linear.problem.records.position))


@pytest.mark.slow
def test_known_weights_bound_the_mass_where_a_misfit_remains() -> None:
    scale = [prepare(campaign(seed)).linear for seed in range(25)]
    for linear in scale:
        records, masses = linear.problem.records, linear.shared[linear.problem.layout.base_mass]
        assert np.all(masses <= 30 * np.ptp(records.added_mass) * (1 + 1e-12))
    runaway = [fit_linear(linear.problem.records) for linear in scale]
    heaviest = [float(one.shared[0] / one.problem.records.mass_scale) for one in runaway if one is not None]
    assert max(heaviest) > 1e3  # what the bound is for


def test_a_mass_within_the_weights_reach_stays() -> None:
    linear = prepare(stepid.datasets.lab_campaign()).linear
    assert within_weights(linear) is linear


@pytest.mark.parametrize("seed", [*(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2)), 3])
def test_dry_friction_is_in_the_answer(seed: int) -> None:
    """Coulomb friction and one that goes with the weight are the same in a run that moves one way."""
    d = stepid.diagnose(campaign(100 + seed))
    named = {name for effects in (d.effects, *d.alternatives) for name in effects}
    assert d.verdict in ("named", "ambiguous")
    assert "coulomb_friction" in named


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_the_bound_goes_with_the_weights(unit: float) -> None:
    """A rig of grams or of tons is bounded as one of kilograms is."""
    small = campaign(2)
    runs = [
        run.model_copy(update={"added_mass": unit * run.added_mass, "input": run.input * unit})
        for run in small.experiments
    ]
    one = prepare(small).linear
    other = prepare(stepid.Campaign(name="other", experiments=runs)).linear
    assert other.shared[:-1] == pytest.approx(unit * one.shared[:-1], rel=1e-3)


def light_weights(late: float = 0.0) -> stepid.Campaign:
    """Steps of a plant of 60 kg with weights of 1 and 2 kg, one run late, by closed form."""
    time, mass, stiffness, damping = np.arange(0.0, 30.0, 0.05), 60.0, 660.0, 6.0
    runs = []
    for i, (added, volts) in enumerate(((1.0, 1.0), (1.0, -1.0), (2.0, -2.0))):
        since = np.maximum(time - 1.0 - late * (i == 1), 0.0)
        decay, swing = damping / (2 * (mass + added)), np.sqrt(stiffness / (mass + added))
        swing = np.sqrt(swing**2 - decay**2)
        rung = np.exp(-decay * since) * (np.cos(swing * since) + decay / swing * np.sin(swing * since))
        seen = volts * 0.1 * (1 - rung) + np.random.default_rng(i).normal(0.0, 1e-4, time.size)
        given = {"added_mass": added, "spring": "s", "damper": "d"}
        runs.append(stepid.Experiment(name=f"r{i}", time=time, position=seen, input=volts * (time >= 1.0), **given))
    return stepid.Campaign(name="light weights", experiments=tuple(runs))


def test_a_base_far_heavier_than_its_weights_is_found() -> None:
    found = stepid.fit(light_weights()).parameters
    assert found["base_mass"].value == pytest.approx(60.0, rel=0.05)
    assert found["stiffness[s]"].uncertainty is not None


def test_beside_a_misfit_a_fit_leaves_no_more_than_with_weights_that_do_nothing() -> None:
    """Nearly: at 30 kg a weight of 2 still does a little. It had ended at 0.03 kg, and left 40 mm."""
    late = light_weights(late=0.4)
    found = stepid.fit(late)
    alike = [run.model_copy(update={"added_mass": 0.0}) for run in late.experiments]
    nothing = stepid.fit(stepid.Campaign(name="no weights", experiments=tuple(alike)))
    assert found.rms < 1.25 * nothing.rms
    assert found.parameters["base_mass"].value == pytest.approx(30.0)
    assert all(one.uncertainty is None for one in found.parameters.values())  # only their ratios are determined
    assert any("do not tell the base mass" in note for note in found.notes)
