"""Decimated records: which samples are kept, and what of their neighbors is averaged."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.fitting import decimation
from stepid.simulation.records import Records, lay_out


@pytest.mark.parametrize(("samples", "step"), [(3, 1), (16, 1), (31, 1), (33, 3), (48, 3), (80, 5), (112, 7)])
def test_a_sixteenth_of_a_period_is_taken_as_one_sample(samples: float, step: int) -> None:
    assert decimation._stride(samples) == step


def linear(residual: Array, records: Records, **more: Any) -> Any:
    layout = SimpleNamespace(mass=lambda _: np.array([1.0]), stiffness=slice(0, 1), damping=slice(1, 2))
    problem = SimpleNamespace(records=records, layout=layout)
    return SimpleNamespace(residual=residual, problem=problem, rms=float(np.sqrt(np.mean(residual**2))), **more)


@pytest.mark.parametrize("damping", [2.0, 20.0, 50.0])
def test_the_shortest_period_is_that_of_the_fastest_pole(damping: float) -> None:
    records: Any = SimpleNamespace(spring=[0], damper=[0])
    found = decimation.shortest_period(linear(np.zeros(1), records, shared=np.array([100.0, damping])))
    assert found == pytest.approx(2 * math.pi / np.abs(np.roots([1.0, damping, 100.0])).max())


def records_of(position: Array, volts: Array, between: str = "held") -> Records:
    run = stepid.Experiment(
        name="r", time=0.001 * np.arange(position.size), position=position, input=volts, added_mass=0.0, spring="s",
        damper="d", starts="rest", input_between=between,
    )  # fmt: skip
    return lay_out(stepid.Campaign(name="c", experiments=(run,)))


def test_a_decimated_record_keeps_the_motion_and_averages_the_gap() -> None:
    t, rng = 0.001 * np.arange(4000), np.random.default_rng(3)
    volts = np.where(t < 0.5, 0.0, 1.0)
    slow, noise = 1e-4 * np.cos(2 * np.pi * 0.5 * t), 1e-5 * rng.standard_normal(4000)
    model = 1e-2 * (1 - np.cos(6.0 * t))
    records = records_of(model + slow + noise, volts)
    few = decimation.decimated(records, linear(slow + noise, records), period=1.0, floor=1e-5)
    assert few.at is not None
    assert few.size == pytest.approx(4000 / 63, abs=4)  # 1,000 samples of a period, 16 kept: 62.5, odd
    assert {0, 500, 3999} <= set(few.at.tolist())  # the ends, and where the input changes
    inner = np.flatnonzero((np.diff(few.at[:-1]) == 63) & (np.diff(few.at[1:]) == 63)) + 1
    assert inner.size > 50
    half = int(0.1 / math.sqrt(float(np.sqrt(np.mean((slow + noise) ** 2))) / 1e-5) / 0.001) // 2
    np.testing.assert_allclose(few.weight[inner] ** 2, 2 * half + 1)
    for at, read in zip(few.at[inner], few.position[inner], strict=True):
        around = slice(at - half, at + half + 1)
        assert read == pytest.approx(model[at] + float(np.mean((slow + noise)[around])), abs=1e-12)


def test_a_kept_sample_whose_neighbors_are_all_left_out_weighs_nothing() -> None:
    t, rng = 0.001 * np.arange(4000), np.random.default_rng(3)
    gap = 1e-3 * np.cos(3.0 * t) + 1e-5 * rng.standard_normal(4000)
    records = records_of(1e-2 * np.cos(6.0 * t) + gap, np.zeros(4000))
    weight = np.where((t > 0.3) & (t < 0.6), 0.0, records.weight)
    few = decimation.decimated(replace(records, weight=weight), linear(gap, records), period=1.0, floor=1e-5)
    assert few.at is not None
    out = weight[few.at] == 0
    assert out.sum() >= 4
    assert not few.weight[out].any()
    assert np.isfinite(few.position).all()


def test_a_record_of_which_every_sample_is_needed_keeps_all() -> None:
    t, rng = 0.001 * np.arange(4000), np.random.default_rng(4)
    busy = records_of(np.sin(6.0 * t), rng.standard_normal(4000))
    gap = 1e-5 * rng.standard_normal(4000)
    assert decimation.decimated(busy, linear(gap, busy), period=1.0, floor=1e-5) is busy
    first = decimation.decimated(busy, linear(gap, busy), period=0.02, floor=1e-5)  # 60 periods of a long record
    assert first.at is not None
    assert first.at.tolist() == list(range(1200))
    least = decimation.decimated(busy, linear(gap, busy), period=0.002, floor=1e-5)
    assert least.size == 200
    lines = records_of(np.sin(6.0 * t), np.where(t < 0.5, 0.0, 1.0), between="lines")
    assert decimation.decimated(lines, linear(gap, lines), period=1.0, floor=1e-5) is lines


@pytest.mark.parametrize(("quiet", "first"), [(0.0, 1200), (0.1, 1200), (0.5, 2667), (0.9, 3790)])
def test_a_first_part_tells_as_much_as_half_of_what_is_missing_shows_on_average(quiet: float, first: int) -> None:
    """A sweep that comes to the resonance late: the part before had told a spring from none."""
    rng = np.random.default_rng(5)
    busy = records_of(np.sin(6e-3 * np.arange(4000)), rng.standard_normal(4000))
    gap = np.where(np.arange(4000) < quiet * 4000, 0.0, 1e-5)
    few = decimation.decimated(busy, linear(gap, busy), period=0.02, floor=1e-5)
    assert few.size == pytest.approx(first, abs=2)
