"""The simulator against closed forms and python-control: nothing here is integrated step by step."""

from __future__ import annotations

from collections.abc import Mapping

import control
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk

import stepid

MASS, STIFFNESS, GAIN, PERIOD = 1.25, 216.0, 7.8, 0.0088542
RATE = float(np.sqrt(STIFFNESS / MASS))
REGIMES = {"none": 0.0, "under": 8.0, "critical": 2 * np.sqrt(STIFFNESS * MASS), "over": 120.0}


def simulated(
    inputs: np.ndarray,
    *,
    damping: float = 8.0,
    effects: Mapping[str, Mapping[str, float]] | None = None,
    start: float | None = None,
    before: float = 0.0,
    period: float = PERIOD,
) -> np.ndarray:
    """Position of one run from rest, or released at `start`."""
    time = period * np.arange(inputs.size)
    shown = np.zeros(inputs.size)
    if start is not None:  # a record that is in motion from its first sample
        shown[0], shown[1:] = start, -start
    run = stepid.Experiment(
        name="run",
        time=time,
        position=shown,
        input=inputs,
        added_mass=0.25,
        spring="medium",
        damper="plug",
        input_before=before,
    )
    model = stepid.PlantModel(
        base_mass={"cart": MASS - 0.25},
        stiffness={"medium": STIFFNESS},
        damping={"plug": damping},
        force_gain=GAIN,
        effects=tuple(stepid.EffectModel(name=n, values=v) for n, v in (effects or {}).items()),
        runs={"run": stepid.RunState(displacement=start or 0.0)},
    )
    return stepid.simulate(model, stepid.Campaign(name="closed form", experiments=(run,)))["run"]


def step_response(time: np.ndarray, damping: float) -> np.ndarray:
    """Response to 1 V from time 0, in every damping regime."""
    t = np.maximum(time, 0.0)
    ratio = damping / (2 * np.sqrt(STIFFNESS * MASS))
    if ratio == pytest.approx(1.0, abs=1e-12):
        decay = np.exp(-RATE * t) * (1 + RATE * t)
    elif ratio < 1:
        sigma, wd = ratio * RATE, RATE * np.sqrt(1 - ratio**2)
        decay = np.exp(-sigma * t) * (np.cos(wd * t) + sigma / wd * np.sin(wd * t))
    else:
        root = RATE * np.sqrt(ratio**2 - 1)
        fast, slow = -ratio * RATE - root, -ratio * RATE + root
        decay = (slow * np.exp(fast * t) - fast * np.exp(slow * t)) / (slow - fast)
    return GAIN / STIFFNESS * (1 - decay)


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("first", [0, 7])
def test_linear_step_in_every_damping_regime(regime: str, first: int) -> None:
    time = PERIOD * np.arange(400)
    inputs = np.where(np.arange(400) >= first, 0.6, 0.0)
    expected = 0.6 * step_response(time - first * PERIOD, REGIMES[regime])
    np.testing.assert_allclose(simulated(inputs, damping=REGIMES[regime]), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("regime", REGIMES)
def test_any_held_input_agrees_with_python_control(regime: str) -> None:
    inputs = np.random.default_rng(3).normal(size=300).repeat(2)
    plant = control.ss(control.tf([GAIN], [MASS, REGIMES[regime], STIFFNESS]))
    sampled = control.c2d(plant, PERIOD, method="zoh")
    expected = control.forced_response(sampled, PERIOD * np.arange(inputs.size), inputs).outputs
    np.testing.assert_allclose(simulated(inputs, damping=REGIMES[regime]), expected, rtol=0, atol=1e-11)


def test_a_plant_that_rests_under_its_input_stays_there() -> None:
    inputs = np.repeat([0.4, 0.0], [50, 250])
    up = simulated(inputs, before=0.4)
    rest = 0.4 * GAIN / STIFFNESS
    np.testing.assert_allclose(up[:51], rest, rtol=0, atol=1e-12)
    time = PERIOD * (np.arange(300) - 50)
    np.testing.assert_allclose(up, rest - 0.4 * step_response(time, 8.0), rtol=0, atol=1e-12)


@pytest.mark.parametrize("delay", [0.0, 0.3 * PERIOD, PERIOD, 1.7 * PERIOD, 9.25 * PERIOD])
def test_a_delay_shifts_the_step_by_itself(delay: float) -> None:
    inputs = np.repeat([0.0, 0.5], [6, 294])
    ours = simulated(inputs, effects={"input_delay": {"delay": delay}})
    expected = 0.5 * step_response(PERIOD * (np.arange(300) - 6) - delay, 8.0)
    np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-12)


def test_coulomb_friction_takes_four_levels_over_stiffness_a_cycle() -> None:
    level, start, samples = 0.15, 0.0125, 40
    off = level / STIFFNESS
    time = np.pi / RATE / samples * np.arange(20 * samples)
    ours = simulated(
        np.zeros(time.size),
        damping=0.0,
        effects={"coulomb_friction": {"level": level}},
        start=start,
        period=np.pi / RATE / samples,
    )
    half, last = np.arange(time.size) // samples, int(np.ceil((start - off) / (2 * off)))
    moving = half < last
    turn = (-1.0) ** half
    closed = turn * (off + (start - (2 * half + 1) * off) * np.cos(RATE * time - np.pi * half))
    np.testing.assert_allclose(ours[moving], closed[moving], rtol=0, atol=2e-10)
    stop = (-1.0) ** last * (start - 2 * last * off)
    assert abs(stop) <= off
    np.testing.assert_allclose(ours[~moving], stop, rtol=0, atol=2e-10)
    assert np.ptp(ours[last * samples + 1 :]) == 0.0  # sticking is exact, not a creep
    tops = ours[: last * samples : 2 * samples]
    np.testing.assert_allclose(np.diff(tops), -4 * off, rtol=0, atol=4e-10)


