"""Derivatives that follow from others: the units that they rest on, and what they are worth."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from hidden.accuracy_cases import ALONE, run
from hidden_runs import central, plant_of, records_of, simulator_of
from stepid.core.base import Array
from stepid.effects import resolve
from stepid.effects.base import Effect, Moment, Parameter, Values
from stepid.fitting.problem import build
from stepid.simulation.homogeneity import Following
from stepid.simulation.magnitudes import lengths, masses, times
from stepid.simulation.simulator import Simulator

OFTEN = (
    "coulomb_friction",
    "presliding_hysteresis",
    "viscoelastic_spring",
    "flexible_coupling",
    "periodic_disturbance",
)
TOLD = [e.name for e in resolve(list(ALONE)) if e.own_units is not None]
NAMES = [n if n in OFTEN else pytest.param(n, marks=pytest.mark.slow) for n in TOLD]


CASES = [(n, unit) for n in TOLD for unit in (lengths, masses, times) if unit is not times or "actuator" not in n]


@pytest.mark.parametrize(("name", "unit"), [case for case in CASES if case != ("input_delay", times)])
def test_units_tell_how_a_law_scales(name: str, unit: object) -> None:
    """In another unit of length, mass or time each effect of the catalogue moves the cart as before."""
    kind = "release" if unit is times else "step"
    told = run(f"{name} {kind}")
    shared, local = plant_of(told, [name])
    records, effects = records_of(told), resolve([name])
    sim = Simulator(records, effects)
    of, own = sim.layout, tuple(q for e in effects for q in e.parameters)
    seen = sim.readings(shared[None], local[None])[0]
    power = {lengths: (0, 0, 0, 1), masses: (1, 1, 1, 1), times: (0, -2, -1, 0)}[unit]  # mass, stiffness, damping, gain
    other, start = shared * 2.0 ** np.array([*power, *np.zeros(len(own))]), local.copy()
    other[of.linear.stop :] = scaled(shared[of.linear.stop :], own, unit)
    if unit is lengths:
        start[:2] *= 2.0
    if unit is times:
        records = replace(records, time=2.0 * records.time, sample_time=2.0 * records.sample_time)
        start[1] /= 2.0
        if name == "periodic_disturbance":
            other[of.linear.stop + 1] = 0.5 * shared[of.linear.stop + 1]
    again = Simulator(records, effects).readings(other[None], start[None])[0]
    far = 2.0 if unit is lengths else 1.0
    np.testing.assert_allclose(again, far * seen, rtol=0, atol=2e-5 * np.abs(seen).max())


def scaled(values: Array, own: tuple[Parameter, ...], unit: object) -> Array:
    """Values of parameters where the unit is half as large."""
    change = unit(own, values)  # type: ignore[operator]
    return values * 2.0 ** np.where(values == 0, 0.0, change / np.where(values == 0, 1.0, values))


@pytest.mark.parametrize("kind", ["step", "release"])
@pytest.mark.parametrize("name", NAMES)
def test_derivatives_that_follow_are_those_of_the_reading(name: str, kind: str) -> None:
    told = run(f"{name} {kind}")
    shared, local = plant_of(told, [name])
    sim, tight = simulator_of(told), simulator_of(told, tolerance=1e-12)
    found, rows = followed(sim, shared, local)
    assert (found.row[2] >= 0).all(), "a mass has weights added, and follows"
    free = not np.any(told.inputs) and not told.input_before  # effects of the drive are let go by it
    assert (found.row[1] >= 0).all() == (free and name != "periodic_disturbance")
    steps = sim.steps(shared)
    for row in found.row[found.row >= 0]:
        slope = central(tight, shared, local, row, steps[row])
        assert np.linalg.norm(rows[row] - slope) < 1e-3 * np.linalg.norm(slope), f"parameter {row}"


def followed(sim: Simulator, shared: Array, local: Array) -> tuple[Following, Array]:
    """What follows where all that a fit may free is free, and all derivatives, shape (P + Q, S)."""
    problem = build(sim.records, sim.effects)
    wanted, solved = np.ones(shared.size, dtype=bool), sim.solve(shared, local)
    assert solved is not None
    found = sim._homogeneity.following(shared, local, wanted, problem.active, flow=True)
    return found, np.vstack(sim.derivatives(shared, local, solved.reading, wanted, problem.active, solved.states))


class Tether(Effect):
    """A law from outside, whose length is a number in it: units do not tell how it scales."""

    name = "tether"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("stiffness", "N/m"),)

    def starts(self, scales: object) -> list[tuple[float, ...]]:
        return [(1.0,)]

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * m.x * abs(m.x) / 0.01


def test_the_laws_of_the_catalogue_tell_their_units() -> None:
    """But power damping, whose law is smooth at rest by a speed that is a number in it."""
    assert set(ALONE) - set(TOLD) == {"power_damping"}
    for effect in resolve(TOLD):
        assert len(effect.own_units or ()) == effect.n_extra + effect.n_memory


def test_nothing_follows_where_a_law_does_not_tell_its_units() -> None:
    told = run("cubic_stiffness step")
    shared, local = plant_of(told, ["cubic_stiffness"])
    shared[-1] = 20.0
    found, rows = followed(Simulator(records_of(told), (Tether(),)), shared, local)
    assert (found.row == -1).all()
    assert not found.spared.any()
    assert rows[0].any()


@pytest.mark.parametrize(("start", "spared"), [(0.0004, False), (0.004, True)])
def test_no_derivative_follows_from_a_start_that_is_hardly_off_rest(start: float, spared: bool) -> None:
    """A small difference of large numbers would be left."""
    told = run("coulomb_friction release")
    shared, local = plant_of(told, ["coulomb_friction"])
    local[0] = start
    found, rows = followed(simulator_of(told), shared, local)
    assert found.spared[shared.size, 0] == spared
    assert rows[shared.size].any()


def test_what_is_held_in_a_fit_takes_along_what_would_follow_from_it() -> None:
    told = run("coulomb_friction step")
    shared, local = plant_of(told, ["coulomb_friction"])
    sim = simulator_of(told)
    active = build(sim.records, sim.effects).active
    for held, rows in ((4, [-1, -1, -1]), (1, [3, -1, -1]), (0, [3, -1, -1])):  # friction, stiffness, mass
        wanted = np.arange(shared.size) != held
        found = sim._homogeneity.following(shared, local, wanted, active, flow=True)
        assert found.row[:, 0].tolist() == rows
