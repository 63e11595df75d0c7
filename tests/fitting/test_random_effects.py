"""What differs from run to run costs by how much it differs."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import multivariate_normal

import stepid
from hidden.sets import one
from scattered_campaigns import scattered
from stepid.effects import resolve
from stepid.fitting import random_effects
from stepid.fitting.deviations import with_deviations
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.random_effects import price_of_scatter, sizes_of_scatter

GAINS = (0.02, -0.015, 0.03, 0.0, -0.025, 0.01)
RUNS, SAMPLES, NOISE = 12, 50, 0.1


class Fake:
    """As much of a fit as the price reads: one deviation a run."""

    def __init__(self) -> None:
        self.problem = SimpleNamespace(
            layout=SimpleNamespace(deviations=slice(0, 1)), active=np.ones((1, RUNS), dtype=bool)
        )


def test_the_price_is_that_of_the_integral_over_the_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """y = d g + e for each run: −2 ln of the marginal density, from the normal distribution of y itself."""
    draw = np.random.default_rng(3)
    slope = np.sin(np.linspace(0, 9, SAMPLES))
    prices = []
    for width in (1.0, 5.0):
        deviations = width * draw.standard_normal(RUNS)
        deviations *= width / np.sqrt(np.mean(deviations**2))
        readings = deviations[:, None] * slope + NOISE * draw.standard_normal((RUNS, SAMPLES))
        found = readings @ slope / (slope @ slope)
        square = float(np.mean(found**2))
        spread = NOISE**2 * np.eye(SAMPLES) + square * np.outer(slope, slope)
        exact = -2 * float(multivariate_normal(cov=spread).logpdf(readings).sum())
        left = float(np.sum((readings - found[:, None] * slope) ** 2)) / NOISE**2
        plain = left + RUNS * SAMPLES * math.log(2 * np.pi * NOISE**2)
        fake: Any = Fake()
        told = found[None], np.full((1, RUNS), float(np.mean(slope**2)))
        monkeypatch.setattr(random_effects, "_priced", lambda _, told=told: told)
        price = price_of_scatter(fake, np.full(RUNS, float(SAMPLES)), NOISE**2)
        assert price == pytest.approx(exact - plain + math.log(RUNS), abs=0.05)
        prices.append(price)
    assert prices[1] - prices[0] == pytest.approx(2 * RUNS * math.log(5.0), rel=0.02)


def free_in_all(inner: Optimum, kind: str) -> Optimum:
    found = minimize(with_deviations(inner.problem, (kind,)), inner.shared, inner.local)
    assert found is not None
    return found


def price_of(found: Optimum) -> float:
    records = found.problem.records
    counts = np.add.reduceat(records.weight**2, records.first)
    return price_of_scatter(found, counts, found.cost / records.size)


@pytest.mark.slow
def test_three_times_the_scatter_costs_the_logarithm_of_it() -> None:
    near, far = (
        price_of(free_in_all(prepare(scattered(1, gain=[m * g for g in GAINS])).linear, "gain")) for m in (1.0, 3.0)
    )
    assert far - near == pytest.approx(2 * (len(GAINS) - 1) * math.log(3.0), rel=0.1)


def test_start_times_that_are_all_late_cost_more_than_a_delay() -> None:
    """Start times lie about that of the command, unless the model has a delay: then about it."""
    context = prepare(scattered(1, late=[2.1, 1.9, 2.2, 1.8, 2.0, 2.05]))
    alone = free_in_all(context.linear, "start_time")
    delay = fit_effects(context, tuple(resolve(["input_delay"])))
    assert delay is not None
    beside = free_in_all(delay, "start_time")
    assert beside.cost == pytest.approx(alone.cost, rel=0.02)
    assert price_of(alone) - price_of(beside) > 20


def test_nothing_that_differs_costs_nothing() -> None:
    assert price_of(prepare(scattered(1)).linear) == 0.0


@pytest.mark.slow
def test_an_effect_is_named_where_runs_would_have_to_differ_more_without_it() -> None:
    """A saturated drive is a gain that differs from run to run by 7 %; beside it, the gain differs by 1 %."""
    campaign, truth = one("perturbed-single", 16, "dev23")
    assert truth["effects"] == ("actuator_saturation",)
    assert stepid.diagnose(campaign).effects == ("actuator_saturation",)


@pytest.mark.parametrize("place", [0, 3])
def test_the_size_of_scatter_is_that_of_the_runs_in_any_order(place: int) -> None:
    """The run that the others are held against counts as they do."""
    gains = [0.0] * 6
    gains[place] = 0.12
    context = prepare(scattered(3, gain=tuple(gains)))
    problem = with_deviations(context.linear.problem, ("gain",))
    found = minimize(problem, context.linear.shared, np.where(problem.active, 0.0, context.linear.local))
    assert found is not None
    sizes = sizes_of_scatter(found)
    assert sizes == {"gain": pytest.approx(0.12 * math.sqrt(5 / 6) / math.sqrt(5), rel=0.1)}
    assert sizes_of_scatter(context.linear) == {}
