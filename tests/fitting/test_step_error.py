"""How exact the steps of a fit to all samples are: no sample shows the difference, and no finer than that."""

from __future__ import annotations

import numpy as np
import pytest

from hidden.campaigns import make_campaign
from stepid.effects import resolve
from stepid.fitting.fit import fit_effects, prepare
from stepid.simulation.simulator import COARSE, FINE, Simulator


@pytest.mark.parametrize("name", ["cubic_stiffness", "coulomb_friction", "presliding_hysteresis", "flexible_coupling"])
def test_the_error_of_a_fit_is_far_below_its_noise(name: str) -> None:
    campaign, _ = make_campaign(9100, (name,), r0=5.0, kind="five")
    context, effects = prepare(campaign), resolve([name])
    found = fit_effects(context, effects)
    assert found is not None
    assert found.problem.simulator.tolerance == context.step_error
    exact = Simulator(context.records, effects, FINE / 10).solve(found.shared, found.local)
    assert exact is not None
    change = context.records.centered(found.solved.reading - exact.reading)
    assert np.sqrt(np.mean(change**2)) < 2e-3 * context.floor


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
