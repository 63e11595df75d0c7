"""Levels of an input that was measured: known by steps that are clear of white noise."""

from __future__ import annotations

import numpy as np
import pytest

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.input_levels import level_bounds, levelled

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


def test_a_short_level_beside_a_long_one_does_not_tell_the_color_of_its_noise() -> None:
    """Of eight samples of white noise one in twenty looks like a drift."""
    found = 0
    for seed in range(200):
        values = np.repeat([0.0, 1.0], [8, 500]) + 0.01 * np.random.default_rng(seed).standard_normal(508)
        found += level_bounds(values) is not None
    assert found == 200


def test_a_run_at_its_levels_rests_under_the_first_of_them_where_that_is_no_step() -> None:
    hum = 0.01 * np.sin(2.0 * np.arange(N))
    fields = {"name": "r", "time": 0.01 * np.arange(N), "position": np.zeros(N), "spring": "s", "damper": "d"}
    run = Experiment(input=STEPS + 0.02 + hum, added_mass=0.0, **fields)
    found = levelled(run)
    assert found.input[[0, 250, 599]] == pytest.approx([0.02, 1.02, -0.48], abs=1e-3)
    assert found.input_before == found.input[0]
    late = levelled(run.model_copy(update={"input": np.roll(STEPS, -N // 3) + hum}))
    assert late.input_before == 0.0
    exact = run.model_copy(update={"input": 0.6 * STEPS})
    assert levelled(exact) is exact
    ramps = run.model_copy(update={"input": np.abs(0.01 * np.arange(N) % 2 - 1)})
    assert levelled(ramps) is ramps
