"""The simulator against tight-tolerance, event-located integration, for every effect; its sensitivities."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stepid
from exact_plants import COUNTS, EFFECTS, exact_campaign, true_model
from stepid.effects import CATALOGUE, resolve
from stepid.fitting.problem import build
from stepid.simulation.records import lay_out
from stepid.simulation.simulate import pack, solve_model
from stepid.simulation.trajectory import Simulator

SHORT = ((0.5, 0.5), (2.0, -0.5), (1.0, 0.3))
SEVERAL = (
    "quadratic_damping",
    "position_dependent_damping",
    "cubic_stiffness",
    "free_play",
    "end_stop",
    "viscoelastic_spring",
    "flexible_coupling",
    "actuator_lag",
    "input_delay",
    "periodic_disturbance",
    "cogging",
    "sensor_drift",
    "coulomb_friction",
    "stribeck_friction",
    "presliding_hysteresis",
)


def test_every_effect_of_the_catalogue_is_checked() -> None:
    assert [e.name for e in CATALOGUE] == list(EFFECTS)


@pytest.mark.parametrize("name", EFFECTS)
def test_a_tenth_of_a_count_at_the_papers_sample_time(name: str) -> None:
    values = EFFECTS[name]
    campaign = exact_campaign({name: values}, SHORT)
    model = true_model(campaign, name, values)
    ours = stepid.simulate(model, campaign)
    plain = stepid.simulate(model.model_copy(update={"effects": ()}), campaign)
    off = np.concatenate([ours[e.name] - e.position for e in campaign.experiments]) * COUNTS
    effect = np.concatenate([plain[e.name] - e.position for e in campaign.experiments]) * COUNTS
    assert np.sqrt(np.mean(effect**2)) > 10  # there is something to get right
    assert np.sqrt(np.mean(off**2)) < 0.1
    _, half = solve_model(model, campaign, fineness=2.0)
    change = (half.reading - np.concatenate([ours[e.name] for e in campaign.experiments])) * COUNTS
    assert np.sqrt(np.mean(change**2)) < 0.1


def everything(sim: Simulator) -> np.ndarray:
    return np.ones(sim.n_shared + sim.n_local, dtype=bool)


def test_sensitivities_are_those_that_are_wanted() -> None:
    campaign = exact_campaign({"cubic_stiffness": EFFECTS["cubic_stiffness"]}, SHORT)
    effects, records = resolve(["cubic_stiffness"]), lay_out(campaign)
    sim = Simulator(records, effects)
    shared, local = pack(true_model(campaign, "cubic_stiffness", EFFECTS["cubic_stiffness"]), records, effects)
    every = sim.solve(shared, local, wanted=everything(sim))
    some = sim.solve(shared, local, wanted=np.arange(sim.n_shared + sim.n_local) % 2 == 0)
    assert every is not None
    assert some is not None
    assert every.tangent is not None
    assert some.tangent is not None
    np.testing.assert_allclose(some.tangent[::2], every.tangent[::2], rtol=1e-9, atol=1e-12)
    assert not some.tangent[1::2].any()


@pytest.mark.parametrize("name", SEVERAL)
def test_sensitivities_are_the_derivatives_of_the_reading(name: str) -> None:
    values = EFFECTS[name]
    campaign = exact_campaign({name: values}, SHORT)
    effects, records = resolve([name]), lay_out(campaign)
    sim = Simulator(records, effects)
    shared, local = pack(true_model(campaign, name, values), records, effects)
    near = sim.march(shared[None], local[None])[0]
    solved = sim.solve(shared, local, start=near, wanted=everything(sim))
    assert solved is not None
    assert solved.shared is not None
    assert solved.local is not None

    def reading(moved: np.ndarray, own: np.ndarray) -> np.ndarray:
        again = sim.solve(moved, own, start=near)
        assert again is not None
        return again.reading

    for j, value in enumerate(shared):
        step = 1e-4 * max(abs(value), 1e-4)
        up, down = shared.copy(), shared.copy()
        up[j] += step
        down[j] -= step
        slope = (reading(up, local) - reading(down, local)) / (2 * step)
        assert np.linalg.norm(solved.shared[j] - slope) < 2e-3 * np.linalg.norm(slope), f"shared parameter {j}"
    for q in (0, *range(2, sim.own_states.start)):
        step = 1e-5 if q == 0 else 1e-4
        up, down = local.copy(), local.copy()
        up[q] += step
        down[q] -= step
        slope = (reading(shared, up) - reading(shared, down)) / (2 * step)
        assert np.linalg.norm(solved.local[q] - slope) < 2e-3 * np.linalg.norm(slope), f"local parameter {q}"


@pytest.mark.parametrize("name", ["flexible_coupling", "viscoelastic_spring", "presliding_hysteresis"])
def test_own_states_count_where_a_record_starts_in_motion(name: str) -> None:
    """A second mass, a creeping spring or a bent asperity need not be at rest there."""
    values = EFFECTS[name]
    campaign = exact_campaign({name: values}, SHORT)
    effects, still = resolve([name]), lay_out(campaign)
    records = replace(still, moving=np.ones_like(still.moving))
    sim = Simulator(records, effects, 4.0)  # fine steps, that the number of substeps does not change on the way
    shared, local = pack(true_model(campaign, name, values), records, effects)
    solved = sim.solve(shared, local, start=sim.march(shared[None], local[None])[0], wanted=everything(sim))
    assert solved is not None
    assert solved.local is not None
    assert build(records, effects).active[sim.own_states].all()
    assert not build(still, effects).active[sim.own_states].any()
    for q in range(sim.own_states.start, sim.n_local):
        up, down = local.copy(), local.copy()
        step = 1e-7
        up[q] += step
        down[q] -= step
        ends = [sim.solve(shared, moved, start=solved.states) for moved in (up, down)]
        assert ends[0] is not None
        assert ends[1] is not None
        slope = (ends[0].reading - ends[1].reading) / (2 * step)
        assert np.linalg.norm(slope) > 0
        assert np.linalg.norm(solved.local[q] - slope) < 2e-3 * np.linalg.norm(slope)


@pytest.mark.parametrize(
    ("name", "parameter"),
    [("flexible_coupling", "damping"), ("quadratic_damping", "coefficient"), ("cubic_stiffness", "coefficient")],
)
def test_a_parameter_at_zero_has_a_sensitivity(name: str, parameter: str) -> None:
    """Else a fit that touches a bound would stay there."""
    values = EFFECTS[name]
    campaign = exact_campaign({name: values}, SHORT)
    effects, records = resolve([name]), lay_out(campaign)
    sim = Simulator(records, effects)
    shared, local = pack(true_model(campaign, name, {**values, parameter: 0.0}), records, effects)
    solved = sim.solve(shared, local, wanted=everything(sim))
    assert solved is not None
    assert solved.shared is not None
    j = sim.n_linear + [q.name for q in effects[0].parameters].index(parameter)
    moved = shared.copy()
    moved[j] = step = 1e-5 * values[parameter]
    again = sim.solve(moved, local)
    assert again is not None
    slope = (again.reading - solved.reading) / step
    assert np.linalg.norm(solved.shared[j] - slope) < 2e-3 * np.linalg.norm(slope)
    assert np.linalg.norm(slope) > 0
