"""Noise that is colored: how large it is for a curve through a peak, and whether intervals hold it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

import stepid
from hidden import Run, fast
from stepid.identification.steady_state import colored_noise

STEP, PEAK = 1e-3, 0.2  # s


def ar1(size: int, correlation: float, rng: np.random.Generator) -> np.ndarray:
    """Noise of 1 with a correlation time in samples."""
    kept = np.exp(-1 / correlation)
    return np.asarray(lfilter([np.sqrt(1 - kept**2)], [1, -kept], rng.standard_normal(size + 500))[500:])


@pytest.mark.parametrize("correlation", [1.0, 3.0, 10.0])
def test_it_is_white_noise_of_the_same_power_where_a_peak_is_seen(correlation: float) -> None:
    residual = ar1(4000, correlation, np.random.default_rng(2))
    kept, turn = np.exp(-1 / correlation), 2 * np.pi * STEP * np.linspace(1.5, 8.0, 50) / (2 * PEAK)
    power = (1 - kept**2) / (1 - 2 * kept * np.cos(turn) + kept**2)
    assert colored_noise(residual, STEP, PEAK, 0.5) == pytest.approx(np.sqrt(power.mean()), rel=0.15)


def test_what_chance_makes_of_white_noise_is_none() -> None:
    rng = np.random.default_rng(3)
    found = [colored_noise(rng.standard_normal(1000), STEP, PEAK, 1.0) for _ in range(200)]
    assert np.mean(np.array(found) == 1.0) > 0.97


def test_too_short_a_tail_tells_nothing() -> None:
    assert colored_noise(1e3 * np.sin(np.arange(100.0)), STEP, PEAK, 1.0) == 1.0


@pytest.mark.slow
def test_intervals_hold_colored_noise() -> None:
    """Sampled every 0.9 ms, correlated over 3 ms; taken for white noise, 13 of 25 held the stiffness."""
    held = []
    for seed in range(25):
        rng = np.random.default_rng([4, seed])
        mass = float(rng.uniform(0.8, 1.2))
        stiffness, damping = 225 * mass, 9 * mass
        volts, added = np.repeat([0.0, 0.5], [200, 3000]), 0.5 * np.arange(4)
        runs = [Run(mass + m, stiffness, damping, 0.036 * stiffness, 0.9e-3, volts, {}) for m in added]
        experiments = tuple(
            stepid.Experiment(
                name=f"{m:g} kg", time=0.9e-3 * np.arange(x.size), position=x + 20e-6 * ar1(x.size, 3.3, rng),
                input=volts, added_mass=float(m), spring="medium", damper="half",
            )
            for m, x in zip(added, fast(runs), strict=True)
        )  # fmt: skip
        found = stepid.identify(stepid.Campaign(name="colored", experiments=experiments, weight_uncertainty=1e-7))
        held.append(abs(found.stiffness["medium"] - stiffness) < 1.96 * found.uncertainty.stiffness["medium"])
    assert sum(held) >= 21
