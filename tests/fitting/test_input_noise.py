"""Inputs that were measured: what is read beside their levels is left out where the cart does not follow it."""

from __future__ import annotations

import control
import numpy as np
import pytest
from scipy.signal import lfilter

import stepid
from stepid.errors import NoStepError
from stepid.fitting.fit import prepare
from stepid.fitting.input_noise import pooled_levels
from stepid.identification.steps import find_steps

MASS, STIFFNESS, DAMPING, GAIN = 0.9, 220.0, 3.0, 7.8
STEP_TIME, SAMPLES = 0.01, 500


def measured(noise: float, *, followed: bool = False, adc: float = 0.0, offset: float = 0.0) -> stepid.Campaign:
    """Steps of 1 V whose input is read with noise, which the cart may follow."""
    rng, runs = np.random.default_rng(7), []
    time = STEP_TIME * np.arange(SAMPLES)
    held = np.where(np.arange(SAMPLES) >= 30, 1.0, 0.0)
    for added in (0.0, 0.5, 1.0):
        read = held + noise * rng.standard_normal(SAMPLES)
        plant = control.ss(control.tf([GAIN], [MASS + added, DAMPING, STIFFNESS]))
        sampled = control.sample_system(plant, STEP_TIME, method="zoh")
        position = control.forced_response(sampled, time, read if followed else held).outputs
        position = position + 15e-6 * rng.standard_normal(SAMPLES)
        shown = np.round((read + offset) / adc) * adc if adc else read
        runs.append(
            stepid.Experiment(
                name=f"{added} kg", time=time, position=position, input=shown, added_mass=added, spring="s", damper="d"
            )
        )
    return stepid.Campaign(name="measured", experiments=tuple(runs))


@pytest.mark.parametrize("noise", [0.005, 0.02, 0.05])
def test_the_levels_are_taken_and_that_is_said(noise: float) -> None:
    context = prepare(measured(noise))
    (note,) = (note for note in context.notes if "is read with noise of up to" in note)
    assert float(note.split("up to ")[1].split(" V.")[0]) == pytest.approx(noise, rel=0.1)
    assert context.linear.rms < 1.05 * context.floor
    assert np.unique(context.records.volts.round(3)).size <= 4


def test_an_input_that_the_cart_follows_is_taken_as_it_is_read() -> None:
    context = prepare(measured(0.05, followed=True))
    assert context.notes == ()
    assert context.linear.rms < 1.05 * context.floor
    assert np.unique(context.records.volts).size > SAMPLES


COLORED = {
    "hum": lambda time, rng: 0.02 * np.sin(2 * np.pi * 31 * time),
    "slow": lambda time, rng: lfilter([0.002], [1, -0.9], rng.standard_normal(time.size)),
    "drift": lambda time, rng: np.where(time < 0.3, 0.0, -0.002 * time),
}


@pytest.mark.parametrize("followed", [False, True])
@pytest.mark.parametrize("kind", COLORED)
def test_noise_of_any_color_is_left_out_where_the_cart_does_not_follow_it(kind: str, followed: bool) -> None:
    """A hum on the reading of an input had been a saturation with a dead zone; what the drive does is kept."""
    rng = np.random.default_rng(5)
    runs = []
    for run in measured(0.0).experiments:
        beside = COLORED[kind](run.time, rng)
        plant = control.ss(control.tf([GAIN], [MASS + run.added_mass, DAMPING, STIFFNESS]))
        sampled = control.sample_system(plant, STEP_TIME, method="zoh")
        moved = control.forced_response(sampled, run.time, beside).outputs
        changed = {"input": run.input + beside, "position": run.position + moved * followed}
        runs.append(run.model_copy(update=changed))
    context = prepare(stepid.Campaign(name=kind, experiments=tuple(runs)))
    assert context.linear.rms < 1.05 * context.floor
    assert (len(context.notes) == 1) is not followed
    assert (np.unique(context.records.volts).size > 10) is followed


@pytest.mark.parametrize("seed", range(4))
def test_another_misfit_does_not_make_noise_an_input(seed: int) -> None:
    """The input is read a sample early: what that leaves is far more than the noise could move, and alike by chance."""
    rng, runs = np.random.default_rng(seed), []
    for run in measured(0.0).experiments:
        early = np.append(run.input[1:], run.input[-1]) + 1e-3 * rng.standard_normal(SAMPLES)
        runs.append(run.model_copy(update={"input": early}))
    context = prepare(stepid.Campaign(name="early", experiments=tuple(runs)))
    assert any("is read with noise of up to" in note for note in context.notes)
    assert context.linear.rms > 5 * context.floor


