"""The simulator's derivatives against central differences of a far tighter simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hidden.accuracy_cases import ALONE, run
from hidden_runs import central, plant_of, records_of, simulator_of
from stepid.effects import resolve
from stepid.fitting.problem import build
from stepid.simulation.simulator import Simulator

TIGHT = 1e-12
OFTEN = (
    "coulomb_friction",
    "stribeck_friction",
    "presliding_hysteresis",
    "free_play",
    "end_stop",
    "flexible_coupling",
    "actuator_lag",
    "input_delay",
    "periodic_disturbance",
    "cogging",
    "sensor_drift",
    "actuator_rate_limit",
)


def derivatives(sim: Simulator, shared: np.ndarray, local: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    reading = sim.readings(shared[None], local[None])[0]
    return sim.derivatives(shared, local, reading, np.ones(shared.size, bool), np.ones(local.shape, bool))


@pytest.mark.parametrize("name", [n if n in OFTEN else pytest.param(n, marks=pytest.mark.slow) for n in ALONE])
def test_derivatives_are_those_of_the_reading(name: str) -> None:
    told = run(f"{name} step")
    shared, local = plant_of(told, [name])
    sim, tight = simulator_of(told), simulator_of(told, tolerance=TIGHT)
    by_shared, by_local = derivatives(sim, shared, local)
    rows, steps = np.vstack([by_shared, by_local]), sim.steps(shared)
    seen = [*range(shared.size + 1), *range(shared.size + 2, shared.size + sim.layout.own_states.start)]
    for row in seen:  # at rest, velocity and own states are no parameters
        slope = central(tight, shared, local, row, 2 * steps[row])
        near = 5e-3 if name == "power_damping" else 2e-3  # its law bends without bound toward rest
        assert np.linalg.norm(rows[row] - slope) < near * np.linalg.norm(slope), f"parameter {row}"
        assert np.linalg.norm(slope) > 0, f"parameter {row}"


def test_derivatives_are_those_that_are_wanted() -> None:
    told = run("cubic_stiffness step")
    shared, local = plant_of(told, ["cubic_stiffness"])
    sim = simulator_of(told)
    every = derivatives(sim, shared, local)
    reading = sim.readings(shared[None], local[None])[0]
    wanted = np.arange(shared.size) % 2 == 0
    some = sim.derivatives(shared, local, reading, wanted, np.zeros(local.shape, bool))
    # which of them follow from others depends on what is wanted: either way they are as good
    np.testing.assert_allclose(some[0][wanted], every[0][wanted], rtol=0, atol=1e-4 * np.abs(every[0]).max())
    np.testing.assert_array_equal(some[0][2], every[0][2])
    assert not some[0][~wanted].any()
    assert not some[1].any()
    assert every[1][0].any()


@pytest.mark.parametrize("name", ["flexible_coupling", "viscoelastic_spring", "presliding_hysteresis"])
def test_own_states_count_where_a_record_starts_in_motion(name: str) -> None:
    """A second mass, a creeping spring or a bent asperity need not be at rest there."""
    told = run(f"{name} step")
    effects, still = resolve([name]), records_of(told)
    moving = replace(still, moving=np.ones_like(still.moving))
    shared, local = plant_of(told, [name])
    local[0], local[1] = 0.004, -0.02
    sim = Simulator(moving, effects)
    own = sim.layout.own_states
    assert build(moving, effects).active[own].all()
    assert not build(still, effects).active[own].any()
    rows, steps = np.vstack(derivatives(sim, shared, local)), sim.steps(shared)
    tight = Simulator(moving, effects, TIGHT)
    for row in range(shared.size, shared.size + own.stop):
        slope = central(tight, shared, local, row, steps[row])
        assert np.linalg.norm(slope) > 0
        assert np.linalg.norm(rows[row] - slope) < 2e-3 * np.linalg.norm(slope)


@pytest.mark.parametrize(
    ("name", "parameter"),
    [("flexible_coupling", "damping"), ("quadratic_damping", "coefficient"), ("cubic_stiffness", "coefficient")],
)
def test_a_parameter_at_zero_has_a_derivative(name: str, parameter: str) -> None:
    """Else a fit that touches a bound would stay there."""
    told = run(f"{name} step")
    shared, local = plant_of(told, [name])
    sim = simulator_of(told)
    row = sim.layout.linear.stop + [q.name for q in sim.effects[0].parameters].index(parameter)
    truth = shared[row]
    shared[row] = 0.0
    found = derivatives(sim, shared, local)[0][row]
    slope = central(simulator_of(told, tolerance=TIGHT), shared, local, row, 1e-5 * truth)
    assert np.linalg.norm(slope) > 0
    assert np.linalg.norm(found - slope) < 2e-3 * np.linalg.norm(slope)


def test_a_stiffness_of_one_run_costs_that_run_only() -> None:
    """Runs that a parameter does not enter keep a zero derivative."""
    told = run("coulomb_friction step")
    records = records_of(told)
    one = records.runs[0]
    both = records.like([one, one.model_copy(update={"name": "other"})])
    both = replace(both, springs=("a", "stiffer"), spring=np.array([0, 1]))
    sim = Simulator(both, resolve(["coulomb_friction"]))
    shared = np.array([told.mass, told.stiffness, 1.5 * told.stiffness, told.damping, told.gain, 0.3])
    by_shared, _ = derivatives(sim, shared, np.zeros((sim.layout.n_run, 2)))
    first, second = both.pieces()
    assert not by_shared[1, second].any()
    assert not by_shared[2, first].any()
    assert by_shared[1, first].any()
    assert by_shared[2, second].any()
