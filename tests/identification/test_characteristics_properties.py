"""Properties of characteristics: sign, time, zero of position, JSON."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stepid
from closed_form import Plant, make_run

PLANTS = st.builds(
    lambda mass, ratio, frequency: Plant(
        base_mass=mass, stiffness=mass * frequency**2, damping=2 * ratio * mass * frequency, gain=mass * frequency**2
    ),
    mass=st.floats(0.3, 3.0),
    ratio=st.floats(0.15, 0.6),
    frequency=st.floats(6.0, 20.0),
)
PEAKS = st.sampled_from([stepid.InterpolatedPeak(), stepid.SampledPeak()])
VALUES = ("peak_time", "overshoot", "damping_ratio", "damped_frequency", "natural_frequency", "static_gain")


def record(plant: Plant, seed: int) -> stepid.Experiment:
    rng = np.random.default_rng(seed)
    return make_run(plant, 0.0, steps=[(15, 0.018)], count=900, noise=float(rng.choice([0.0, 2e-5])), rng=rng)


def agree(one: stepid.Characteristics, two: stepid.Characteristics, rel: float = 1e-7) -> None:
    for name in VALUES:
        assert getattr(two, name) == pytest.approx(getattr(one, name), rel=rel)
        assert getattr(two.uncertainty, name) == pytest.approx(getattr(one.uncertainty, name), rel=1e-4, abs=1e-12)


@settings(deadline=None, max_examples=25)
@given(PLANTS, PEAKS, st.integers(0, 99))
def test_sign_flip(plant: Plant, peak: stepid.InterpolatedPeak, seed: int) -> None:
    run = record(plant, seed)
    flipped = run.model_copy(update={"position": -run.position, "input": -run.input})
    one, two = stepid.characterize(run, peak=peak), stepid.characterize(flipped, peak=peak)
    agree(one, two)
    assert two.steady_state == pytest.approx(-one.steady_state, rel=1e-9)


@settings(deadline=None, max_examples=25)
@given(PLANTS, PEAKS, st.integers(0, 99), st.floats(-100, 100), st.floats(-0.03, 0.03))
def test_time_shift_and_added_constant(
    plant: Plant, peak: stepid.InterpolatedPeak, seed: int, later: float, shift: float
) -> None:
    run = record(plant, seed)
    moved = run.model_copy(update={"time": run.time + later, "position": run.position + shift})
    agree(stepid.characterize(run, peak=peak), stepid.characterize(moved, peak=peak))


@settings(deadline=None, max_examples=15)
@given(PLANTS, PEAKS, st.integers(0, 99))
def test_json_round_trip(plant: Plant, peak: stepid.InterpolatedPeak, seed: int) -> None:
    one = stepid.characterize(record(plant, seed), peak=peak)
    assert stepid.Characteristics.model_validate_json(one.model_dump_json()) == one


@settings(deadline=None, max_examples=25)
@given(PLANTS, st.floats(0.1, 10.0))
def test_scale_of_position_and_input(plant: Plant, scale: float) -> None:
    run = record(plant, 0)
    larger = run.model_copy(update={"position": scale * run.position, "input": scale * run.input})
    agree(stepid.characterize(run), stepid.characterize(larger))