def test_a_step_at_the_first_sample_is_one_from_rest() -> None:
    """Its noise had been taken for an input that changes all the time, and the start for free: no gain was left."""
    runs = [
        run.model_copy(update={name: getattr(run, name)[30:] for name in ("time", "position", "input")})
        for run in measured(0.002).experiments
    ]
    found = stepid.fit(stepid.Campaign(name="triggered", experiments=tuple(runs)))
    gain = found.parameters["force_gain"]
    assert gain.uncertainty is not None
    assert gain.value == pytest.approx(GAIN, rel=2e-3)
    assert not any("in motion" in note for note in found.notes)


def test_exact_inputs_have_no_noise() -> None:
    assert pooled_levels(measured(0.0)) is None


@pytest.mark.parametrize("how", [{"noise": 0.05}, {"noise": 0.004, "adc": 0.005, "offset": 0.03}])
def test_the_noise_of_an_input_is_no_dead_zone_and_no_saturation(how: dict[str, float]) -> None:
    """These two clip it, and had been named with 95 % whatever its size."""
    campaign = measured(**how)  # type: ignore[arg-type]
    found = stepid.diagnose(campaign)
    assert (found.verdict, found.effects) == ("adequate", ())
    gain = found.parameters["force_gain"]
    assert gain.uncertainty is not None
    assert abs(gain.value - GAIN) < 3 * gain.uncertainty


def test_the_peak_method_finds_the_step_in_the_noise() -> None:
    found = stepid.identify(measured(0.05))
    assert len(found.masses) == 3
    assert abs(found.base_mass["cart"] - MASS) < 3 * found.uncertainty.base_mass["cart"]


def test_a_measured_step_may_stand_at_the_first_sample_and_noise_alone_is_no_step() -> None:
    rng = np.random.default_rng(3)
    (run, *_) = measured(0.05).experiments
    begun = run.model_copy(update={"input": run.input[30:], "time": run.time[30:], "position": run.position[30:]})
    (step,) = find_steps(begun)
    assert (step.start, step.size) == (0, pytest.approx(1.0, abs=0.02))
    still = run.model_copy(update={"input": 0.05 * rng.standard_normal(SAMPLES)})
    with pytest.raises(NoStepError, match=r"the input changes at 4\d\d of 500 samples"):
        find_steps(still)


def pulsed(read: np.ndarray, driven: np.ndarray) -> stepid.Campaign:
    """Three runs that are driven by one input, with another on record."""
    rng, runs, time = np.random.default_rng(8), [], STEP_TIME * np.arange(SAMPLES)
    for added in (0.0, 0.5, 1.0):
        plant = control.ss(control.tf([GAIN], [MASS + added, DAMPING, STIFFNESS]))
        sampled = control.sample_system(plant, STEP_TIME, method="zoh")
        position = control.forced_response(sampled, time, driven).outputs + 15e-6 * rng.standard_normal(SAMPLES)
        named = {"name": f"{added} kg", "spring": "s", "damper": "d"}
        runs.append(stepid.Experiment(time=time, position=position, input=read, added_mass=added, **named))
    return stepid.Campaign(name="pulsed", experiments=runs)


STEPPED = np.where(np.arange(SAMPLES) >= 30, 1.0, 0.0)


@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize(("at", "to"), [([200], 0.0), ([200, 201, 320], 12.0), ([100, 300], -1.0)])
def test_lone_readings_that_the_cart_does_not_follow_are_left_out(at: list[int], to: float, noise: float) -> None:
    """One dropped reading in each run had left 158 µm of 5."""
    read = STEPPED + noise * np.random.default_rng(3).standard_normal(SAMPLES)
    read[at] = to
    context = prepare(pulsed(read, STEPPED))
    assert context.linear.rms < 1.05 * context.floor
    faults = [fault for fault in context.faults if fault.kind == "misread input"]
    assert [fault.run for fault in faults] == ["0.0 kg", "0.5 kg", "1.0 kg"]
    assert all(fault.size == pytest.approx(abs(to - 1.0), abs=4 * noise) and fault.unit == "V" for fault in faults)
    assert f"{len(at)} reading{'s' * (len(at) > 1)} of its input (sample" in faults[0].words
    assert all(fault.words in context.notes for fault in faults)


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_a_short_pulse_that_the_cart_follows_is_none(level: float) -> None:
    """A blow from rest, or on a level."""
    driven = level * STEPPED
    driven[200:202] = 3.0
    context = prepare(pulsed(driven, driven))
    assert context.linear.rms < 1.05 * context.floor
    assert context.faults == ()
    assert context.notes == ()
