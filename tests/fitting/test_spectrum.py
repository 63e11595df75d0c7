"""What rings in a residual: the strongest swings, and a line however faint beside them."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.fitting.spectrum import resonances, strongest_period
from stepid.simulation.records import Records, lay_out

STEP = 0.005


def records(*sizes: int) -> Records:
    position = np.sin(2 * np.pi * 1.25 * STEP * np.arange(max(sizes)))
    runs = [
        stepid.Experiment(
            name=f"case {i}",
            time=STEP * np.arange(n),
            position=0.01 * position[:n],
            input=np.zeros(n),
            added_mass=0.5 * i,
            spring="medium",
            damper="half",
        )
        for i, n in enumerate(sizes)
    ]
    return lay_out(stepid.Campaign(name="made", experiments=tuple(runs)))


def swings(laid_out: Records, decay: float = 1.0) -> Array:
    """A decaying swing of 1.25 Hz, and another of 2.9 Hz, in every run."""
    t = laid_out.time
    out: Array = np.exp(-decay * t) * (np.sin(2 * np.pi * 1.25 * t) + 0.7 * np.sin(2 * np.pi * 2.9 * t + 1))
    return out


def test_the_strongest_swing_comes_first() -> None:
    laid_out = records(900, 800, 900)
    found = resonances(laid_out, swings(laid_out), count=2)
    assert found[0] == pytest.approx(1.25, abs=0.1)
    assert found[1] == pytest.approx(2.9, abs=0.2)
    assert strongest_period(laid_out) == pytest.approx(0.8, rel=0.02)


@pytest.mark.parametrize("unit", [1.0, 1e-4])
def test_where_nothing_swings_the_record_tells_the_period_in_any_unit_of_time(unit: float) -> None:
    """It had been half a second."""
    rng, runs = np.random.default_rng(4), []
    for samples in (400, 600):
        time = 0.01 * unit * np.arange(samples)
        readings = {"time": time, "position": 1e-5 * rng.standard_normal(samples), "input": np.ones(samples)}
        named = {"name": str(samples), "spring": "s", "damper": "d"}
        runs.append(stepid.Experiment(**named, **readings, added_mass=0.0, input_before=1.0, starts="rest"))
    assert strongest_period(lay_out(stepid.Campaign(name="n", experiments=runs))) == pytest.approx(0.9975 * unit)


def test_a_line_is_heard_beside_swings_a_hundred_times_as_large() -> None:
    laid_out = records(900, 800, 900)
    rng = np.random.default_rng(1)
    residual = swings(laid_out) + 1e-3 * rng.standard_normal(laid_out.time.size)
    assert len(resonances(laid_out, residual)) == 3
    for frequency in (16.3, 61.0):
        phase = rng.uniform(0, 2 * np.pi, 3)[laid_out.run]
        line = 0.01 * np.sin(2 * np.pi * frequency * laid_out.time + phase)
        assert resonances(laid_out, residual + line)[-1] == pytest.approx(frequency, abs=0.1)


def test_noise_has_no_line() -> None:
    laid_out = records(400, 900, 1500)
    for seed in range(200):
        noise = np.random.default_rng(seed).standard_normal(laid_out.time.size)
        assert len(resonances(laid_out, noise)) == 3
