"""How exact the steps of a fit to all samples are: no sample shows the difference, and no finer than that."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from closed_form import Plant, make_run
from hidden.campaigns import make_campaign
from stepid.effects import resolve
from stepid.fitting.fit import fit_effects, prepare
from stepid.simulation.simulator import COARSE, FINE, Simulator

RINGS = Plant(0.95, 216.0, 0.05)  # for a minute


@pytest.mark.parametrize("name", ["cubic_stiffness", "coulomb_friction", "stribeck_friction", "presliding_hysteresis"])
def test_the_error_of_a_fit_is_far_below_its_noise(name: str) -> None:
    campaign, _ = make_campaign(9100, (name,), r0=5.0, kind="five")
    assert error(campaign, name) < 2e-3


def test_it_is_so_where_the_errors_of_many_swings_add_up() -> None:
    rng = np.random.default_rng(5)
    runs = [make_run(RINGS, m, name=f"with {m} kg", count=3000, noise=1e-4, rng=rng) for m in (0.0, 0.5)]
    assert error(stepid.Campaign(name="rings", experiments=tuple(runs)), "cubic_stiffness") < 2e-3


def error(campaign: stepid.Campaign, name: str) -> float:
    """RMS of what a fit's steps miss, over the noise floor."""
    context, effects = prepare(campaign), resolve([name])
    found = fit_effects(context, effects)
    assert found is not None
    assert found.problem.simulator.tolerance == context.step_error
    exact = Simulator(context.records, effects, FINE / 10).solve(found.shared, found.local)
    assert exact is not None
    change = context.records.centered(found.solved.reading - exact.reading)
    assert change.any()
    return float(np.sqrt(np.mean(change**2)) / context.floor)


def test_it_follows_the_noise_between_its_bounds() -> None:
    campaign, _ = make_campaign(9100, ("cubic_stiffness",), r0=5.0, kind="five")
    context = prepare(campaign)
    tried = []
    for floor in context.floor * np.array([1e-6, 0.1, 0.2, 1e6]):
        context.floor = float(floor)
        tried.append(context.step_error)
    assert tried[0] == FINE
    assert tried[2] == pytest.approx(2 * tried[1])
    assert tried[1] > FINE
    assert tried[3] == COARSE / 2
