"""Readings that repeat although there is noise: a clipped or stuck sensor is told, a cart at rest is not."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

import stepid
from stepid.fitting.fit import prepare
from stepid.fitting.flat_readings import flat_readings

TIME = 0.005 * np.arange(400)
LATE = np.maximum(TIME - 0.2, 0.0)
STEP = 0.01 * (1.0 - np.exp(-2.0 * LATE) * (np.cos(18.6 * LATE) + 2.0 / 18.6 * np.sin(18.6 * LATE)))
NOISE = 2e-5


def steps(
    spoil: Callable[[np.ndarray], np.ndarray], *, count: float = 0.0, noise: float = NOISE
) -> list[stepid.Experiment]:
    """Three steps as a sensor of so large a step [m] reads them; the second of them is spoiled."""
    rng, runs = np.random.default_rng(1), []
    for i, added in enumerate((0.0, 0.5, 1.0)):
        y = STEP + noise * rng.standard_normal(TIME.size)
        y = spoil(y) if i == 1 else y
        y = count * np.round(y / count) if count else y
        runs.append(
            stepid.Experiment(
                name=f"step {i}", time=TIME, position=y, input=np.where(TIME < 0.2, 0.0, 1.0), added_mass=added,
                spring="s", damper="d",
            )
        )  # fmt: skip
    return runs


def told(runs: list[stepid.Experiment]) -> dict[str, str]:
    """What is said, by run."""
    found = flat_readings(runs)
    assert all(mended.run is next(run for run in runs if run.name == name) for name, mended in found.items())
    return {name: fault.words for name, mended in found.items() for fault in mended.faults}


def stuck(y: np.ndarray) -> np.ndarray:
    return np.where(TIME < 0.6, y, y[120])


@pytest.mark.parametrize("spoil", [stuck, lambda y: np.minimum(y, 0.012), lambda y: np.minimum(y, 0.009)])
@pytest.mark.parametrize("count", [0.0, 1e-5])
def test_a_sensor_that_is_clipped_or_stuck_is_told(spoil: Callable[[np.ndarray], np.ndarray], count: float) -> None:
    words = told(steps(spoil, count=count))
    assert set(words) == {"step 1"}
    assert "clipped or stuck" in words["step 1"]
    noise = re.search(r"noise at rest is ([\d.]+) µm", words["step 1"])
    assert noise is not None
    assert 1e-6 * float(noise[1]) == pytest.approx(NOISE, rel=0.3)  # 41 readings, the quietest of three


def test_when_it_began_and_how_often_is_told() -> None:
    assert "repeats readings in 280 samples, from 0.6 s on" in told(steps(stuck))["step 1"]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("count", [0.0, 1e-5, 2e-5, 5e-5])
def test_noise_and_the_counts_of_an_encoder_are_not(seed: int, count: float) -> None:
    rng = np.random.default_rng(seed)
    assert told(steps(lambda y: y + 1e-6 * rng.standard_normal(y.size), count=count)) == {}


def test_a_rest_that_the_encoder_does_not_resolve_says_nothing() -> None:
    assert told(steps(stuck, count=1e-4)) == {}
    assert told(steps(stuck, noise=0.0)) == {}


def test_a_cart_that_slips_before_its_step_is_no_noise() -> None:
    """Its rest scatters by more than a count of the encoder, each of which is read many times."""
    creep = 1.5e-4 * (TIME >= 0.1)
    runs = [run.model_copy(update={"position": 5e-5 * np.round((STEP + creep) / 5e-5)}) for run in steps(stuck)]
    assert np.std(runs[0].position[TIME < 0.2]) > 5e-5
    assert told(runs) == {}


def test_a_single_repeated_reading_is_no_stretch() -> None:
    def twice(y: np.ndarray) -> np.ndarray:
        return np.where((TIME > 0.6) & (TIME < 0.612), y[120], y)

    assert told(steps(twice)) == {}


@pytest.mark.parametrize("spoil", [stuck, lambda y: np.minimum(y, 0.012)])
def test_they_are_left_out_and_said_and_the_rest_counts(spoil: Callable[[np.ndarray], np.ndarray]) -> None:
    """The plant of the others, though a third of the readings is wrong by millimeters."""
    campaign = stepid.Campaign(name="steps", experiments=steps(spoil))
    context = prepare(campaign)
    assert context.linear.rms < 1.5 * context.floor
    (fault,) = context.faults
    assert (fault.run, fault.kind, fault.unit) == ("step 1", "flat readings", "s")
    mask = flat_readings(campaign.experiments)["step 1"].wrong
    assert fault.size == pytest.approx(0.005 * mask.sum())
    assert np.array_equal(context.records.trusted, np.concatenate([~np.zeros(400, bool), ~mask, ~np.zeros(400, bool)]))
    assert fault.words in stepid.fit(campaign).notes
