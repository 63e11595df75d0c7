"""Levels of an input that was measured: known by steps that are clear of white noise."""

from __future__ import annotations

import numpy as np
import pytest

from stepid.core.base import Array
from stepid.core.input_levels import level_bounds

N = 600
STEPS: Array = np.repeat([0.0, 1.0, -0.5], N // 3)
NOISE: Array = np.random.default_rng(1).standard_normal(N)


@pytest.mark.parametrize("noise", [0.001, 0.02, 0.05])
@pytest.mark.parametrize("offset", [0.0, 0.03])
def test_noise_on_levels_is_told_from_steps(noise: float, offset: float) -> None:
    found = level_bounds(STEPS + offset + noise * NOISE)
    assert found is not None
    assert found.tolist() == [0, 200, 400, 600]


def test_a_converter_that_flickers_by_a_count_is_noise() -> None:
    found = level_bounds(np.round((STEPS + 0.002 * NOISE) / 0.005) * 0.005)
    assert found is not None
    assert found.tolist() == [0, 200, 400, 600]


@pytest.mark.parametrize(
    "values",
    [
        STEPS,  # exact
        np.sin(0.1 * np.arange(N)),
        np.random.default_rng(2).choice([0.0, 1.0], N),  # changes all the time
        STEPS + 0.03 * np.exp(-np.arange(N) % 200 / 50),  # sags after each step
        STEPS + 0.02 * np.cumsum(NOISE) / 10,  # drifts
        NOISE,
    ],
)
def test_what_the_drive_does_is_no_noise(values: Array) -> None:
    found = level_bounds(values)
    assert found is None or found.tolist() == [0, N]
