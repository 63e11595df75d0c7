"""Scores along the measured motion: what the equation tells where the linear plant's response is another motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from broken_campaigns import DAMPING, STIFFNESS, campaign
from stepid.diagnosis.selection.proposal import related
from stepid.effects import CATALOGUE, Effect, resolve
from stepid.fitting.equation_score import EquationOfMotion
from stepid.fitting.fit import prepare
from stepid.fitting.joint_score import JointScore, ScoredSet
from stepid.fitting.multistart import FitContext
from stepid.fitting.score_test import columns, difference
from stepid.fitting.tangent import Tangent

# strong friction: the cart stands still where the linear plant swings on
STRONG = {"coulomb_friction": {"level": 0.3}, "quadratic_damping": {"coefficient": 40.0}}
TRUE = np.array([STIFFNESS["medium"], DAMPING["half"]])
WITH_LAG = STRONG | {"actuator_rate_limit": {"rate": 12.0}}


def prepared(effects: Mapping[str, Mapping[str, float]]) -> FitContext:
    return prepare(campaign(3, effects, masses=(0.0, 0.5, 1.5)))


def apart(one: Effect, other: Effect) -> bool:
    return not related(one, other)


def place(found: list[ScoredSet], hidden: Mapping[str, object]) -> int:
    """How many sets come before the true one; all of them where it is not there."""
    sets = list(dict.fromkeys(frozenset(e.name for e in one.effects) for one in found))
    return sets.index(frozenset(hidden)) if frozenset(hidden) in sets else len(sets)


@pytest.fixture(scope="module")
def strong() -> FitContext:
    return prepared(STRONG)


def test_the_equation_finds_what_strong_friction_hides_from_the_response() -> None:
    fit = prepared(WITH_LAG)
    equation = EquationOfMotion(fit)
    along = place(JointScore(equation, equation.columns(CATALOGUE), apart=apart).sets(3, 1), WITH_LAG)
    response = place(JointScore(Tangent(fit.coarse_linear), columns(fit, CATALOGUE), apart=apart).sets(3, 1), WITH_LAG)
    assert along < 8 <= response


def test_its_starts_are_near_the_truth(strong: FitContext) -> None:
    equation = EquationOfMotion(strong)
    score = JointScore(equation, equation.columns(resolve(tuple(STRONG))), apart=apart)
    found = score.sets(2, 1)[0]
    for effect, values in zip(found.effects, found.values, strict=True):
        assert values[0] == pytest.approx(next(iter(STRONG[effect.name].values())), rel=0.25)
    linear = strong.coarse_linear.problem.layout.linear
    both = score.adapted(found), strong.linear.shared
    near, far = (np.abs(np.log(shared[linear][1:3] / TRUE)).max() for shared in both)
    assert near < 0.3 * far


def test_a_set_of_more_coefficients_than_it_has_samples_leaves_no_hope(strong: FitContext) -> None:
    equation = EquationOfMotion(strong)
    equation.samples = 2.0
    found = JointScore(equation, equation.columns(resolve(tuple(STRONG))), apart=apart).sets(2, 1)
    assert [one.left for one in found] == [np.inf]


def test_short_bumps_are_taken_where_long_ones_do_not_fit_into_the_motion() -> None:
    swings, stops = EquationOfMotion(prepared(STRONG)), EquationOfMotion(prepared({"coulomb_friction": {"level": 0.9}}))
    assert stops.width < swings.width


def test_what_moves_the_linear_plant_alike_is_the_force_that_a_drive_takes_away(strong: FitContext) -> None:
    """A dead zone of 0.1 V, on steps of 0.5 V: less force by the gain times 0.1 V while they last."""
    weak = EquationOfMotion(strong)._weak
    (effect,), linear = resolve(["actuator_dead_zone"]), strong.linear
    change = difference(linear, effect, (0.1,))
    assert change is not None
    found = weak.force_behind(change[:, 0], linear.shared)
    gain = linear.shared[linear.problem.layout.force_gain]
    records = strong.records
    held = np.sign(records.volts)
    over_samples = 0.5 * (held + np.concatenate([[0.0], held[:-1]]))  # held until the next one
    true = weak.test([-0.1 * gain * over_samples])[:, 0]
    assert np.linalg.norm(found - true) < 0.05 * np.linalg.norm(true)
