"""The kernel's edges: where a record starts, runaways, threads, room, exact steps."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest
from scipy.linalg import expm

from hidden.accuracy_cases import ALONE, COUNTS, run
from hidden.plant import Run
from hidden_runs import plant_of, records_of, simulated, simulator_of
from stepid.effects import CATALOGUE, Effect, Moment, Parameter, resolve
from stepid.effects.base import Values
from stepid.errors import InputError
from stepid.simulation import kernel
from stepid.simulation.simulator import COARSE, PATIENT, Simulator

PERIOD = 0.0088542
LINEAR = [e.name for e in CATALOGUE if e.linear]


class Nowhere(Effect):
    """A law from outside with a switch that nothing can locate: its margin is infinite on one side."""

    name = "nowhere"
    parameters = (Parameter("position", "m"),)
    n_switches: ClassVar[int] = 1

    @staticmethod
    def switches(p: Values, m: Moment) -> tuple[float, ...]:
        return (math.inf if m.x > p[0] else -1.0,)


def release(position: float, velocity: float = 0.0, size: int = 200, **effects: dict[str, float]) -> Run:
    return Run(1.5, 216.0, 2.0, 7.8, PERIOD, np.zeros(size), effects, position=position, velocity=velocity)


@pytest.mark.parametrize("damping", [1e-9, 1e-3, 2.0, 400.0, 1e5])
@pytest.mark.parametrize("mass", [1e-3, 0.25, 3.0])
def test_exact_steps_are_matrix_exponentials(damping: float, mass: float) -> None:
    """However far apart the rates: a second mass, a creeping spring and a lag at once."""
    inputs = np.random.default_rng(5).normal(size=60)
    effects = {
        "flexible_coupling": {"mass": mass, "stiffness": 800.0, "damping": 0.8},
        "viscoelastic_spring": {"stiffness": 60.0, "damping": 6.0},
        "actuator_lag": {"time_constant": 0.01},
    }
    told = Run(1.5, 216.0, damping, 7.8, PERIOD, inputs, effects)
    a = np.zeros((7, 7))  # x, v, x2, v2, f, w, u
    a[0, 1] = a[2, 3] = 1.0
    a[1] = np.array([-216.0 - 800.0, -damping - 0.8, 800.0, 0.8, -1.0, 7.8, 0.0]) / 1.5
    a[3] = np.array([800.0, 0.8, -800.0, -0.8, 0.0, 0.0, 0.0]) / mass
    a[4] = [0.0, 60.0, 0.0, 0.0, -10.0, 0.0, 0.0]
    a[5] = [0.0, 0.0, 0.0, 0.0, 0.0, -100.0, 100.0]
    step, state, expected = expm(a * PERIOD), np.zeros(7), np.zeros(inputs.size)
    for i in range(inputs.size - 1):
        state[6] = inputs[i]
        state = step @ state
        expected[i + 1] = state[0]
    found = simulated(told)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["", *LINEAR])
def test_exact_steps_and_small_ones_agree(name: str) -> None:
    """A held input told as a line takes Runge-Kutta steps."""
    told = run(f"{name} step" if name else "linear step")
    records = records_of(told)
    lines = replace(records, coefficients=np.pad(records.coefficients, ((0, 0), (0, 1))))
    shared, local = plant_of(told, list(told.effects))
    both = [Simulator(r, resolve(list(told.effects))).readings(shared[None], local[None]) for r in (records, lines)]
    np.testing.assert_allclose(both[1], both[0], rtol=0, atol=1e-3 / COUNTS)


@pytest.mark.parametrize(("position", "velocity"), [(0.01, 0.0), (0.0, 0.2), (-0.004, 0.15), (0.02, -0.3)])
def test_a_record_starts_in_the_state_that_it_is_told(position: float, velocity: float) -> None:
    told = release(position, velocity)
    sim = simulator_of(told)
    sim.records = replace(sim.records, moving=np.array([True]))
    found = sim.solve(*plant_of(told, []))
    assert found is not None
    sigma = 2.0 / 3.0
    rate = np.sqrt(216.0 / 1.5 - sigma**2)
    time = PERIOD * np.arange(told.size)
    swing = position * np.cos(rate * time) + (velocity + sigma * position) / rate * np.sin(rate * time)
    np.testing.assert_allclose(found.reading, np.exp(-sigma * time) * swing, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(found.states[0], found.reading)
    assert found.states[1, 0] == velocity


def test_a_record_that_is_to_begin_at_rest_begins_with_the_velocity_of_its_run() -> None:
    told = Run(1.5, 216.0, 2.0, 7.8, PERIOD, np.zeros(50))
    shared, local = plant_of(told, [])
    sim = simulator_of(told)
    assert not sim.readings(shared[None], local[None]).any()
    local[1] = 0.3
    np.testing.assert_array_equal(sim.start(shared, local), [[0.0], [0.3]])
    decay, swing = 2.0 / 3.0, np.sqrt(216.0 / 1.5 - (2.0 / 3.0) ** 2)
    time = PERIOD * np.arange(50)
    free = 0.3 / swing * np.exp(-decay * time) * np.sin(swing * time)
    np.testing.assert_allclose(sim.readings(shared[None], local[None])[0], free, atol=1e-8)


def test_own_states_start_with_a_plant_at_rest() -> None:
    """A second mass at the cart's place, a lag at the voltage before the record."""
    names = ["flexible_coupling", "actuator_lag"]
    told = replace(run("linear step"), effects={n: ALONE[n] for n in names}, input_before=0.3)
    rest = 0.3 * told.gain / told.stiffness
    begun = simulator_of(told).start(*plant_of(told, names))[:, 0]
    np.testing.assert_allclose(begun, [rest, 0.0, rest, 0.0, 0.3], rtol=0, atol=1e-12)


