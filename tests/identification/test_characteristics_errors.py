"""Records that yield no characteristics: each has its own error, naming run and remedy."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from closed_form import SAMPLE_TIME, Plant, make_run
from stepid.errors import IdentificationError, InputError, NoOvershootError, NoStepError, NotSettledError
from stepid.identification.characteristics import damped_frequency, damping_ratio

PLANT = Plant(base_mass=0.954, stiffness=216.2, damping=14.0)
NOISE = {"noise": 5e-6, "rng": np.random.default_rng(1)}


def overdamped(count: int = 900, *, noise: float = 5e-6) -> stepid.Experiment:
    run = make_run(PLANT, 0.0, count=count)
    since = np.clip(run.time - run.time[12], 0, None)
    position = 0.018 * (1 - 1.5 * np.exp(-5 * since) + 0.5 * np.exp(-15 * since))  # two real poles
    return run.model_copy(update={"position": position + noise * np.random.default_rng(2).standard_normal(count)})


def test_no_step_in_the_input() -> None:
    run = make_run(PLANT, 0.5, **NOISE)
    held = run.model_copy(update={"input": np.full(run.time.size, 0.5), "input_before": 0.5})
    with pytest.raises(NoStepError, match=r"'case 5'.*no step.*input_before"):
        stepid.characterize(held)
    drive = np.random.default_rng(0).standard_normal(run.time.size)
    with pytest.raises(NoStepError, match=r"'case 5'.*not a sequence of steps.*stepid.fit"):
        stepid.characterize(run.model_copy(update={"input": drive}))


@pytest.mark.parametrize("drive", [0.0, 0.5])
def test_constant_record(drive: float) -> None:
    run = make_run(PLANT, 0.5)
    for position in (np.zeros(run.time.size), 1e-6 * np.random.default_rng(0).standard_normal(run.time.size)):
        with pytest.raises(NoStepError, match=r"'case 5'.*(does not answer|does not move).*Check"):
            stepid.characterize(run.model_copy(update={"position": position, "input": run.input * drive}))


@pytest.mark.parametrize("fraction", [0.1, 0.4, 0.8, 0.97, 1.02, 1.3])
def test_cut_before_or_just_after_the_peak(fraction: float) -> None:
    count = 13 + round(fraction * PLANT.peak(0.5)[0] / SAMPLE_TIME)
    with pytest.raises(NotSettledError, match=r"'case 5'.*(Record|Hold)"):
        stepid.characterize(make_run(PLANT, 0.5, count=count, **NOISE))


@pytest.mark.parametrize("late", [0.3, 1.0])
def test_a_response_that_begins_long_after_its_step_is_none(late: float) -> None:
    """Its peak time would make a plant of its own: one that came on late had given a mass 400 times too small."""
    run = make_run(PLANT, 0.5, **NOISE)
    count = round(late * run.time.size / 3)
    shifted = run.model_copy(update={"position": np.concatenate([run.position[:count] * 0, run.position[:-count]])})
    with pytest.raises(NoStepError, match=r"'case 5'.*nothing answers the step for .* amplifier"):
        stepid.characterize(shifted)
    slightly = run.model_copy(update={"position": np.concatenate([run.position[:3] * 0, run.position[:-3]])})
    assert stepid.characterize(slightly).peak_time > stepid.characterize(run).peak_time


def test_step_at_the_very_end() -> None:
    with pytest.raises(NotSettledError, match=r"'case 5'.*cut before its peak"):
        stepid.characterize(make_run(PLANT, 0.5, steps=[(499, 0.5)], count=500))


@pytest.mark.parametrize("noise", [0.0, 5e-6])
def test_overdamped(noise: float) -> None:
    with pytest.raises(NoOvershootError, match=r"'case 5'.*no overshoot.*less damping"):
        stepid.characterize(overdamped(noise=noise))
    with pytest.raises(NotSettledError, match=r"'case 5'.*cut before its peak, or does not overshoot"):
        stepid.characterize(overdamped(60, noise=noise))


def test_not_at_rest_before_the_step() -> None:
    light = Plant(base_mass=0.954, stiffness=216.2, damping=1.5)
    run = make_run(light, 2.0, steps=[(10, 0.5), (160, -0.5)], count=1800)
    second = stepid.characterize_each(run)[1]
    assert isinstance(second, NotSettledError)
    assert "step 2 of 2" in str(second)
    assert "not at rest" in str(second)
    early = run.model_copy(update={"time": run.time[40:], "position": run.position[40:], "input": run.input[40:] - 0.5})
    with pytest.raises(NotSettledError, match=r"'case 5'.*not at rest.*Wait"):
        stepid.characterize(early)


def test_noise_that_hides_the_peak() -> None:
    run = make_run(PLANT, 0.5, noise=4e-3, rng=np.random.default_rng(3))
    with pytest.raises((NoOvershootError, NotSettledError), match="'case 5'"):
        stepid.characterize(run)


def test_formulas_refuse_what_has_no_answer() -> None:
    for overshoot in (0.0, -0.1, 1.0):
        with pytest.raises(NoOvershootError, match=r"Eq\. 8"):
            damping_ratio(overshoot)
    with pytest.raises(InputError, match="peak time"):
        damped_frequency(0.0)


def test_numbers_that_cannot_be_computed_with_are_no_crash() -> None:
    """A pulse that comes back to exactly where it was, held by nothing: its steady state is zero."""
    position = np.zeros(120)
    position[30:60] = 0.01
    position[60:90] = -0.01
    time = 0.01 * np.arange(120)
    run = stepid.Experiment(
        name="odd",
        time=time,
        position=position,
        input=np.where(time > 0.1, 1.0, 0.0),
        added_mass=0,
        spring="s",
        damper="d",
    )
    with pytest.raises(IdentificationError, match="odd"):
        stepid.characterize(run)
    with pytest.raises(IdentificationError, match="odd"):
        stepid.characterize(_scaled(run, 1e-290))


def _scaled(run: stepid.Experiment, factor: float) -> stepid.Experiment:
    fields = {name: getattr(run, name) for name in type(run).model_fields}
    return stepid.Experiment(**fields | {"position": factor * run.position})


@pytest.mark.parametrize("seed", range(4))
def test_a_settled_response_without_an_overshoot_is_told_by_its_level(seed: int) -> None:
    """Its highest reading is noise, anywhere on the plateau: the level had been averaged over the rise."""
    time = SAMPLE_TIME * np.arange(1130)
    since = np.clip(time - time[20], 0, None)
    slow, fast = 1.85, 80.9  # 1/s
    swing = 0.01806 * (1 - (fast * np.exp(-slow * since) - slow * np.exp(-fast * since)) / (fast - slow))
    noise = 2e-5 * np.random.default_rng(seed).standard_normal(time.size)
    run = make_run(Plant(0.95, 216.0, 14.0), 0.5, steps=((20, 0.5),), count=1130)
    with pytest.raises(NoOvershootError, match=r"no overshoot to be seen \(0\.\d\d % of 18\.[01] mm"):
        stepid.characterize(run.model_copy(update={"position": swing + noise}))


def test_a_response_that_its_sensor_clips_below_its_level_has_no_overshoot() -> None:
    """Its highest reading is its level, to the last digit: two in three readings are the same, and tell no noise."""
    run = make_run(Plant(1.0, 300.0, 4.0), 0.5, steps=((20, 0.5),), count=800)
    noise = 2e-5 * np.random.default_rng(0).standard_normal(run.time.size)
    clipped = np.minimum(run.position + noise, 0.9 * run.position[-1])
    with pytest.raises(NoOvershootError, match=r"no overshoot to be seen \(0.00 %"):
        stepid.characterize(run.model_copy(update={"position": clipped}))
