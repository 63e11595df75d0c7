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
