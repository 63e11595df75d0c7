"""What a linear response leaves of single runs, against counts and averages that are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stepid
from closed_form import SAMPLE_TIME, Plant, make_run
from stepid.identification.remainder import Remainder, remainder, warning

PLANT = Plant(base_mass=0.95, stiffness=216.0, damping=12.0)
DECAY, FREQUENCY = PLANT.rates(0.0)
START = {"damped_frequency": FREQUENCY, "damping_ratio": PLANT.damping_ratio(0.0)}


def left(run: stepid.Experiment) -> Remainder:
    found = remainder(run, **START)
    assert found is not None
    return found


def test_noise_leaves_what_noise_is_expected_to_leave() -> None:
    """Four unknowns take four samples' worth: of a short run that shows."""
    rng = np.random.default_rng(11)
    runs = [make_run(PLANT, 0.0, count=48, noise=1e-4, rng=rng) for _ in range(60)]
    found = [left(run) for run in runs]
    assert {one.samples for one in found} == {44}
    assert sum(one.square for one in found) == pytest.approx(60 * 44 * 1e-8, rel=0.06)


def test_noise_is_expected_of_as_many_samples_as_are_left_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stepid.identification.remainder.noise_level", lambda *_, **__: 1.0)
    assert left(make_run(PLANT, 0.0, count=48, noise=1e-4)).noise == 44.0


def test_means_are_over_a_tenth_of_a_period() -> None:
    run = make_run(PLANT, 0.0, count=500, noise=1e-4)
    width = round(0.1 * 2 * math.pi / FREQUENCY / SAMPLE_TIME)
    assert left(run).blocks == 500 // width - 2


def test_what_rounding_hides_is_not_averaged() -> None:
    coarse = make_run(PLANT, 0.0, noise=1e-6, counts_per_meter=10_000)
    assert (left(coarse).blocks, left(coarse).means) == (0, 0.0)
    assert left(make_run(PLANT, 0.0, noise=3e-4, counts_per_meter=10_000)).blocks > 0


def test_what_a_hand_holds_is_no_part_of_a_release() -> None:
    time = SAMPLE_TIME * np.arange(400)
    since = np.maximum(time - time[80], 0.0)
    swing = 0.02 * np.exp(-DECAY * since) * (np.cos(FREQUENCY * since) + DECAY / FREQUENCY * np.sin(FREQUENCY * since))
    noisy = swing + 2e-5 * np.random.default_rng(12).standard_normal(400)
    run = stepid.Experiment(name="r", time=time, position=noisy, input=0 * time, added_mass=0.0, spring="s", damper="d")
    found = left(run)
    assert found.samples <= 320
    assert found.square == pytest.approx(found.samples * 4e-10, rel=0.25)


def test_a_plant_that_does_not_swing_is_not_looked_at() -> None:
    run = make_run(PLANT, 0.0)
    assert remainder(run, damped_frequency=FREQUENCY, damping_ratio=1.2) is None
    assert remainder(run, damped_frequency=FREQUENCY, damping_ratio=0.0) is None


@pytest.mark.parametrize(("deviations", "said"), [(5.0, False), (7.0, True)])
def test_means_of_more_than_six_standard_deviations_are_told(deviations: float, said: bool) -> None:
    """Of n squares the sum has the mean n and the variance 2n."""
    one = Remainder(1000e-10, 1000e-10, 200 + deviations * math.sqrt(400), samples=1000, blocks=200)
    assert (warning([one]) is not None) is said
    assert (warning([one, None]) is not None) is said


@pytest.mark.parametrize(("times", "said"), [(1.15, False), (1.25, True)])
def test_a_fifth_more_than_the_noise_is_told(times: float, said: bool) -> None:
    one = Remainder(times**2 * 1000e-10, 1000e-10, 0.0, samples=1000, blocks=0)
    note = warning([one])
    assert (note is not None) is said
    assert note is None or f"leaves {10 * times:.3g} µm, and the noise is 10.0 µm" in note