def test_friction_keeps_a_cart_where_it_starts_within_its_band() -> None:
    """The offset of a record at rest is a parameter wherever friction holds."""
    told = Run(1.5, 216.0, 2.0, 7.8, PERIOD, np.zeros(80), {"coulomb_friction": {"level": 0.3}})
    shared, local = plant_of(told, ["coulomb_friction"])
    sim = simulator_of(told)
    for offset in (-0.99, 0.3, 0.99):
        local[0] = offset * 0.3 / 216.0
        np.testing.assert_array_equal(sim.readings(shared[None], local[None])[0], np.full(80, local[0, 0]))
    local[0] = 1.05 * 0.3 / 216.0
    assert sim.readings(shared[None], local[None])[0, -1] < local[0, 0] - 1e-6


@pytest.mark.parametrize(
    "effects",
    [
        {"cubic_stiffness": {"coefficient": -3e6}},
        {"quadratic_stiffness": {"coefficient": -6e4}, "coulomb_friction": {"level": 0.1}},
        {"position_dependent_damping": {"slope": -1e6}},
    ],
)
def test_what_comes_after_a_runaway_is_not_a_number(effects: dict[str, dict[str, float]]) -> None:
    told = Run(1.5, 216.0, 6.0, 7.8, PERIOD, np.repeat([0.0, 0.9], [5, 295]), effects)
    shared, local = plant_of(told, list(effects))
    sim = simulator_of(told)
    reading = sim.readings(shared[None], local[None])[0]
    lost = np.isnan(reading)
    first = int(np.argmax(lost))
    assert first > 5
    assert lost[first:].all()
    assert not lost[:first].any()
    assert sim.solve(shared, local) is None


def test_a_copy_that_runs_away_takes_no_other_with_it() -> None:
    told = run("cubic_stiffness step")
    shared, local = plant_of(told, ["cubic_stiffness"])
    several = np.repeat(shared[None], 3, axis=0)
    several[1, -1] = -3e6
    sim = simulator_of(told)
    reading = sim.readings(several, np.repeat(local[None], 3, axis=0))
    alone = sim.readings(shared[None], local[None])[0]
    assert np.isnan(reading[1]).any()
    np.testing.assert_array_equal(reading[[0, 2]], np.stack([alone, alone]))


@pytest.mark.parametrize("name", ["stribeck_friction", "presliding_hysteresis", "linear", "actuator_rate_limit"])
def test_threads_change_no_bit(name: str) -> None:
    told = run(f"{name} step")
    shared, local = plant_of(told, list(told.effects))
    copies = np.repeat(shared[None], 7, axis=0) * np.linspace(0.9, 1.1, 7)[:, None]
    every = np.repeat(local[None], 7, axis=0)
    one, two = (simulator_of(told, workers=n).readings(copies, every) for n in (1, 2))
    np.testing.assert_array_equal(one, two)
    found = []
    for n in (1, 2):
        sim = simulator_of(told, workers=n)
        found.append(sim.derivatives(shared, local, one[3], np.ones(shared.size, bool), np.ones(local.shape, bool)))
    np.testing.assert_array_equal(found[0][0], found[1][0])
    np.testing.assert_array_equal(found[0][1], found[1][1])


