"""The drive between the samples: held, straight and smooth inputs, uneven times, delays, the chain of its effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import stepid
from hidden.accuracy_cases import ALONE, COUNTS, run
from hidden.plant import Run
from hidden_runs import plant_of, polynomials, records_of, simulated, simulator_of
from stepid.effects import resolve
from stepid.simulation.records import lay_out
from stepid.simulation.simulator import Simulator

PERIOD, SIZE = 0.0088542, 160
WAVE = 0.4 * np.sin(np.arange(SIZE) / 7.0)


def plain(inputs: np.ndarray, between: str = "held", **effects: dict[str, float]) -> Run:
    return Run(1.5, 216.0, 6.0, 7.8, PERIOD, inputs, effects, phase=0.7, input_between=between)


@pytest.mark.parametrize("between", ["held", "straight", "smooth"])
def test_the_input_between_the_samples_is_what_its_coefficients_say(between: str) -> None:
    time = PERIOD * np.arange(SIZE)
    spline = CubicSpline(time, WAVE)

    def volts(t: float, i: int) -> float:
        if between == "held":
            return float(WAVE[i])
        return float(spline(t)) if between == "smooth" else float(np.interp(t, time, WAVE))

    state, expected = np.zeros(2), np.zeros(SIZE)
    for i in range(SIZE - 1):

        def rates(t: float, y: np.ndarray, i: int = i) -> list[float]:
            return [y[1], (7.8 * volts(t, i) - 216.0 * y[0] - 6.0 * y[1]) / 1.5]

        state = solve_ivp(rates, (time[i], time[i + 1]), state, "DOP853", rtol=1e-11, atol=1e-14).y[:, -1]
        expected[i + 1] = state[0]
    np.testing.assert_allclose(simulated(plain(WAVE, between)), expected, rtol=0, atol=1e-3 / COUNTS)


@pytest.mark.parametrize("name", ["cubic_stiffness", "stribeck_friction", "actuator_lag", "actuator_rate_limit"])
def test_an_input_on_a_straight_line_may_be_told_in_every_way(name: str) -> None:
    """A line is a line whether it is told as one or as a cubic, and so is a level that is held."""
    line = np.linspace(0.0, 0.5, SIZE)
    both = [simulated(plain(line, way, **{name: ALONE[name]})) for way in ("straight", "smooth")]
    np.testing.assert_allclose(both[0], both[1], rtol=0, atol=2e-3 / COUNTS)
    level = np.full(SIZE, 0.45)
    ways = [simulated(plain(level, way, **{name: ALONE[name]})) for way in ("held", "straight", "smooth")]
    np.testing.assert_allclose(ways[0], ways[1], rtol=0, atol=2e-3 / COUNTS)
    np.testing.assert_allclose(ways[0], ways[2], rtol=0, atol=2e-3 / COUNTS)


@pytest.mark.parametrize("name", ["", *ALONE])
def test_an_uneven_clock_gives_the_same_states_at_shared_moments(name: str) -> None:
    told = run(f"{name} step" if name else "linear step")
    records = records_of(told)
    rng = np.random.default_rng(8)
    extra = rng.choice(told.size - 1, 120, replace=False)
    times = np.concatenate([records.time, records.time[extra] + PERIOD * rng.uniform(0.05, 0.95, 120)])
    order = np.argsort(times)
    denser = replace(
        records,
        time=times[order],
        coefficients=np.concatenate([records.coefficients, records.coefficients[extra]])[order],
        bounds=np.array([0, times.size]),
    )
    shared, local = plant_of(told, list(told.effects))
    effects = resolve(list(told.effects))
    found = []
    for of in (records, denser):
        sim = Simulator(of, effects)
        sim.scale = Simulator(records, effects).scale
        found.append(sim.readings(shared[None], local[None])[0])
    shared_moments = np.flatnonzero(order < told.size)
    np.testing.assert_allclose(found[1][shared_moments], found[0], rtol=0, atol=8e-3 / COUNTS)


@pytest.mark.parametrize("delay", [0.0, 0.31 * PERIOD, PERIOD, 1.73 * PERIOD, 6.4 * PERIOD])
@pytest.mark.parametrize("name", ["cubic_stiffness", "coulomb_friction", "flexible_coupling"])
def test_a_delay_between_the_samples_is_a_later_clock(name: str, delay: float) -> None:
    """What a delayed plant does at t, one without does at t less the delay."""
    inputs = np.repeat([0.0, 0.5, -0.3], [5, 80, SIZE - 85])
    late = simulated(plain(inputs, **{name: ALONE[name], "input_delay": {"delay": delay}}))
    told = plain(inputs, **{name: ALONE[name]})
    records = records_of(told)
    whole = int(delay // PERIOD)
    share = delay - whole * PERIOD
    # a record of the moments t − delay beside the samples at which the input changes
    moments = np.concatenate([records.time, records.time[1:] - share])
    order = np.argsort(moments, kind="stable")
    volts = records.coefficients[1:] if share == 0 else records.coefficients[:-1]
    held = np.concatenate([records.coefficients, volts])[order]
    denser = replace(
        records,
        time=moments[order],
        coefficients=held,
        bounds=np.array([0, moments.size]),
    )
    shared, local = plant_of(told, [name])
    sim = Simulator(denser, resolve([name]))
    sim.scale = simulator_of(told).scale
    reading = sim.readings(shared[None], local[None])[0]
    early = np.concatenate([np.zeros(whole + 1), reading[np.argsort(order)[SIZE:]]])[:SIZE]
    np.testing.assert_allclose(late, early, rtol=0, atol=5e-3 / COUNTS)


def test_the_order_in_which_effects_are_given_does_not_matter() -> None:
    names = ["actuator_lag", "input_delay", "actuator_rate_limit", "actuator_dead_zone", "actuator_saturation"]
    names += ["presliding_hysteresis", "end_stop", "flexible_coupling"]
    inputs = np.repeat([0.0, 0.5, -0.4], [5, 80, SIZE - 85])
    ways = [names, names[::-1], sorted(names)]
    found = [simulated(plain(inputs, **{n: ALONE[n] for n in way})) for way in ways]
    assert np.ptp(found[0]) > 1e-3
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], rtol=0, atol=1e-5 / COUNTS)


def test_the_drives_chain_is_dead_zone_then_saturation_then_lag() -> None:
    """The dead zone takes 0.1 V from 0.5 V, the saturation leaves 0.3 V: the lag ends there."""
    inputs = np.repeat([0.0, 0.5], [5, 400])
    effects = {"actuator_lag": {"time_constant": 0.02}, "actuator_saturation": {"level": 0.3}}
    chain = simulated(plain(inputs, **effects, actuator_dead_zone={"level": 0.1}))
    assert chain[-1] == pytest.approx(0.3 * 7.8 / 216.0, rel=3e-3)
    lone = simulated(plain(0.6 * inputs, actuator_lag={"time_constant": 0.02}))
    np.testing.assert_allclose(chain, lone, rtol=0, atol=1e-12)
    weak = simulated(plain(0.76 * inputs, **effects, actuator_dead_zone={"level": 0.1}))
    assert weak[-1] == pytest.approx(0.28 * 7.8 / 216.0, rel=3e-3)


@pytest.mark.parametrize("lag", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5])
def test_a_lag_beside_a_curved_spring_is_followed_however_fast(lag: float) -> None:
    inputs = np.full(12, 0.4)
    told = plain(inputs, cubic_stiffness={"coefficient": 2e5}, actuator_lag={"time_constant": lag})

    def rates(t: float, y: np.ndarray) -> list[float]:
        force = 7.8 * 0.4 * -np.expm1(-t / lag) - 216.0 * y[0] - 6.0 * y[1] - 2e5 * y[0] ** 3
        return [y[1], force / 1.5]

    time = PERIOD * np.arange(12)
    exact = solve_ivp(rates, (0, time[-1]), np.zeros(2), "Radau", time, rtol=1e-11, atol=1e-14, max_step=1e-3).y[0]
    np.testing.assert_allclose(simulated(told), exact, rtol=0, atol=2e-3 / COUNTS)


def test_a_lag_that_has_followed_stays_where_it_is() -> None:
    """However stiff: no rounding error grows in it."""
    told = plain(np.full(1500, 0.4), cubic_stiffness={"coefficient": 2e5}, actuator_lag={"time_constant": 1e-5})
    found = simulated(replace(told, input_before=0.4))
    np.testing.assert_allclose(found, found[0], rtol=0, atol=1e-12)
    assert 216.0 * found[0] + 2e5 * found[0] ** 3 == pytest.approx(0.4 * 7.8, rel=1e-9)


def test_coefficients_are_those_of_the_grid() -> None:
    """The helper of these tests: every way meets the samples."""
    time = PERIOD * np.arange(SIZE)
    for way, width in (("held", 1), ("straight", 2), ("smooth", 4)):
        rows = polynomials(time, WAVE, way)
        assert rows.shape == (SIZE, width)
        np.testing.assert_allclose(rows[:, 0], WAVE, rtol=0, atol=1e-12)
        if width > 1:
            ends = sum(rows[:-1, k] * PERIOD**k for k in range(width))
            np.testing.assert_allclose(ends, WAVE[1:], rtol=0, atol=1e-12)


def test_a_run_is_driven_by_its_input_or_by_that_before_its_record() -> None:
    pushed, still, released = plain(-WAVE), plain(np.zeros(SIZE)), replace(plain(np.zeros(SIZE)), input_before=0.7)
    runs = tuple(
        records_of(told).runs[0].model_copy(update={"name": f"{i}"}) for i, told in enumerate((pushed, still, released))
    )
    records = lay_out(stepid.Campaign(name="c", experiments=runs))
    assert records.largest_input == pytest.approx([np.abs(WAVE).max(), 0.0, 0.7])
    assert records.driven.tolist() == [True, False, True]
