"""What is different in one run: each deviation against a plant that is different, and its derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stepid
from stepid.effects import resolve
from stepid.simulation.layout import DEVIATIONS
from stepid.simulation.records import Records, lay_out
from stepid.simulation.simulator import Simulator

STEP = 0.005  # s
PLANT = {"mass": 0.9, "stiffness": 210.0, "damping": 3.0, "gain": 8.0, "friction": 0.3}


def records(late: float = 0.0, *, released: bool = False) -> Records:
    time = STEP * np.arange(400) - late
    volts = np.where((time >= 0.25 - 1e-9) & (time < 1.2 - 1e-9), 1.0, 0.0)
    runs = [
        stepid.Experiment(
            name=name,
            time=STEP * np.arange(400),
            position=0.04 * volts,
            input=volts,
            added_mass=0.0,
            spring="a",
            damper="b",
        )
        for name in ("one", "two")
    ]
    laid = lay_out(stepid.Campaign(name="two", experiments=tuple(runs)))
    return replace(laid, moving=np.array([False, released]))


def simulator(late: float = 0.0, **options: bool) -> Simulator:
    return Simulator(records(late, **options), resolve(["coulomb_friction"]), 1e-11)


def plant(sim: Simulator, **other: float) -> tuple[np.ndarray, np.ndarray]:
    shared = np.array([(PLANT | other)[name] for name in PLANT])
    return shared, np.zeros((sim.layout.n_run, 2))


def reading(sim: Simulator, shared: np.ndarray, local: np.ndarray) -> np.ndarray:
    return np.asarray(sim.readings(shared[None], local[None])[0].reshape(2, -1))


@pytest.mark.parametrize(
    ("name", "size", "other"),
    [
        ("added_mass", 0.2, {"mass": 1.1}),
        ("stiffness", 0.1, {"stiffness": 231.0}),
        ("damping", -0.1, {"damping": 2.7}),
        ("gain", -2.0, {"gain": -8.0}),
        ("friction", 0.1, {"friction": 0.33}),
    ],
)
def test_a_run_that_is_different_moves_as_a_plant_that_is(name: str, size: float, other: dict[str, float]) -> None:
    sim = simulator()
    shared, local = plant(sim)
    local[sim.layout.deviation(name), 1] = size
    there, here = reading(sim, shared, local), reading(sim, *plant(sim))
    np.testing.assert_array_equal(there[0], here[0])
    whole = reading(sim, *plant(sim, **other))[1]
    assert np.abs(there[1] - whole).max() < 1e-3 * np.abs(whole - here[1]).max()


@pytest.mark.parametrize("samples", [1, -1, 3])
def test_a_late_run_is_the_same_some_samples_later(samples: int) -> None:
    sim = simulator()
    shared, local = plant(sim)
    local[sim.layout.deviation("start_time"), 1] = samples * STEP
    late, there = reading(sim, shared, local)[1], reading(simulator(samples * STEP), shared, 0.0 * local)[1]
    np.testing.assert_allclose(late[:-3], there[:-3], atol=1e-9)


def test_a_run_half_a_sample_late_lies_between() -> None:
    sim = simulator()
    shared, local = plant(sim)
    local[sim.layout.deviation("start_time"), 1] = 0.5 * STEP
    half = reading(sim, shared, local)[1]
    states = sim.solve(shared, 0.0 * local).states[0].reshape(2, -1)[1]  # type: ignore[union-attr]
    between = 0.5 * (states[1:] + states[:-1])
    assert np.abs(half[1:] - between).max() < 0.02 * np.abs(np.diff(states)).max()


def test_a_released_run_has_no_start_time() -> None:
    sim = simulator(released=True)
    shared, local = plant(sim)
    local[0, 1] = 0.02
    still = reading(sim, shared, local)
    local[sim.layout.deviation("start_time")] = STEP
    there = reading(sim, shared, local)
    np.testing.assert_array_equal(there[1], still[1])
    assert np.abs(there[0] - still[0]).max() > 1e-4


@pytest.mark.parametrize("late", [0.0, 0.3 * STEP, -1.7 * STEP])
def test_derivatives_are_those_of_the_reading(late: float) -> None:
    sim = simulator()
    shared, local = plant(sim)
    local[sim.layout.deviations, 1] = 0.02
    local[sim.layout.deviation("start_time"), 1] = late
    here = reading(sim, shared, local)
    wanted, active = np.ones(shared.size, bool), np.ones(local.shape, bool)
    found = sim.derivatives(shared, local, here.ravel(), wanted, active)
    for q in DEVIATIONS:
        row = sim.layout.deviation(q.name)
        sides = []
        for way in (1e-5, -1e-5):
            moved = local.copy()
            moved[row, 1] += way
            sides.append(reading(sim, shared, moved)[1])
        slope = (sides[0] - sides[1]) / 2e-5
        assert np.linalg.norm(slope) > 0
        assert np.linalg.norm(found[1][row, 400:] - slope) < 5e-3 * np.linalg.norm(slope), q.name
    for p in range(shared.size):
        moved_shared = np.repeat(shared[None], 2, axis=0)
        moved_shared[:, p] += np.array([1e-5, -1e-5]) * shared[p]
        ends = [reading(sim, s, local).ravel() for s in moved_shared]
        slope = (ends[0] - ends[1]) / (2e-5 * shared[p])
        assert np.linalg.norm(found[0][p] - slope) < 5e-3 * np.linalg.norm(slope), p


def test_a_model_keeps_and_applies_them() -> None:
    run = stepid.RunState(deviations={"start_time": STEP, "gain": 0.1})
    model = stepid.PlantModel(
        base_mass={"cart": 0.9},
        stiffness={"a": 210.0},
        damping={"b": 3.0},
        force_gain=8.0,
        runs={"one": run, "two": stepid.RunState()},
    )
    assert "deviations" not in model.to_dict()["runs"]["two"]
    assert stepid.PlantModel.from_dict(model.to_dict()) == model
    experiments = tuple(e.model_copy(update={"base": "cart"}) for e in records().runs)
    seen = stepid.simulate(model, stepid.Campaign(name="two", experiments=experiments))
    np.testing.assert_allclose(seen["one"][1:], 1.1 * seen["two"][:-1], atol=1e-9)
