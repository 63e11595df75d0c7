"""Whether a residual is white, whatever its size."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.fitting.noise_floor import succession
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
