"""Readings at the end of a sensor's range: found in releases, too, and nothing that only looks alike."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.fitting.clipped import clipped

STEP, SAMPLES, RATE, DECAY = 0.01, 500, 9.0, 0.3
TIME = STEP * np.arange(SAMPLES)
SWING = 0.02 * np.exp(-DECAY * TIME) * np.cos(RATE * TIME)


def record(
    position: Array, volts: Array | None = None, noise: float = 2e-6, *, end: float = 1.0, name: str = "a"
) -> stepid.Experiment:
    """A record whose sensor reads up to `end` [m] either way; what lies beyond has no noise either."""
    position = np.clip(position + noise * np.random.default_rng(2).standard_normal(SAMPLES), -end, end)
    volts = np.zeros(SAMPLES) if volts is None else volts
    named = {"name": name, "spring": "s", "damper": "d"}
    return stepid.Experiment(
        **named, time=TIME, position=position, input=volts, added_mass=0.0, starts="auto" if volts.any() else "motion"
    )


@pytest.mark.parametrize("noise", [0.0, 2e-6, 5e-5])
def test_what_is_cut_off_in_several_swings_is_found(noise: float) -> None:
    found = clipped(record(SWING, noise=noise, end=0.012))
    assert found[np.abs(SWING) > 0.0123].mean() > 0.8
    assert not found[np.abs(SWING) < 0.0115].any()


@pytest.mark.parametrize(
    "position",
    [
        SWING,
        np.round(SWING / 1e-3) * 1e-3,  # a coarse encoder
        np.repeat(SWING[::4], 4),  # a sensor that is slower than its clock
        0.02 * np.cos(RATE * TIME),  # peaks that are alike
        np.round(0.02 * np.cos(RATE * TIME) / 2e-3) * 2e-3,
        np.minimum(SWING, 0.015),  # one swing that is seen from both sides alone is chance
    ],
)
def test_what_only_looks_alike_is_none(position: Array) -> None:
    assert not clipped(record(position, noise=0.0)).any()
    assert not clipped(record(position)).any()


def test_a_cart_that_rests_after_each_step_is_none() -> None:
    volts = 1.0 * (TIME % 1.0 >= 0.5)
    since = TIME % 0.5
    level = np.where(volts > 0, 1 - np.exp(-since / 0.004), np.exp(-since / 0.004))  # as fast as its samples
    assert not clipped(record(0.02 * level, volts)).any()


def test_a_clipped_release_is_told_and_fitted_without_it() -> None:
    run = record(SWING, end=0.012)
    whole = stepid.fit(stepid.Campaign(name="c", experiments=(run, record(0.5 * SWING, name="b"))))
    (note,) = (note for note in whole.notes if "clipped" in note)
    assert "'a' stays at 12.0 mm, its farthest reading, in several swings" in note
    assert whole.run_rms["a"] < 1.1 * whole.noise  # without what is left out
    stiffness = whole.parameters["stiffness[s]"]
    assert stiffness.value == pytest.approx(RATE**2 + DECAY**2, rel=2e-3)
    assert stepid.diagnose(stepid.Campaign(name="c", experiments=(run, record(0.5 * SWING, name="b")))).effects == ()
