"""Sensors that are slower than their clock: readings that are repeated are found and left out, and no others."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.core.repeated_readings import at_sensor_rate, at_sensor_rates, sensor_notes

CLOCK, COUNT, STEP = 0.01, 500, 20  # s, samples, the first of them at which the input is on
STIFFNESS, DAMPING, GAIN = 250.0, 5.0, 12.0


def moved(mass: float, time: Array) -> Array:
    """Position after a step at `STEP`, m, at any times [s]: the closed form of the second-order plant."""
    rate, ratio = np.sqrt(STIFFNESS / mass), DAMPING / (2 * np.sqrt(STIFFNESS * mass))
    since = np.clip(time - STEP * CLOCK, 0.0, None)
    damped = rate * np.sqrt(1 - ratio**2)
    swing = np.exp(-ratio * rate * since) * (np.cos(damped * since) + ratio * rate / damped * np.sin(damped * since))
    return np.asarray(1.5 * GAIN / STIFFNESS * (1 - swing))


def read_slowly(period: float, *, mass: float = 1.3, phase: float = 0.3, noise: float = 20e-6, step: float = 0.0):
    """A record whose sensor has a new reading every `period` [s], first at `phase` of it."""
    taken = period * (np.arange(-2, int(COUNT * CLOCK / period) + 2) + phase)
    reading = moved(mass, taken) + noise * np.random.default_rng(round(1e4 * mass)).standard_normal(taken.size)
    if step:
        reading = step * np.round(reading / step)
    time = CLOCK * np.arange(COUNT)
    return stepid.Experiment(
        name=f"{mass:g} kg",
        time=time,
        position=reading[np.searchsorted(taken, time, side="right") - 1],
        input=np.where(np.arange(COUNT) >= STEP, 1.5, 0.0),
        added_mass=round(mass - 1.3, 9),
        spring="s",
        damper="d",
    )


@pytest.mark.parametrize("period", [0.0137, 0.025, 0.0333, 0.0417])
@pytest.mark.parametrize("step", [0.0, 100e-6])
def test_readings_are_found_with_the_times_they_were_taken_at(period: float, step: float) -> None:
    run = read_slowly(period, step=step)
    found = at_sensor_rate(run)
    assert found is not None
    assert found.out
    assert found.period == pytest.approx(period, rel=5e-3)
    new = ~found.stale
    assert np.count_nonzero(found.stale) == 1  # where the input changes
    assert found.run.input[found.stale] == 1.5
    assert found.run.time[found.stale] == pytest.approx(STEP * CLOCK)
    time = found.run.time[new]
    assert np.ptp(np.diff(time)) < 1e-9
    late = period * ((time / period - 0.3 + 0.5) % 1 - 0.5)  # one for all: nothing tells more
    assert np.ptp(late) < 0.05 * CLOCK
    assert abs(late.mean()) < found.early / 2 + 0.05 * CLOCK
    left = found.run.position[new] - moved(1.3, time - late)
    assert np.std(left) < 1.2 * np.hypot(20e-6, step / np.sqrt(12))


def test_of_a_period_of_whole_samples_the_first_that_shows_a_reading_is_taken() -> None:
    found = at_sensor_rate(read_slowly(0.04, phase=0.25))  # at samples 1, 5, 9, …; the input changes at 20
    assert found is not None
    assert found.early == pytest.approx(CLOCK)
    np.testing.assert_allclose(found.run.time[~found.stale] / CLOCK, np.arange(1, COUNT, 4))
    assert found.run.input.tolist() == [0.0] * 5 + [1.5] * (found.run.input.size - 5)


def test_a_sensor_without_an_even_clock_of_its_own_is_taken_as_it_is_shown() -> None:
    run = read_slowly(0.01)
    lasts = np.random.default_rng(2).integers(1, 6, size=COUNT)
    shown = np.repeat(np.cumsum(lasts) - lasts, lasts)[:COUNT]
    found = at_sensor_rate(run.model_copy(update={"position": run.position[shown]}))
    assert found is not None
    assert found.early == CLOCK
    assert np.isin(np.unique(shown)[1:], np.round(found.run.time / CLOCK, 9)).all()
    assert np.ptp(np.diff(found.run.time)) > CLOCK


def test_a_sensor_as_fast_as_its_clock_is_left_alone() -> None:
    assert at_sensor_rate(read_slowly(CLOCK)) is None


def test_an_encoder_that_does_not_see_a_slow_cart_move_repeats_nothing() -> None:
    coarse = read_slowly(CLOCK, step=1e-3, noise=0.0)
    assert np.mean(np.diff(coarse.position) == 0) > 0.5
    assert at_sensor_rate(coarse) is None


def test_a_few_lost_samples_that_are_filled_with_the_reading_before_are_no_slow_sensor() -> None:
    run = read_slowly(CLOCK)
    y = run.position.copy()
    for lost in range(30, 300, 10):
        y[lost] = y[lost - 1]
    assert at_sensor_rate(run.model_copy(update={"position": y})) is None


def test_no_sample_is_left_out_where_the_input_changes_all_the_time() -> None:
    run = read_slowly(0.025)
    driven = run.model_copy(update={"input": np.sin(0.1 * np.arange(COUNT))})
    found = at_sensor_rate(driven)
    assert found is not None
    assert not found.out
    assert found.run is driven
    assert not found.stale.any()
    (note,) = sensor_notes({"run": found})
    assert note.endswith("Record at that rate.")


def test_an_input_that_is_measured_changes_at_its_steps_only() -> None:
    run = read_slowly(0.025)
    noisy = run.input + 1e-3 * np.random.default_rng(0).standard_normal(COUNT)
    found = at_sensor_rate(run.model_copy(update={"input": noisy}))
    assert found is not None
    assert found.out
    assert found.run.time[found.stale] == pytest.approx([STEP * CLOCK])
    assert np.isin(found.run.input, noisy).all()


def test_runs_alike_are_told_of_together() -> None:
    runs = [read_slowly(0.025, mass=mass) for mass in (1.3, 1.8)] + [read_slowly(CLOCK, mass=2.3)]
    taken, slow = at_sensor_rates(runs)
    assert [a is b for a, b in zip(taken, runs, strict=True)] == [False, False, True]
    assert sensor_notes(slow) == [
        "Runs '1.3 kg' and '1.8 kg': the sensor has a new reading every 0.025 s only, and repeats the last one in "
        "between. The repeats are left out."
    ]


@pytest.mark.parametrize("period", [0.0137, 0.0333])
def test_a_plant_behind_a_slow_sensor_is_fitted_to_the_noise_and_identified(period: float) -> None:
    campaign = stepid.Campaign(
        name="slow", experiments=tuple(read_slowly(period, mass=m, phase=m % 1, step=50e-6) for m in (1.3, 1.8, 2.3))
    )
    fit = stepid.fit(campaign)
    assert fit.rms < 1.15 * np.hypot(20e-6, 50e-6 / np.sqrt(12))
    assert fit.parameters["base_mass"].value == pytest.approx(1.3, rel=5e-3)
    assert fit.parameters["damping[d]"].value == pytest.approx(DAMPING, rel=1e-2)
    assert any("new reading every" in note for note in fit.notes)
    found = stepid.identify(campaign)
    assert found.masses["1.3 kg"] == pytest.approx(1.3, rel=2e-2)
    assert found.stiffness["s"] == pytest.approx(STIFFNESS, rel=2e-2)
    assert any(note.endswith("A smooth curve through the readings is read.") for note in found.notes)


def test_where_readings_may_be_later_identify_says_what_its_uncertainties_leave_out() -> None:
    campaign = stepid.Campaign(name="slow", experiments=tuple(read_slowly(0.04, mass=m) for m in (1.3, 1.8)))
    (note,) = [note for note in stepid.identify(campaign).notes if "sensor" in note]
    assert note.endswith("When it took them is known to 0.01 s only: the uncertainties do not contain that.")
