"""Accuracy and coverage of the peak method on closed-form campaigns: short here, at length in benchmarks."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import stepid

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

from accuracy import measure
from paper_coverage import z_scores


def test_noise_free_accuracy() -> None:
    errors, _, refused = measure(40, peak=stepid.InterpolatedPeak(), envelope=1e-3, window=1.0)
    assert refused == 0
    assert errors.max() < 2e-4  # the acceptance asks for 1e-3


@pytest.mark.parametrize(("envelope", "window"), [(2e-2, 0.5), (4e-2, 0.25)])
def test_short_records_stay_within_their_uncertainty(envelope: float, window: float) -> None:
    errors, scores, refused = measure(15, peak=stepid.InterpolatedPeak(), envelope=envelope, window=window)
    assert refused < 8
    assert np.abs(scores).max() < 2
    assert errors.max() < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 20e-6])
def test_coverage_of_sampled_peaks(noise: float) -> None:
    for solver, by_quantity in z_scores(400, noise=noise, peak=stepid.SampledPeak()).items():
        for quantity, scores in by_quantity.items():
            assert scores.size >= 400
            assert 92 <= 100 * np.mean(np.abs(scores) < 1.96) <= 98, (solver, quantity)


@pytest.mark.slow
def test_coverage_of_sampled_peaks_in_short() -> None:
    found = z_scores(60, noise=20e-6, peak=stepid.SampledPeak())
    for by_quantity in found.values():
        for scores in by_quantity.values():
            assert np.mean(np.abs(scores) < 1.96) > 0.85
            assert 0.6 < np.sqrt(np.mean(np.clip(np.abs(scores), 0, 4) ** 2)) < 1.4
