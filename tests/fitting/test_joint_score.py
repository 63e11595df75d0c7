"""Scores of several effects together: least squares that a plain solution confirms, starts that lead to the truth."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np
import pytest

from broken_campaigns import campaign
from stepid.effects import CATALOGUE, Effect, resolve
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.fit import prepare
from stepid.fitting.joint_score import JointScore, ScoredSet
from stepid.fitting.multistart import FitContext, Start
from stepid.fitting.score_test import _fitted, columns, score
from stepid.fitting.tangent import Tangent

SEED = 1
HIDDEN = {"free_play": {"gap": 5e-4}, "coulomb_friction": {"level": 0.2}}
THREE = HIDDEN | {"cubic_stiffness": {"coefficient": 2e5}}


def prepared(effects: Mapping[str, Mapping[str, float]]) -> FitContext:
    return prepare(campaign(SEED, effects, masses=(0.0, 0.5, 1.5)))


def apart(one: Effect, other: Effect) -> bool:
    return one.name != other.name


def score_of(fit: FitContext, catalogue: tuple[Effect, ...] = CATALOGUE) -> JointScore:
    return JointScore(Tangent(fit.coarse_linear), columns(fit, catalogue), apart=apart)


def scored(fit: FitContext, size: int, catalogue: tuple[Effect, ...] = CATALOGUE, count: int = 3) -> list[ScoredSet]:
    return score_of(fit, catalogue).sets(size, count)


def unseen(fit: FitContext, count: int) -> float:
    """By how much more than so many coefficients leave they would leave of samples that they were not fitted to."""
    return (1.0 - count / Tangent(fit.coarse_linear).samples) ** -2


def names(found: ScoredSet) -> set[str]:
    return {e.name for e in found.effects}


@pytest.fixture(scope="module")
def two() -> FitContext:
    return prepared(HIDDEN)


def test_what_a_pair_leaves_is_the_least_squares_solution(two: FitContext) -> None:
    """Of each start of the one with each of the other: friction may hold a cart at rest, or not."""
    one, other = resolve(["coulomb_friction", "cubic_stiffness"])
    found = scored(two, 2, (one, other))[0]
    tangent, shares = Tangent(two.coarse_linear), []
    for pair in product(columns(two, (one,)), columns(two, (other,))):
        both = np.column_stack([tangent.beyond(column.responses) for column in pair])
        plain = tangent.left - both @ np.linalg.lstsq(both, tangent.left, rcond=None)[0]
        shares.append(float(plain @ plain) / float(tangent.left @ tangent.left))
    assert len(shares) == 2
    assert found.left == pytest.approx(min(shares) * unseen(two, 2), rel=1e-6)


def test_a_pair_leaves_no_more_than_either_alone(two: FitContext) -> None:
    of_any_sign = resolve(["cubic_stiffness", "quadratic_stiffness", "position_dependent_damping", "sensor_drift"])
    alone: dict[str, float] = {}
    for one in score(two.coarse_linear, columns(two, of_any_sign)):
        alone[one.effect.name] = min(one.left, alone.get(one.effect.name, np.inf))
    pairs = scored(two, 2, of_any_sign, count=1)
    assert len(pairs) == 6
    for pair in pairs:
        least = min(alone[name] for name in names(pair)) / two.coarse_linear.cost
        assert pair.inner == pytest.approx(least * unseen(two, 1), rel=1e-6)
        assert pair.left <= least * unseen(two, 3) * (1 + 1e-9)  # a drift has two


def test_the_least_comes_first_and_no_set_has_more_starts_than_asked(two: FitContext) -> None:
    found = scored(two, 2, count=2)
    left = [s.left for s in found]
    assert left == sorted(left)
    counts = [frozenset(names(s)) for s in found]
    assert max(counts.count(own) for own in counts) == 2
    assert all(len(own) == 2 for own in counts)


def test_effects_that_may_not_stand_beside_each_other_do_not(two: FitContext) -> None:
    table, tangent = columns(two, CATALOGUE), Tangent(two.coarse_linear)
    assert JointScore(tangent, table, apart=lambda a, b: False).sets(2, 1) == []
    assert JointScore(tangent, [], apart=apart).sets(2, 1) == []


def test_a_law_of_the_wrong_sign_is_no_start(two: FitContext) -> None:
    for pair in scored(two, 2):
        for effect, values in zip(pair.effects, pair.values, strict=True):
            assert not effect.dry or values[0] > 0


@pytest.mark.parametrize("hidden", [HIDDEN, THREE], ids=["two effects", "three effects"])
def test_the_start_of_the_true_set_leads_to_the_noise(hidden: Mapping[str, Mapping[str, float]]) -> None:
    fit = prepared(hidden)
    mine = [s for s in scored(fit, len(hidden)) if names(s) == set(hidden)]
    assert mine
    candidate = CandidateFit(fit, mine[0].effects)
    starts = [Start(score_of(fit).adapted(s), s.values) for s in mine if s.effects == mine[0].effects]
    candidate.begin(starts, like=fit.coarse_linear)
    candidate.run(iterations=20)
    assert candidate.cost < fit.noise_limit
    for effect, place in zip(mine[0].effects, candidate.coarse.layout.values, strict=True):
        assert candidate.best is not None
        size = candidate.best.shared[place][0]
        assert size == pytest.approx(next(iter(hidden[effect.name].values())), rel=0.1)


@pytest.mark.parametrize("count", [1, 2])
def test_what_columns_take_is_the_projection_on_them(count: int) -> None:
    rng = np.random.default_rng(5)
    part, residual = rng.standard_normal((30, count)), rng.standard_normal(30)
    part /= np.linalg.norm(part, axis=0)
    gain, coefficients = _fitted(part, residual)
    expected, (left,) = np.linalg.lstsq(part, residual)[:2]
    assert coefficients == pytest.approx(expected)
    assert gain == pytest.approx(residual @ residual - left)
