"""The run that would tell two models apart, for plants of any size, driven or let go."""

from __future__ import annotations

import re

import numpy as np
import pytest

import diagnosis_example as example
import stepid
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


def released(added: float, displacement: float = 0.02) -> stepid.Experiment:
    """A release in closed form."""
    time = np.arange(600) * 0.005
    mass, stiffness, damping = 0.8 + added, 300.0, 4.0
    decay = damping / (2 * mass)
    swing = np.sqrt(stiffness / mass - decay**2)
    y = displacement * np.exp(-decay * time) * (np.cos(swing * time) + decay / swing * np.sin(swing * time))
    noise = np.random.default_rng(3).normal(0.0, 1e-6, 600)
    return stepid.Experiment(
        name=f"release {added:g}",
        time=time,
        position=y + noise,
        input=np.zeros(600),
        added_mass=added,
        spring="soft",
        damper="oil",
    )


def test_releases_are_proposed_where_no_run_has_an_input() -> None:
    records = lay_out(stepid.Campaign(name="releases", experiments=(released(0.0), released(0.5))))
    linear, friction = fits(records)
    told = next_experiment(friction, [linear], floor=1e-6, tell=lambda one: "friction" if one is friction else "none")
    assert re.match(r"To tell friction from none, record a release ", told)
    assert [one.run.added_mass for one in _proposals(records, 0.02) if "added" in one.words] == [1.0]


def test_a_run_that_was_left_out_takes_no_part() -> None:
    records = lay_out(example.campaign()).subset([1, 2, 3])
    linear, friction = fits(records)
    told = next_experiment(friction, [linear], floor=1e-5, tell=lambda one: "friction" if one is friction else "none")
    assert re.match(r"To tell friction from none, record a ", told)


def test_weights_and_time_are_those_of_the_plant() -> None:
    records = lay_out(example.campaign())
    masses = np.unique(records.added_mass)
    proposed = _proposals(records, 0.0)
    heavier = [one.run for one in proposed if "kg added" in one.words]
    assert [run.added_mass for run in heavier] == [pytest.approx(masses[-1] + np.diff(masses).min())]
    assert {one.run.time.size for one in proposed} <= {run.time.size for run in records.runs}
    alone = lay_out(example.campaign(runs=("case 4",)))
    assert not [one for one in _proposals(alone, 0.0) if "added" in one.words]
