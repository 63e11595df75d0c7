"""Correlation of residuals, and what it makes of variances, in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from stepid.fitting.correlation import Block, _faded, disagreement, inflation


def test_autocorrelation_of_first_order_noise() -> None:
    drive = np.random.default_rng(8).standard_normal(40_200)
    y = lfilter([1.0], [1.0, -0.6], drive)[200:]
    found = _faded([y[:25_000], y[25_000:]], 200)
    np.testing.assert_allclose(found[:4], 0.6 ** np.arange(1.0, 5.0), atol=0.03)
    assert _faded([drive[:20_000]], 200).size <= 2
    assert not _faded([np.zeros(50)], 20).size


def test_inflation_of_a_mean_is_that_of_its_correlation() -> None:
    """Rows of ones: 1 + 2 Σ ρₖ (1 − k/n)."""
    n, own = 64, np.array([0.5, 0.25, 0.1])
    block = Block(slice(0, n), np.array([0]), np.ones((1, n)), np.eye(1))
    inverse = np.array([[1 / math.sqrt(n)]])
    found = inflation([block], [own], inverse, np.ones(1))
    assert found == pytest.approx([1 + 2 * float(np.sum(own * (1 - np.arange(1, 4) / n)))])
    assert inflation([block], [np.zeros(0)], inverse, np.ones(1)).tolist() == [1.0]


def test_runs_that_pull_apart_disagree_by_their_pulls() -> None:
    """Σ (pull/level)² over the runs, times R/(R − 1)."""
    blocks = [Block(slice(i, i + 1), np.array([0]), np.ones((1, 1)), np.eye(1)) for i in range(3)]
    found = disagreement(blocks, np.array([3.0, -1.0, -2.0]), np.ones((1, 1)), np.ones(1), 0.5)
    assert found == pytest.approx([(9 + 1 + 4) / 0.25 * 3 / 2])
    assert disagreement(blocks[:1], np.array([3.0]), np.ones((1, 1)), np.ones(1), 0.5).tolist() == [1.0]
