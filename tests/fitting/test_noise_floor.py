"""Whether a residual is white, whatever its size."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim

import stepid
from stepid.fitting.noise_floor import sensor_noise, succession
from stepid.simulation.records import lay_out

RECORDS = lay_out(stepid.datasets.lab_campaign())


def _noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=RECORDS.size)


def test_white_noise_gives_one_within_its_error() -> None:
    found = [succession(RECORDS, _noise(seed)) for seed in range(200)]
    count = found[0][1]
    assert 1000 < count < RECORDS.size
    scores = np.array([(ratio - 1.0) * np.sqrt(count) for ratio, _ in found])
    assert abs(scores.mean()) < 0.3
    assert scores.std() == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("size", [1e-9, 1e-3])
def test_the_size_of_the_residual_does_not_matter(size: float) -> None:
    assert succession(RECORDS, size * _noise(1))[0] == pytest.approx(succession(RECORDS, _noise(1))[0])


def test_a_slow_misfit_as_large_as_a_third_of_the_noise_shows() -> None:
    wave = np.sqrt(2) / 3 * np.sin(2 * np.pi * 1.5 * RECORDS.time)
    ratio, count = succession(RECORDS, _noise(2) + wave)
    assert ratio > 1.0 + 3.0 / np.sqrt(count)


@pytest.mark.parametrize("samples", [8, 15, 60])
@pytest.mark.parametrize("noise", [2e-4, 5e-3])
def test_an_input_that_changes_at_every_sample_is_no_noise(samples: int, noise: float) -> None:
    rng = np.random.default_rng(4)
    time = np.arange(900) / samples
    volts = rng.standard_normal(900)
    _, swing, _ = lsim(([1.0], [1.0, 0.6, 4 * np.pi**2]), volts, time)
    size = noise * float(np.std(swing))
    run = stepid.Experiment(
        name="a", time=time, position=swing + size * rng.standard_normal(900), input=volts, added_mass=0.0,
        spring="s", damper="d", input_between="lines",
    )  # fmt: skip
    found = sensor_noise(lay_out(stepid.Campaign(name="c", experiments=(run,))))
    assert found == pytest.approx(size, rel=0.15)


@pytest.mark.skipif("STEPID_REAL_DATA" not in os.environ, reason="STEPID_REAL_DATA does not name the real recordings")
@pytest.mark.parametrize(("kind", "left"), [("multisine", 0.33e-3), ("arrow", 0.43e-3)])
def test_the_floor_of_the_silverbox_is_what_a_cubic_spring_leaves(kind: str, left: float) -> None:
    runs = []
    for file in sorted((Path(os.environ["STEPID_REAL_DATA"]) / "silverbox").glob(f"{kind}-*.csv")):
        volts, position = np.loadtxt(file, delimiter=",", skiprows=1, unpack=True)
        clock = np.arange(volts.size) * 2**14 / 1e7
        runs.append(
            stepid.Experiment(
                name=file.stem, time=clock, position=position, input=volts, added_mass=0.0, spring="s", damper="d"
            )
        )
    found = sensor_noise(lay_out(stepid.Campaign(name="silverbox", experiments=tuple(runs))))
    assert 0.6 * left < found < 1.2 * left  # 0.63 and 0.82 mV by differences
