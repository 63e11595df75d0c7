"""What runs differ by is recovered run by run, and promised by one linearized step."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from broken_campaigns import SAMPLE_TIME, campaign
from scattered_campaigns import scattered
from stepid.effects import resolve
from stepid.fitting.deviations import (
    FAULTS,
    SCATTER,
    promised,
    scatter_values,
    with_deviations,
    with_fault,
    without_deviations,
)
from stepid.fitting.fit import prepare, unpack
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.problem import build, start_local
from stepid.fitting.random_effects import deviation_std

JITTER = (0.7, -0.4, 1.0, 0.15, -0.95, 0.3)
GAINS = (0.02, -0.015, 0.03, 0.0, -0.025, 0.01)


def refit(inner: Optimum, *kinds: str) -> Optimum:
    found = minimize(with_deviations(inner.problem, kinds), inner.shared, inner.local)
    assert found is not None
    return found


def test_start_times_are_recovered() -> None:
    context = prepare(scattered(1, late=JITTER))
    found = refit(context.linear, "start_time")
    late = scatter_values(found)["start_time"] / SAMPLE_TIME
    assert np.abs(late - (np.array(JITTER) - np.mean(JITTER))).max() < 0.05
    assert found.rms < 1.2 * context.floor < 0.5 * context.linear.rms
    assert deviation_std(scatter_values(found), context.records.damper)["start_time"] == pytest.approx(
        np.std(JITTER, ddof=1) * SAMPLE_TIME, rel=0.05
    )
    assert set(unpack(found, ()).runs["case 3"].deviations) == {"start_time"}


def test_without_what_differs_it_is_the_fit_from_before() -> None:
    linear = prepare(scattered(1, late=JITTER)).linear
    back = without_deviations(refit(linear, "start_time"), 0.0)
    assert back.cost == pytest.approx(linear.cost, rel=1e-6)
    assert "start_time" not in scatter_values(back)


def test_a_model_with_start_times_simulates_as_it_was_fitted() -> None:
    whole = scattered(1, late=JITTER)
    found = refit(prepare(whole).linear, "start_time")
    seen = stepid.simulate(unpack(found, ()), whole)
    residual = np.concatenate([e.position - seen[e.name] for e in whole.experiments])
    np.testing.assert_allclose(residual, found.residual, atol=1e-8)


@pytest.mark.parametrize(("kind", "true"), [("gain", GAINS), ("damping", tuple(2 * g for g in GAINS))])
def test_gain_and_damping_are_recovered(kind: str, true: tuple[float, ...]) -> None:
    context = prepare(scattered(2, gain=true if kind == "gain" else None, damping=true if kind == "damping" else None))
    found = refit(context.linear, kind)
    values = scatter_values(found)[kind]
    assert np.abs(values - (np.array(true) - np.mean(true))).max() < 0.004
    assert found.rms < 1.1 * context.floor
    others = set(SCATTER) - {kind}
    gains = promised(context.linear, SCATTER)
    assert gains[kind].gain > max(gains[other].gain for other in others if other in gains)


@pytest.mark.slow
def test_levels_of_friction_are_recovered() -> None:
    true = (0.1, -0.2, 0.2, 0.0, -0.1, 0.15)
    context = prepare(scattered(3, friction=true, level=0.3))
    one = fit_effects(context, resolve(["coulomb_friction"]))
    assert one is not None
    found = refit(one, "friction")
    assert found.rms < 0.8 * one.rms
    assert np.abs(scatter_values(found)["friction"] - (np.array(true) - np.mean(true))).max() < 0.05


def test_without_dry_friction_none_scatters() -> None:
    context = prepare(campaign(4))
    assert not with_deviations(context.linear.problem, ("friction",)).active.any()
    assert set(promised(context.linear, SCATTER)) == {"start_time", "gain", "damping"}


def test_one_run_stands_for_the_plant() -> None:
    problem = prepare(campaign(4)).linear.problem
    more = with_deviations(problem, frozenset(SCATTER))
    rows = {q: more.active[problem.layout.deviation(q)].tolist() for q in SCATTER}
    assert rows["start_time"] == [True] * 4
    assert rows["gain"] == rows["damping"] == [False, True, True, True]
    delayed = build(problem.records, resolve(["input_delay"]))
    held = with_deviations(delayed, ("start_time",)).active[delayed.layout.deviation("start_time")]
    assert held.tolist() == [False, True, True, True]


def test_healthy_runs_promise_next_to_nothing() -> None:
    context = prepare(scattered(5))
    for promise in promised(context.linear, [*SCATTER, *((r, k) for r in range(6) for k in FAULTS)]).values():
        assert promise.gain < 30 * context.floor**2
        sure = np.isfinite(promise.errors)
        assert np.all(np.abs(promise.values[sure]) < 5 * promise.errors[sure] * context.floor)


@pytest.mark.parametrize("kind", ["added_mass", "gain"])
def test_a_fault_of_one_run_promises_most_in_that_run(kind: str) -> None:
    whole = (
        campaign(6, true_masses=(0, 0.5, 1.6, 2.0)) if kind == "added_mass" else scattered(6, gain=(0, 0, 0.1, 0, 0, 0))
    )
    context = prepare(whole)
    every = [(run, k) for run in range(len(whole.experiments)) for k in FAULTS]
    gains = promised(context.linear, every)
    run, best = max(gains, key=lambda k: gains[k].gain)
    assert (run, best) == (2, kind)
    assert gains[run, best].values[2] == pytest.approx(0.1, rel=0.2)
    found = minimize(with_fault(context.linear.problem, 2, kind), context.linear.shared, context.linear.local)
    assert found is not None
    assert found.rms < 1.1 * context.floor
    assert found.local[found.problem.layout.deviation(kind), 2] == pytest.approx(0.1, rel=0.02)
    assert (context.linear.cost - found.cost) == pytest.approx(gains[run, best].gain, rel=0.2)


def test_deviations_are_handed_on() -> None:
    context = prepare(scattered(1, late=JITTER))
    found = refit(context.linear, "start_time")
    problem = with_deviations(build(context.records, resolve(["presliding_hysteresis"])), ("start_time",))
    local, there = start_local(problem, found), problem.layout
    np.testing.assert_array_equal(local[there.deviations], found.local[found.problem.layout.deviations])


def test_what_scatters_differs_by_a_quarter_at_most() -> None:
    """A gain of half is a fault or a law: as scatter it stays at its bound, as one run's fault it is found."""
    linear = prepare(scattered(2, gain=(0.0, 0.0, 0.0, 0.0, 0.0, -0.5))).linear
    found = refit(linear, "gain")
    row = found.problem.layout.deviation("gain")
    assert np.abs(found.local[row]).max() == pytest.approx(0.25)
    assert found.converged
    free = minimize(with_fault(found.problem, 5, "gain"), found.shared, found.local)
    assert free is not None
    assert free.local[row, 5] == pytest.approx(-0.5, abs=0.1)


def test_a_start_comes_six_samples_late_at_most() -> None:
    linear = prepare(scattered(1, late=(0.0, 0.0, 0.0, 0.0, 0.0, 12.0))).linear
    found = refit(linear, "start_time")
    row = found.problem.layout.deviation("start_time")
    assert np.abs(found.local[row]).max() == pytest.approx(6.0 * SAMPLE_TIME)


def test_a_start_within_three_standard_deviations_of_two_samples_is_found() -> None:
    late = (1.5, 0.0, 2.0, 0.5, 1.0, 5.5)
    found = refit(prepare(scattered(1, late=late)).linear, "start_time")
    row = found.problem.layout.deviation("start_time")
    np.testing.assert_allclose(found.local[row], np.multiply(late, SAMPLE_TIME), atol=0.1 * SAMPLE_TIME)


def test_friction_under_a_load_scatters_as_well() -> None:
    (law,) = resolve(["load_proportional_friction"])
    context = prepare(campaign(3))
    problem = with_deviations(build(context.records, (law,)), ["friction"])
    assert problem.active[problem.layout.deviation("friction")].sum() == len(context.records.runs) - 1
