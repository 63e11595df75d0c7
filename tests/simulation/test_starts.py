"""Whether a record starts in motion: as it says, and as its data show."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.signal import lsim

import stepid
from stepid.simulation.starts import starts_in_motion

PLANT = ([7.8], [1.0, 1.6, 216.0])
STEP = 0.01


def record(volts: np.ndarray, first: int = 0, *, noise: float = 1e-5, **fields: object) -> stepid.Experiment:
    """A linear plant from rest, its input in straight lines, without the first samples."""
    time = STEP * np.arange(volts.size)
    _, position, _ = lsim(PLANT, volts, time)
    position = position + noise * np.random.default_rng(3).standard_normal(volts.size)
    before = float(volts[first - 1]) if first else 0.0
    given = {"time": time[first:], "position": position[first:], "input": volts[first:], "input_before": before}
    return stepid.Experiment(
        name="a", added_mass=0.0, spring="s", damper="d", input_between="lines", **(given | fields)
    )


def tones(samples: int = 600) -> np.ndarray:
    time = STEP * np.arange(samples)
    return sum(np.sin(w * time + p) - np.sin(p) for w, p in ((3.0, 0.4), (11.0, 2.0), (17.0, 4.0), (31.0, 1.0)))


SQUARE = np.tile(np.repeat([0.5, 0.0], 80), 4)


@pytest.mark.parametrize("volts", [tones(), SQUARE, np.full(300, 0.5), np.append(np.zeros(40), tones())])
def test_a_record_from_rest_starts_at_rest(volts: np.ndarray) -> None:
    assert not starts_in_motion(record(volts))


@pytest.mark.parametrize("first", range(130, 200, 7))
def test_a_slice_of_a_driven_record_starts_in_motion(first: int) -> None:
    assert starts_in_motion(record(tones(), first))


@pytest.mark.parametrize("first", [15, 30, 95, 120])
def test_a_slice_between_two_steps_starts_in_motion(first: int) -> None:
    assert starts_in_motion(record(SQUARE, first))


def test_a_slice_in_which_the_cart_has_come_to_rest_starts_at_rest() -> None:
    volts = np.append(np.zeros(1000), tones())
    assert not starts_in_motion(record(volts, 900))


@pytest.mark.parametrize("early", [0.5, 1.0, 2.0, 2.9])
@pytest.mark.parametrize("lead", [8, 15, 24])
def test_a_trigger_that_comes_early_moves_no_cart(lead: int, early: float) -> None:
    stiff = (PLANT[0], [1.0, 8.0, 1225.0])  # 18 samples a period: three of them show a third of the swing
    time = STEP * np.arange(400)
    fine = np.linspace(0.0, time[-1], 40 * time.size)
    _, position, _ = lsim(stiff, (fine >= STEP * (lead - early)).astype(float), fine)
    run = record((np.arange(400) >= lead).astype(float), position=np.interp(time, fine, position))
    assert not starts_in_motion(run)


def test_what_the_record_says_counts() -> None:
    assert starts_in_motion(record(tones(), starts="motion"))
    assert not starts_in_motion(record(tones(), 150, starts="rest"))


def test_a_release_starts_in_motion_and_a_still_cart_does_not() -> None:
    time = STEP * np.arange(300)
    swing = 0.02 * np.exp(-0.8 * time) * np.cos(14.7 * time)
    assert starts_in_motion(record(np.zeros(300), position=swing))
    assert not starts_in_motion(record(np.zeros(300), position=np.zeros(300)))


def test_the_fit_of_slices_finds_the_plant() -> None:
    runs = [record(tones(), first).model_copy(update={"name": f"from {first}"}) for first in (131, 170, 222)]
    found = stepid.fit(stepid.Campaign(name="slices", experiments=tuple(runs)))
    assert found.parameters["stiffness[s]"].value == pytest.approx(216.0, rel=2e-3)
    assert found.rms == pytest.approx(1e-5, rel=0.05)
    *starts, ratios = found.notes
    assert starts == [
        f"Run {run.name!r} starts in motion: its initial position and velocity are fitted, too." for run in runs
    ]
    assert ratios.startswith("No two runs differ in added mass")


def test_noise_does_not_make_a_start_in_motion() -> None:
    wrong = []
    for seed, noise in itertools.product(range(10), (1e-5, 1e-4, 1e-3)):
        run = record(tones(), noise=0.0)
        noisy = run.position + noise * np.random.default_rng(seed).standard_normal(run.time.size)
        if starts_in_motion(record(tones(), position=noisy)):
            wrong.append((seed, noise))
    assert not wrong


def test_a_record_in_which_nothing_moves_at_first_starts_at_rest() -> None:
    time = 0.005 * np.arange(2000)
    swing = np.where(time > 5.0, 0.01 * np.sin(10 * (time - 5.0)), 0.0)
    run = stepid.Experiment(
        name="late", time=time, position=swing, input=np.full(2000, 3.0), added_mass=0.0, spring="s", damper="d"
    )
    assert not starts_in_motion(run)
