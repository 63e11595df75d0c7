"""Noise of a record: by what is not predicted, and by the residual of a fit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import dlsim

from stepid.core.noise import floor_from_residual, predicted_noise


def driven(samples_a_period: float, damping: float, *, noise: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Readings of a plant whose held input is another one at each sample, and that input."""
    rng = np.random.default_rng(seed)
    volts = rng.standard_normal(900)
    turn = 2 * np.pi / samples_a_period
    pole = np.exp(turn * (-damping + 1j * np.sqrt(1 - damping**2)))
    _, position = dlsim(([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], 1.0), volts)
    position = position[:, 0] / np.std(position)
    return position + noise * rng.standard_normal(position.size), volts


@pytest.mark.parametrize("samples", [8, 9, 15, 50])
@pytest.mark.parametrize("damping", [0.02, 0.2])
@pytest.mark.parametrize("noise", [1e-4, 1e-2])
def test_what_cannot_be_predicted_is_the_noise(samples: int, damping: float, noise: float) -> None:
    found = [predicted_noise(*driven(samples, damping, noise=noise, seed=seed)) for seed in range(4)]
    assert found == pytest.approx([noise] * 4, rel=0.15)


@pytest.mark.parametrize(("samples", "bent"), [(9, 0.003), (12, 0.01), (15, 0.01), (30, 0.01)])
def test_a_force_that_is_bent_in_position_is_no_noise(samples: int, bent: float) -> None:
    """Readings of x_k+1 = a·x_k + b·x_k−1 − cubic and square force + input; noise of 0.02 % of them."""
    rng = np.random.default_rng(7)
    turn, volts = 2 * np.pi / samples, 0.3 * rng.standard_normal(1500)
    x = np.zeros(1500)
    for k in range(1, x.size - 1):
        force = bent * (x[k] ** 3 + 0.5 * x[k] ** 2)
        x[k + 1] = 2 * 0.95 * np.cos(turn) * x[k] - 0.95**2 * x[k - 1] - force + volts[k]
    noise = 2e-4 * float(np.std(x))
    found = predicted_noise(x + noise * rng.standard_normal(x.size), volts)
    assert found == pytest.approx(noise, rel=0.2)


def test_a_free_swing_of_eight_samples_a_period_is_predicted() -> None:
    turn = 2 * np.pi / 8 * np.arange(600)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(600)
    found = predicted_noise(np.exp(-0.01 * turn) * np.cos(turn) + noise, np.zeros(600))
    assert found == pytest.approx(1e-3, rel=0.15)


def test_windows_at_rest_do_not_count() -> None:
    position, volts = driven(9, 0.05, noise=1e-3, seed=5)
    still = np.concatenate([np.zeros(2000), position])
    given = np.concatenate([np.zeros(2000), volts])
    assert predicted_noise(still, given, resolution=1e-5) == pytest.approx(1e-3, rel=0.2)


def test_too_short_or_still_a_record_says_nothing() -> None:
    position, volts = driven(9, 0.05, noise=1e-3, seed=6)
    assert predicted_noise(position[:100], volts[:100]) is None
    assert predicted_noise(np.zeros(900), volts) is None
    assert predicted_noise(position[:3], volts[:3]) is None


@pytest.mark.parametrize("size", [1e-6, 1.0])
def test_the_floor_of_a_residual_is_its_spread(size: float) -> None:
    residual = size * np.random.default_rng(2).standard_normal(4000)
    assert floor_from_residual(residual) == pytest.approx(size, rel=0.03)
    residual[::500] += 100 * size
    assert floor_from_residual(residual) == pytest.approx(size, rel=0.03)


def test_parameters_raise_the_floor_of_a_residual() -> None:
    residual = np.random.default_rng(3).standard_normal(100)
    assert floor_from_residual(residual, parameters=75) == pytest.approx(2 * floor_from_residual(residual))
    assert floor_from_residual(np.zeros(100)) == 0.0
