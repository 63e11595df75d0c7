"""Correlation of residuals, and what it makes of variances, in closed form."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

import stepid
from stepid.fitting.correlation import Block, _faded, autocorrelations, disagreement, inflation
from stepid.fitting.noise_color import colored_floor
from stepid.fitting.run_fault_size import noise_level
from stepid.simulation.records import Records, lay_out


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


def records(*samples: int, step: float = 0.01) -> Records:
    runs = []
    for i, count in enumerate(samples):
        time = step * np.arange(count)
        told: Any = {"position": 0 * time, "input": np.where(time < 0.05, 0.0, 1.0), "added_mass": 0.0}
        runs.append(stepid.Experiment(name=f"{i}", time=time, spring="s", damper="d", **told))
    return lay_out(stepid.Campaign(name="c", experiments=tuple(runs)))


@pytest.mark.parametrize("step", [0.01, 0.002])
def test_correlation_is_looked_at_over_one_swing(step: float) -> None:
    """What never fades is kept for a swing, and fades over another one."""
    made = records(2000, 1500, step=step)
    layout = SimpleNamespace(mass=lambda _: np.array([1.0, 4.0]), stiffness=slice(0, 1))
    optimum: Any = SimpleNamespace(problem=SimpleNamespace(records=made, layout=layout), shared=np.array([400.0]))
    swing = 2 * math.pi * math.sqrt(4.0 / 400.0)  # of the heavier run
    first, second = autocorrelations(optimum, np.ones(3500))
    lags = round(swing / step)
    assert first.size == second.size == 2 * lags
    assert first[:lags] == pytest.approx(1 - 2 * np.arange(1, lags + 1) / 3500)


def test_what_repeats_counts_as_fewer_samples() -> None:
    """Of n equal samples ρ is 1 − k/n: 1 + 2 Σ ρ² over the first third; alternating ones are as far from white."""
    n, runs = 60, 4
    optimum: Any = SimpleNamespace(cost=float(runs * n), solved=None)
    for residual in (np.ones(runs * n), np.resize([1.0, -1.0], runs * n)):
        optimum.problem = SimpleNamespace(records=records(*[n] * runs), residual=lambda _, r=residual: r)
        total = 1 + 2 * sum((1 - k / n) ** 2 for k in range(1, n // 3))
        assert noise_level(optimum, 0.5) == pytest.approx(math.sqrt(total))
        assert noise_level(optimum, 1.1) == 1.1  # as much as the readings' noise: nothing is asked


@pytest.mark.parametrize("period", [0.5, 1.0])
def test_noise_as_slow_as_a_twelfth_of_a_period_is_left_to_the_motion(period: float) -> None:
    """Noise is told with the correlation time that it has, or with none beyond a twelfth of the strongest period."""
    count, step = 6000, 0.002
    for share in (1 / 60, 1 / 5):
        own = math.exp(-step / (share * period))
        drive = 1e-5 * math.sqrt(1 - own**2) * np.random.default_rng(9).standard_normal(count + 400)
        noise = lfilter([1.0], [1.0, -own], drive)[400:]
        made = records(count, step=step)
        moving = replace(made, position=1e-2 * np.sin(2 * math.pi / period * made.time) + noise)
        color = colored_floor(moving, noise)[1]
        if share < 1 / 12:
            assert color is not None
            assert color.correlation_time == pytest.approx(share * period, rel=0.5)
        assert color is None or color.correlation_time <= period / 12