@pytest.mark.parametrize(
    ("names", "what"),
    [
        ([e.name for e in CATALOGUE[: kernel.MOST_EFFECTS + 1]], "effects"),
        (["flexible_coupling"] * 8, "states"),
        (["free_play"] * 5, "switches"),
    ],
)
def test_more_than_there_is_room_for_is_refused(names: list[str], what: str) -> None:
    records = records_of(run("linear step"))
    effects = tuple(e for n in names for e in resolve([n]))
    with pytest.raises(InputError, match=rf"\d+ {what} are more than a simulation holds.*Use fewer effects"):
        Simulator(records, effects)


def test_as_much_as_there_is_room_for_is_simulated() -> None:
    names = ["coulomb_friction", "presliding_hysteresis", "quadratic_damping", "cubic_stiffness", "free_play"]
    names += ["flexible_coupling", "actuator_lag", "actuator_dead_zone"]
    assert len(names) == kernel.MOST_EFFECTS
    told = replace(run("linear step"), effects={n: ALONE[n] for n in names})
    assert np.ptp(simulated(told, patience=PATIENT)) > 1e-3


@pytest.mark.parametrize(
    ("stiffness", "damping", "followed"),
    [
        (1600.0, 1.0, True),  # 40 radians a sample, each worth steps
        (1600.0, 2000.0, False),  # nothing swings, and what is over in a two thousandth of a sample does not show
        (10.0, 20.0, True),  # that takes a few steps
    ],
)
def test_only_what_swings_is_followed_for_long(stiffness: float, damping: float, followed: bool) -> None:
    """Stiffness and damping by the sample's time."""
    k, c = stiffness / PERIOD**2, damping / PERIOD
    told = Run(1.0, k, c, 0.01 * k, PERIOD, np.ones(40), {"cubic_stiffness": {"coefficient": k}}, input_before=0.0)
    shared, local = plant_of(told, ["cubic_stiffness"])
    reading = simulator_of(told, tolerance=COARSE).readings(shared[None], local[None])[0]
    assert np.isfinite(reading).all() == followed
    assert np.isfinite(simulator_of(told, patience=PATIENT).readings(shared[None], local[None])).all()


def test_a_lone_sample_is_where_the_plant_starts() -> None:
    told = Run(1.5, 216.0, 2.0, 7.8, PERIOD, np.zeros(40), {"coulomb_friction": {"level": 0.3}}, input_before=0.2)
    records = records_of(told)
    one = replace(records, time=records.time[:1], coefficients=records.coefficients[:1], bounds=np.array([0, 1]))
    shared, local = plant_of(told, ["coulomb_friction"])
    found = Simulator(one, resolve(["coulomb_friction"])).readings(shared[None], local[None])
    assert found == pytest.approx(0.2 * 7.8 / 216.0, abs=1e-12)


def test_every_case_stays_finite_far_from_its_plant() -> None:
    """A fit asks for such plants on its way."""
    rng = np.random.default_rng(4)
    for name in ALONE:
        told = run(f"{name} step")
        shared, local = plant_of(told, [name])
        copies = shared * np.exp(rng.normal(scale=1.2, size=(6, shared.size)))
        reading = simulator_of(told, tolerance=1e-6).readings(copies, np.repeat(local[None], 6, axis=0))
        assert np.isfinite(reading).all(axis=1).sum() >= 4, name


def test_an_event_that_cannot_be_located_is_a_runaway() -> None:
    records = records_of(release(0.01))
    simulator = Simulator(records, (Nowhere(),))
    local = np.zeros((simulator.layout.n_run, 1))
    local[0] = 0.01
    shared = np.array([1.5, 216.0, 2.0, 7.8, 0.004])
    reading = simulator.readings(shared[None], local[None])[0]
    passed = int(np.argmax(np.isnan(reading)))
    assert 0 < passed < reading.size
    assert np.isnan(reading[passed:]).all()
    assert (reading[:passed] > 0.004).all()
