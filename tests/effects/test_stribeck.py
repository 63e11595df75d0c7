"""Stribeck friction falls with speed, and does not rise: one that would rise is Coulomb friction."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from broken_campaigns import FRICTION, campaign
from stepid.effects import resolve
from stepid.effects.base import Moment

(EFFECT,) = resolve(["stribeck_friction"])


def moment(v: float) -> Moment:
    return Moment(0.0, v, 1.0, 0.0, 1.0, 200.0, 1.0, 0.0)


@pytest.mark.parametrize("v", [1e-6, 0.003, 0.01, 0.2])
def test_it_falls_from_breakaway_to_its_level(v: float) -> None:
    falling = (0.2, 0.5, 0.01)
    assert EFFECT.friction(falling, moment(v)) == pytest.approx(0.2 + 0.3 * np.exp(-((v / 0.01) ** 2)))
    assert EFFECT.breakaway(falling, moment(0.0)) == 0.5


@pytest.mark.parametrize("v", [1e-6, 0.003, 0.2])
def test_a_breakaway_below_the_level_makes_coulomb_friction(v: float) -> None:
    rising = (0.2, 0.05, 0.01)
    assert EFFECT.friction(rising, moment(v)) == 0.2
    assert EFFECT.breakaway(rising, moment(0.0)) == 0.2


def test_so_it_is_simulated() -> None:
    made = campaign(1, FRICTION, masses=(0.0, 0.5))
    coulomb = stepid.fit(made, effects=["coulomb_friction"])
    level = coulomb.parameters["coulomb_friction.level"].value
    rising = stepid.EffectModel(name=EFFECT.name, values={"level": level, "breakaway": 0.1 * level, "velocity": 0.02})
    other = coulomb.model.model_copy(update={"effects": (rising,)})
    first, second = stepid.simulate(coulomb.model, made), stepid.simulate(other, made)
    for run in first:
        assert np.max(np.abs(np.asarray(first[run]) - np.asarray(second[run]))) < 1e-7
