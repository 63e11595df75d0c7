"""The run that would tell two models apart, for plants of any size, driven or let go."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import diagnosis_example as example
import stepid
from made_up_releases import released
from stepid.diagnosis.experiment_design import _proposals, next_experiment
from stepid.effects import resolve
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.problem import build, fit_linear, start_local
from stepid.simulation.records import Records, lay_out


def fits(records: Records) -> tuple[Optimum, Optimum]:
    """The linear plant, and one with Coulomb friction."""
    linear = fit_linear(records)
    assert linear is not None
    problem = build(records, resolve(["coulomb_friction"]))
    friction = minimize(problem, np.append(linear.shared, example.LEVEL), start_local(problem, linear))
    assert friction is not None
    return linear, friction


def test_releases_are_proposed_where_no_run_has_an_input() -> None:
    records = lay_out(stepid.Campaign(name="releases", experiments=(released(0.0), released(0.5))))
    linear, friction = fits(records)
    told = next_experiment(friction, [linear], floor=1e-6, tell=lambda one: "friction" if one is friction else "none")
    assert re.match(r"To tell friction from none, record a release ", told)
    assert [one.run.added_mass for one in _proposals(records, 0.02, 0.8) if "added" in one.words] == [1.0]


def test_what_both_models_leave_is_in_the_proposed_run_too() -> None:
    """However many times the noise they differ by there, it would not tell them apart."""
    records = lay_out(stepid.Campaign(name="releases", experiments=(released(0.0), released(0.5))))
    linear, friction = fits(records)
    left = replace(friction)
    vars(left)["rms"] = 1.0  # m
    told = next_experiment(left, [linear], floor=1e-6, tell=lambda one: "friction" if one is left else "none")
    assert told == (
        "None of the usual extra runs would tell friction from none: in all of them the models differ by less than "
        "half of what they leave so far. Find out first what is missing in both."
    )


def test_a_run_that_was_left_out_takes_no_part() -> None:
    records = lay_out(example.campaign()).subset([1, 2, 3])
    linear, friction = fits(records)
    told = next_experiment(friction, [linear], floor=1e-5, tell=lambda one: "friction" if one is friction else "none")
    assert re.match(r"To tell friction from none, record a ", told)


def test_weights_and_time_are_those_of_the_plant() -> None:
    records = lay_out(example.campaign())
    masses = np.unique(records.added_mass)
    proposed = _proposals(records, 0.0, 1.2)
    heavier = [one.run for one in proposed if "kg added" in one.words]
    assert [run.added_mass for run in heavier] == [pytest.approx(masses[-1] + np.diff(masses).min())]
    assert {one.run.time.size for one in proposed} <= {run.time.size for run in records.runs}
    alone = lay_out(example.campaign(runs=("case 4",)))
    (half,) = [one.run for one in _proposals(alone, 0.0, 1.2) if "half of the moving mass" in one.words]
    assert half.added_mass == alone.added_mass[0] + 0.6


def test_steps_are_as_large_as_those_from_the_input_before() -> None:
    plain = example.campaign().experiments
    runs = [run.model_copy(update={"input": run.input + 2.0, "input_before": 2.0}) for run in plain]
    pushed = max((float(run.input[np.argmax(np.abs(run.input))]) for run in plain), key=abs)
    proposed = _proposals(lay_out(stepid.Campaign(name="bias", experiments=tuple(runs))), 0.0, 1.2)
    (half,) = [one for one in proposed if "half the size" in one.words]
    assert half.run.input_before == half.run.input[0] == 2.0
    assert f"a step of {pushed / 2:g} V" in half.words
    assert float(np.ptp(half.run.input)) == pytest.approx(abs(pushed) / 2)
    assert any("with the step back to 2 V" in one.words for one in proposed)


def test_a_weight_tells_friction_by_weight_from_coulomb_friction_where_there_is_none() -> None:
    records = lay_out(
        stepid.Campaign(
            name="releases", experiments=(released(0.0), released(0.0, 0.015).model_copy(update={"name": "other"}))
        )
    )
    friction = fits(records)[1]
    problem = build(records, resolve(["load_proportional_friction"]))
    level = friction.shared[-1] / (9.81 * float(friction.problem.layout.mass(friction.shared)[0]))
    by_weight = minimize(problem, np.append(friction.shared[:-1], level), start_local(problem, friction))
    assert by_weight is not None
    told = next_experiment(friction, [by_weight], floor=1e-8, tell=lambda one: "F" if one is friction else "w")
    assert "a release with half of the moving mass added" in told


def test_no_run_tells_a_friction_that_differs_by_direction_from_coulomb_friction() -> None:
    """It is Coulomb friction about another rest position, and where a cart rests is unknown in every run."""
    records = lay_out(example.campaign())
    friction = fits(records)[1]
    level = float(friction.shared[-1])
    problem = build(records, resolve(["asymmetric_friction"]))
    uneven = minimize(problem, np.append(friction.shared[:-1], [0.8 * level, 1.2 * level]), friction.local)
    assert uneven is not None
    told = next_experiment(friction, [uneven], floor=1e-6, tell=lambda one: "even" if one is friction else "uneven")
    assert re.match(r"None of the usual extra runs would tell even from uneven", told)
    linear = fits(records)[0]
    names = {id(friction): "even", id(uneven): "uneven", id(linear): "linear"}
    told = next_experiment(friction, [uneven, linear], floor=1e-6, tell=lambda one: names[id(one)])
    assert re.match(r"To tell even from linear, record ", told)
    assert told.endswith("That run does not tell it from uneven.")


def test_runs_in_which_the_answer_runs_away_are_not_proposed() -> None:
    records = lay_out(stepid.Campaign(name="releases", experiments=(released(0.0), released(0.5))))
    linear, friction = fits(records)
    far = friction.shared.copy()
    far[friction.problem.layout.damping] = -50.0  # swings grow until they are cut off
    told = next_experiment(
        replace(friction, shared=far), [linear], floor=1e-6, tell=lambda one: "none" if one is linear else "wild"
    )
    assert re.match(r"None of the usual extra runs would tell wild from none", told)


def test_a_run_in_which_a_rival_runs_away_does_not_hide_the_others() -> None:
    """A spring that softens with the cube of the travel has nothing beyond its hilltop, which a release is."""
    records = lay_out(stepid.Campaign(name="releases", experiments=(released(0.0), released(0.5))))
    linear, _ = fits(records)
    problem = build(records, resolve(["cubic_stiffness"]))
    hilltop = 0.025  # m, beyond the 20 mm of the runs and before the farthest release
    softer = minimize(problem, np.append(linear.shared, 0.0), start_local(problem, linear))
    assert softer is not None
    stiffness = float(softer.shared[softer.problem.layout.stiffness][0])
    rival = replace(softer, shared=np.append(softer.shared[:-1], -stiffness / hilltop**2))
    told = next_experiment(linear, [rival], floor=1e-6, tell=lambda one: "none" if one is linear else "cubic")
    assert re.match(r"To tell none from cubic, record a release ", told)
    assert "farther" not in told
