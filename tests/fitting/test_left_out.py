"""Runs that a fit did not see, also where each of them has something that no other run tells."""

from __future__ import annotations

import numpy as np
import pytest

from scattered_campaigns import scattered
from stepid import Campaign
from stepid.effects import resolve
from stepid.fitting.cross_validation import held_out_residuals, qualifying
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.problem import build, start_local

PART = 0.4


def two_masses() -> Campaign:
    """Two runs of a plant with dry friction, with other added masses: without one of them no mass is known."""
    return scattered(3, masses=(0.0, 1.0), volts=(0.5, -0.5), level=0.15)


def own_dampers() -> Campaign:
    """Three runs of it, each said to have a damper of its own."""
    made = scattered(4, masses=(0.5, 0.5, 0.5), volts=(0.5, -0.5, 0.4), level=0.15)
    runs = (run.model_copy(update={"damper": name}) for run, name in zip(made.experiments, "abc", strict=True))
    return made.model_copy(update={"experiments": tuple(runs)})


def with_friction(context: FitContext) -> Optimum:
    problem = build(context.records, resolve(["coulomb_friction"]))
    start = np.append(context.linear.shared, 0.1)
    found = minimize(problem, start, start_local(problem, context.linear), tolerance=context.tolerance)
    assert found is not None
    return found


def own_bases() -> Campaign:
    """Two runs of it, each said to have a base of its own: the first one's mass is assumed, the other's is not."""
    made = scattered(7, masses=(0.5, 1.0), volts=(0.5, -0.5), level=0.15)
    runs = (run.model_copy(update={"base": name}) for run, name in zip(made.experiments, "ab", strict=True))
    return made.model_copy(update={"experiments": tuple(runs)})


def test_readings_that_are_left_out_do_not_judge() -> None:
    context = prepare(scattered(5, masses=(0.0, 0.5, 1.0), volts=(0.5, -0.5, 0.4), level=0.15))
    records = context.records
    weight = records.weight.copy()
    weight[records.first + 50] = 1e-6
    optimum = context.linear
    problem = build(records.reweighted(weight), ())
    fitted = minimize(problem, optimum.shared, optimum.local, tolerance=context.tolerance)
    assert fitted is not None
    left = held_out_residuals(fitted, tolerance=context.tolerance)
    sizes = np.diff(records.bounds)
    assert left
    assert all(residual.size == sizes[i] - 1 for i, residual in left.items())


@pytest.mark.parametrize("campaign", [two_masses, own_dampers, own_bases])
def test_what_one_run_alone_tells_is_estimated_on_its_first_part(campaign: object) -> None:
    context = prepare(campaign())  # type: ignore[operator]
    assert qualifying(context.records) == []
    assert held_out_residuals(context.linear, tolerance=context.tolerance) == {}
    before, after = (
        held_out_residuals(optimum, tolerance=context.tolerance, part=PART)
        for optimum in (context.linear, with_friction(context))
    )
    runs = range(len(context.records.runs))
    assert list(before) == list(after) == list(runs)
    for run, piece in zip(runs, context.records.pieces(), strict=True):
        count = piece.stop - piece.start
        assert before[run].size == after[run].size == count - round(PART * count)
        assert np.std(after[run]) < 1.5 * context.floor  # a law predicts what a plant without it does not
        assert np.std(before[run]) > 3 * np.std(after[run])


def test_what_others_tell_is_not_estimated_on_the_run_left_out() -> None:
    """Friction that the run left out alone has is nothing that a fit to the others knows of."""
    made = scattered(5, masses=(0.5,) * 3, volts=(0.5, -0.5, 0.5), level=0.15, friction=(0.0, 0.0, 2.0))
    runs = (run.model_copy(update={"damper": name}) for run, name in zip(made.experiments, "abc", strict=True))
    context = prepare(made.model_copy(update={"experiments": tuple(runs)}))
    left = held_out_residuals(with_friction(context), tolerance=context.tolerance, part=PART)
    assert np.std(left[2]) > 3 * context.floor


def test_one_run_cannot_be_left_out() -> None:
    context = prepare(scattered(6, masses=(0.5,), volts=(0.5,)))
    assert held_out_residuals(context.linear, tolerance=context.tolerance, part=PART) == {}


def test_a_run_that_alone_tells_an_effect_judges_nothing() -> None:
    """A saturation that only the first run's input reaches: without it the others say nothing of the level."""
    made = scattered(8, masses=(0.0, 1.0), volts=(0.5, -0.2))
    context = prepare(made)
    problem = build(context.records, resolve(["actuator_saturation"]))
    start = np.append(context.linear.shared, 0.45)
    found = minimize(problem, start, start_local(problem, context.linear), iterations=0)
    assert found is not None
    assert list(held_out_residuals(found, tolerance=context.tolerance, part=PART)) == [1]


def test_a_first_part_in_which_nothing_happens_tells_no_damper() -> None:
    late = own_dampers()
    runs = []
    for run in late.experiments:
        rest = np.zeros(2 * run.time.size)
        time = run.sample_time * np.arange(3 * run.time.size)
        held = np.append(rest + run.position[0], run.position)  # without a jump, which would make two runs of it
        given = {"position": held, "input": np.append(rest, run.input), "time": time}
        runs.append(run.model_copy(update=given))
    context = prepare(late.model_copy(update={"experiments": tuple(runs)}))
    assert held_out_residuals(context.linear, tolerance=context.tolerance, part=PART) == {}