def test_friction_holds_against_less_than_its_level() -> None:
    inputs = np.repeat([0.0, 0.99, -0.99], [5, 100, 100]) * 0.3 / GAIN
    held = simulated(inputs, effects={"coulomb_friction": {"level": 0.3}})
    assert np.all(held == 0.0)
    slips = simulated(1.03 * inputs, effects={"coulomb_friction": {"level": 0.3}})
    assert slips.max() > 1e-5


@pytest.mark.parametrize("strength", [3.0, 0.2, -0.3])
def test_duffing_oscillator_swings_as_jacobis_functions(strength: float) -> None:
    start = 0.012
    cubic = strength * STIFFNESS / start**2
    if cubic > 0:  # x = X cn(Ωt)
        rate = np.sqrt((STIFFNESS + cubic * start**2) / MASS)
        modulus = cubic * start**2 / (2 * MASS * rate**2)
    else:  # x = X sn(Ωt + K)
        rate = np.sqrt((STIFFNESS + cubic * start**2 / 2) / MASS)
        modulus = -cubic * start**2 / (2 * MASS * rate**2)
    duration = 4 * ellipk(modulus) / rate  # Duffing's period
    period = duration / 64
    time = period * np.arange(6 * 64 + 1)
    ours = simulated(
        np.zeros(time.size),
        damping=0.0,
        effects={"cubic_stiffness": {"coefficient": cubic}},
        start=start,
        period=period,
    )
    closed = ellipj(rate * time, modulus)[1] if cubic > 0 else ellipj(rate * time + ellipk(modulus), modulus)[0]
    np.testing.assert_allclose(ours, start * closed, rtol=0, atol=2e-8)  # a count is 4.4e-6 m
    np.testing.assert_allclose(ours[::64], start, rtol=0, atol=2e-8)  # a count is 4.4e-6 m


@pytest.mark.parametrize("angle", [0.2, 1.0, 2.5])
def test_a_pendulum_swings_as_jacobis_functions(angle: float) -> None:
    """sin(a x/2) = sin(angle/2) sn(ω t + K): the spring force is k sin(a x)/a."""
    start = 0.012
    curvature, modulus = angle / start, np.sin(angle / 2) ** 2
    period = 4 * ellipk(modulus) / RATE / 64
    time = period * np.arange(6 * 64 + 1)
    ours = simulated(
        np.zeros(time.size),
        damping=0.0,
        effects={"sine_stiffness": {"curvature": curvature}},
        start=start,
        period=period,
    )
    closed = 2 / curvature * np.arcsin(np.sqrt(modulus) * ellipj(RATE * time + ellipk(modulus), modulus)[0])
    np.testing.assert_allclose(ours, closed, rtol=0, atol=2e-8)
    np.testing.assert_allclose(ours[::64], start, rtol=0, atol=2e-8)


def test_two_levels_of_friction_take_their_own_share_of_each_half_swing() -> None:
    """The way forward is centered on minus its level over k, the way back on plus its own: 2(F⁺ + F⁻)/k a cycle."""
    forward, backward, start, samples = 0.09, 0.16, 0.0125, 40
    period = np.pi / RATE / samples
    ours = simulated(
        np.zeros(10 * samples + 1),
        damping=0.0,
        effects={"asymmetric_friction": {"level_forward": forward, "level_backward": backward}},
        start=start,
        period=period,
    )
    turns = [start]
    for half in range(10):
        turns.append(-turns[-1] + 2 * (backward if half % 2 == 0 else -forward) / STIFFNESS)
    np.testing.assert_allclose(ours[::samples], turns, rtol=0, atol=1e-9)
    cycles = ours[:: 2 * samples]
    np.testing.assert_allclose(np.diff(cycles), -2 * (forward + backward) / STIFFNESS, rtol=0, atol=1e-9)


def test_quadratic_damping_loses_what_its_first_integral_says() -> None:
    """On each half swing E(x) exp(±2 c₂ x/m) is known in closed form, so that the next turn is a root."""
    drag, start, samples = 40.0, 0.0125, 64
    ours = simulated(
        np.zeros(400),
        damping=0.0,
        effects={"quadratic_damping": {"coefficient": drag}},
        start=start,
        period=np.pi / RATE / samples,
    )
    b = 2 * drag / MASS

    def potential(x: float) -> float:
        """With v² = −(2k/m) e^(bx) ∫ x e^(−bx) dx on the way back: zero at both turns."""
        return float(np.exp(-b * x) * (x / b + 1 / b**2))

    end = brentq(lambda x: potential(x) - potential(start), -start, -1e-5, xtol=1e-14)
    low = int(np.argmin(ours[: 2 * samples]))
    cubic = np.polynomial.Polynomial.fit(np.arange(-4, 5), ours[low - 4 : low + 5], 6)
    turns = cubic.deriv().roots()
    turn = cubic(min(turns[np.abs(turns.imag) < 1e-9].real, key=abs))
    assert turn == pytest.approx(end, abs=1e-9)
