"""The hidden simulator's drive between the samples, and its new effects, against closed forms and brute force."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.special import ellipk

from hidden import Run, fast, reference
from hidden.drive import course, value

COUNT = 1 / 226600
T = 0.0088542
ACTUATOR = {
    "input_delay": {"delay": 0.013},
    "actuator_dead_zone": {"level": 0.05},
    "actuator_saturation": {"level": 0.4},
    "actuator_rate_limit": {"rate": 4.0},
}


def wavy(size: int = 120) -> np.ndarray:
    steps = np.random.default_rng(3).standard_normal(size)
    return 0.5 * np.sin(np.arange(size) / 9) + 0.02 * np.cumsum(steps) + 0.02


def moved(**changes: object) -> Run:
    run = Run(1.45, 216.0, 6.0, -7.8, T, wavy(), input_before=0.1)
    return replace(run, **changes)  # type: ignore[arg-type]


def brute(run: Run, parts: int) -> np.ndarray:
    """Volts after delay, dead zone, saturation and rate limit on a fine grid, one point after the other."""
    n = run.size
    times = T / parts * np.arange((n - 1) * parts + 1) - run.get("input_delay", "delay")
    u = np.asarray(run.inputs)
    if run.input_between == "held":
        volts = u[np.clip(np.floor(times / T + 1e-9).astype(int), 0, n - 1)]
    elif run.input_between == "straight":
        volts = np.interp(times, T * np.arange(n), u)
    else:
        volts = CubicSpline(T * np.arange(n), u)(times)
    volts = np.append(np.where(times < -1e-12, run.input_before, volts), run.input_before)
    volts = np.sign(volts) * np.maximum(np.abs(volts) - run.get("actuator_dead_zone", "level"), 0.0)
    limit = run.get("actuator_saturation", "level", math.inf)
    volts = np.clip(volts, -limit, limit)
    rate = run.get("actuator_rate_limit", "rate", math.inf) * T / parts
    now, out = float(volts[-1]), []
    for wanted in volts[:-1]:
        out.append(now)
        now += float(np.clip(wanted - now, -rate, rate))
    return np.array(out)


@pytest.mark.parametrize("between", ["held", "straight", "smooth"])
@pytest.mark.parametrize("effects", [tuple(ACTUATOR), ("input_delay", "actuator_rate_limit")])
def test_the_course_of_the_drive_is_that_of_small_steps(between: str, effects: tuple[str, ...]) -> None:
    run, parts = moved(input_between=between, effects={n: ACTUATOR[n] for n in effects}), 500
    before, pieces = course(run)
    begins = np.array([begin for begin, _ in pieces])
    assert np.all(np.diff(begins) > 0)
    times = T / parts * np.arange((run.size - 1) * parts + 1)
    which = np.searchsorted(begins, times + 1e-12, side="right") - 1
    exact = [before if i < 0 else value(pieces[i][1], t - begins[i]) for i, t in zip(which, times, strict=True)]
    off = np.abs(np.array(exact) / run.gain - brute(run, parts))
    assert np.max(off) < 3 * 4.0 * T / parts  # the small steps are late by one or two of their own
    assert np.median(off) < 0.3 * 4.0 * T / parts + 1e-4


@pytest.mark.parametrize("between", ["straight", "smooth"])
@pytest.mark.parametrize("name", ["", "coulomb_friction", "actuator_lag"])
def test_the_two_routes_agree_on_inputs_that_are_not_held(between: str, name: str) -> None:
    effects = {"": {}, "coulomb_friction": {name: {"level": 0.3}}, "actuator_lag": {name: {"time_constant": 0.01}}}[
        name
    ]
    for more in ({}, ACTUATOR):
        run = moved(input_between=between, effects={**effects, **more})
        assert np.max(np.abs(reference(run) - fast([run])[0])) < 0.005 * COUNT


@pytest.mark.slow
def test_lines_and_splines_through_a_line_are_the_same() -> None:
    inputs = 0.004 * np.arange(100)
    one, two = (reference(moved(inputs=inputs, input_before=0.0, input_between=b)) for b in ("straight", "smooth"))
    np.testing.assert_allclose(one, two, atol=1e-5 * COUNT)
    # many held levels a sample come to the same
    fine = reference(moved(inputs=0.004 / 64 * (np.arange(100 * 64) + 0.5), sample_time=T / 64, input_before=0.0))
    np.testing.assert_allclose(fine[::64], one, atol=0.01 * COUNT)


@pytest.mark.parametrize("curvature", [30.0, 90.0])
def test_a_pendulum_has_its_closed_period(curvature: float) -> None:
    mass, stiffness, amplitude = 1.2, 216.0, 0.02
    period = 4 * ellipk(math.sin(curvature * amplitude / 2) ** 2) * math.sqrt(mass / stiffness)
    effects = {"sine_stiffness": {"curvature": curvature}}
    run = Run(mass, stiffness, 0.0, 7.8, period / 50, np.zeros(301), effects, position=amplitude)
    for x in (reference(run), fast([run])[0]):
        np.testing.assert_allclose(x[::50], amplitude, atol=0.01 * COUNT)
        np.testing.assert_allclose(x[25::50], -amplitude, atol=0.01 * COUNT)


@pytest.mark.parametrize(("exponent", "twin"), [(1.0, None), (2.0, {"quadratic_damping": {"coefficient": 3.0}})])
def test_a_power_of_one_is_viscous_and_of_two_quadratic(exponent: float, twin: dict | None) -> None:
    run = moved(effects={"power_damping": {"coefficient": 3.0, "exponent": exponent}}, input_before=0.0)
    same = replace(run, damping=9.0, effects={}) if twin is None else replace(run, effects=twin)
    for x in (reference(run), fast([run])[0]):
        np.testing.assert_allclose(x, reference(same), atol=0.002 * COUNT)


def test_a_power_near_zero_is_dry_friction_that_creeps() -> None:
    inputs = np.repeat([0.0, 0.5], [3, 200])
    powers = [{"power_damping": {"coefficient": 0.3, "exponent": p}} for p in (0.5, 0.3, 0.1)]
    dry = reference(moved(inputs=inputs, input_before=0.0, effects={"coulomb_friction": {"level": 0.3}}))
    off = [np.std(reference(moved(inputs=inputs, input_before=0.0, effects=e)) - dry) for e in powers]
    assert off[0] > off[1] > off[2]
    run = moved(inputs=inputs, input_before=0.0, effects=powers[1])
    np.testing.assert_allclose(fast([run])[0], reference(run), atol=0.005 * COUNT)
