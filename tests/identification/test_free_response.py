"""Hand releases: damped frequency and damping ratio from the extrema."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import stepid
from closed_form import SAMPLE_TIME
from stepid.errors import NoOvershootError, NotSettledError
from stepid.identification.free_response import constant_loss, find_extrema, is_free_response
from stepid.identification.peak import sampled_peak_spread


def swing(*, ratio: float = 0.03, frequency: float = 20.0, hold: int = 80, count: int = 1200, noise: float = 0.0):
    """Displaced by 20 mm, held for some samples, let go."""
    time = SAMPLE_TIME * np.arange(count)
    since = np.clip(time - hold * SAMPLE_TIME, 0, None)
    decay = frequency * ratio / np.sqrt(1 - ratio**2)
    position = (
        0.02 * np.exp(-decay * since) * (np.cos(frequency * since) + decay / frequency * np.sin(frequency * since))
    )
    position = position + noise * np.random.default_rng(4).standard_normal(count)
    return stepid.Experiment(
        name="release",
        time=time,
        position=0.004 + position,
        input=np.zeros(count),
        added_mass=0.0,
        spring="high",
        damper="none",
    )


@pytest.mark.parametrize("ratio", [0.005, 0.03, 0.15])
@pytest.mark.parametrize("peak", [stepid.InterpolatedPeak(), stepid.SampledPeak()])
def test_release_of_a_linear_plant(ratio: float, peak: stepid.InterpolatedPeak | stepid.SampledPeak) -> None:
    count = min(int(3.5 / (20 * ratio) / SAMPLE_TIME) + 200, 6000)
    found = stepid.characterize(swing(ratio=ratio, count=count), peak=peak)
    sampled = isinstance(peak, stepid.SampledPeak)
    assert found.damped_frequency == pytest.approx(20.0, rel=1e-2 if sampled else 2e-4)
    assert found.damping_ratio == pytest.approx(ratio, rel=0.05 if sampled else 2e-3)
    assert abs(found.damped_frequency - 20.0) < 3 * found.uncertainty.damped_frequency
    for quantity in ("peak_time", "overshoot", "steady_state", "static_gain", "settling_time", "step"):
        assert getattr(found, quantity) is None


def test_release_that_starts_in_motion() -> None:
    run = swing(ratio=0.05, hold=0, count=900)
    later = run.model_copy(update={"time": run.time[100:], "position": run.position[100:], "input": run.input[100:]})
    assert stepid.characterize(later).damped_frequency == pytest.approx(20.0, rel=2e-4)
    assert stepid.characterize(later).damping_ratio == pytest.approx(0.05, rel=2e-3)


def test_a_swing_under_a_force_that_never_changes_is_one_about_another_rest() -> None:
    """A weight of its own or a motor that is left on: declared in motion, its first sample is no step."""
    free = swing(hold=0, noise=2e-6).model_copy(update={"starts": "motion"})
    force = {"input": np.full(free.time.size, 1.5), "position": free.position + 0.012}
    pushed = free.model_copy(update=force)
    expected, found = stepid.characterize(free), stepid.characterize(pushed)
    assert found.static_gain is None
    assert found.damped_frequency == pytest.approx(expected.damped_frequency, rel=1e-9)
    assert found.damping_ratio == pytest.approx(expected.damping_ratio, rel=1e-9)
    assert stepid.characterize_each(pushed) == (found,)
    assert not pushed.is_release
    at_rest = pushed.model_copy(update={"starts": "rest"})
    assert not is_free_response(at_rest)  # the input came on with the first sample


def test_a_hand_that_wanders_while_it_holds_does_not_count() -> None:
    run = swing(noise=20e-6, hold=150)
    wander = np.where(np.arange(run.time.size) < 150, 1.5e-3 * np.sin(np.arange(run.time.size) / 30), 0.0)
    found = stepid.characterize(run.model_copy(update={"position": run.position + wander}))
    assert abs(found.damped_frequency - 20.0) < 3 * found.uncertainty.damped_frequency < 0.06
    assert found.start > 150 * SAMPLE_TIME


def test_uncertainty_covers_noise() -> None:
    found = stepid.characterize(swing(noise=50e-6))
    assert abs(found.damped_frequency - 20.0) < 3 * found.uncertainty.damped_frequency < 0.06
    assert abs(found.damping_ratio - 0.03) < 3 * found.uncertainty.damping_ratio < 0.003


def coulomb_swing(loss: float, ratio: float) -> stepid.Experiment:
    """Half cosines about alternating centers: the closed form of dry friction with viscous damping."""
    frequency, edge, sign, start = 20.0, 0.02, 1.0, 0.0
    count = 900
    time = SAMPLE_TIME * np.arange(count)
    position = np.full(count, edge)
    decay = frequency * ratio / np.sqrt(1 - ratio**2)
    half = np.pi / frequency
    while abs(edge) > loss:
        center = sign * loss
        inside = time >= start
        since = time[inside] - start
        ring = np.exp(-decay * since) * (np.cos(frequency * since) + decay / frequency * np.sin(frequency * since))
        position[inside] = center + (edge - center) * ring
        edge = center - (edge - center) * np.exp(-decay * half)
        start, sign = start + half, -sign
        position[time >= start] = edge
    run = swing(hold=0, count=count)
    return run.model_copy(update={"position": position})


def test_dry_friction_leaves_the_frequency_alone_and_is_noted() -> None:
    run = coulomb_swing(0.4e-3, 0.01)
    found = stepid.characterize(run)
    assert found.damped_frequency == pytest.approx(20.0, rel=5e-4)
    assert found.damping_ratio > 0.01
    assert "dry friction" in found.notes[0]
    extrema = find_extrema(run.time, run.position, rest=0.0, noise=1e-9, peak=stepid.InterpolatedPeak())
    factor = np.exp(-np.pi * 0.01 / np.sqrt(1 - 1e-4))
    assert constant_loss(extrema) == pytest.approx(2 * (1 + factor) * 0.4e-3, rel=0.02)
    assert not stepid.characterize(swing()).notes


def test_pure_dry_friction_loses_four_times_its_offset_a_cycle() -> None:
    run = coulomb_swing(0.4e-3, 0.0)
    extrema = find_extrema(run.time, run.position, rest=0.0, noise=1e-9, peak=stepid.InterpolatedPeak())
    np.testing.assert_allclose(-np.diff(np.abs(extrema.position[::2])), 4 * 0.4e-3, rtol=2e-3)


def test_release_without_a_swing() -> None:
    with pytest.raises(NoOvershootError, match=r"'release'.*turning point"):
        stepid.characterize(swing(ratio=0.9))
    run = swing(ratio=1e-9, count=400)
    growing = run.model_copy(update={"position": 0.004 + (run.position - 0.004) * np.exp(run.time)})
    with pytest.raises((NotSettledError, NoOvershootError), match="'release'"):
        stepid.characterize(growing)


@pytest.mark.parametrize(("spring", "stiffness"), [("Khigh", 712.6), ("Kmed", 315.5)])
def test_milan_releases(spring: str, stiffness: float) -> None:
    root = os.environ.get("STEPID_REAL_DATA")
    if not root:
        pytest.skip("set STEPID_REAL_DATA to the folder of real recordings")
    runs = []
    for folder in sorted(Path(root, "ecp210-milan", "free-release").glob(f"{spring}*")):
        position = 0.01 * np.concatenate([np.loadtxt(file) for file in sorted(folder.glob("data*.txt"))])
        runs.append(
            stepid.Experiment(
                name=folder.name,
                time=0.005 * np.arange(position.size),
                position=position,
                input=np.zeros(position.size),
                added_mass=0.986 if "2mass" in folder.name else 0.0,
                spring=spring,
                damper="none",
                counts_per_meter=56000,
            )
        )
    assert len(runs) == 6
    found = stepid.identify(stepid.Campaign(name="releases", experiments=tuple(runs)))
    assert not found.excluded
    assert found.stiffness[spring] == pytest.approx(stiffness, rel=0.03)
    assert found.base_mass["cart"] == pytest.approx(0.5685, rel=0.07)


def test_side_and_rest_of_a_release_do_not_matter() -> None:
    run = swing(noise=20e-6)
    one = stepid.characterize(run)
    other = stepid.characterize(run.model_copy(update={"position": 0.05 - run.position}))
    turn = 80 * SAMPLE_TIME + np.pi / 20.0  # the hand let go at the 80th sample
    assert (one.start, other.start) == pytest.approx((turn, turn), abs=1e-3)
    assert other.damped_frequency == pytest.approx(one.damped_frequency, rel=1e-9)
    assert other.damping_ratio == pytest.approx(one.damping_ratio, rel=1e-9)


def test_uncertainty_of_the_damping_ratio_is_that_of_repeats() -> None:
    found = []
    for seed in range(16):
        run = swing(ratio=0.1, count=500)
        noise = 2e-5 * np.random.default_rng(seed).standard_normal(run.time.size)
        found.append(stepid.characterize(run.model_copy(update={"position": run.position + noise})))
    off = [(one.damping_ratio - 0.1) / one.uncertainty.damping_ratio for one in found]
    assert 0.5 < float(np.sqrt(np.mean(np.square(off)))) < 1.5


def test_a_sampled_turning_point_is_as_sure_as_its_curvature_says() -> None:
    """Of a swing a·cos ωt the curvature is a ω²."""
    time = SAMPLE_TIME * np.arange(600)
    found = find_extrema(time, 0.02 * np.sin(20.0 * time), rest=0.0, noise=2e-4, peak=stepid.SampledPeak())
    spread, height = sampled_peak_spread(SAMPLE_TIME, 2e-4, 0.02 * 20.0**2)
    np.testing.assert_allclose(found.time_uncertainty, spread, rtol=0.02)
    np.testing.assert_allclose(found.position_uncertainty, height, rtol=0.02)
