"""Fits without one of their effects."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from hidden.campaigns import make_campaign
from stepid.effects import CATALOGUE
from stepid.fitting.absent import without
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.problem import build, start_local


@cache
def context() -> FitContext:
    return prepare(make_campaign(3, (), kind="four")[0])


@pytest.mark.parametrize("name", [e.name for e in CATALOGUE])
def test_every_effect_can_be_taken_away(name: str) -> None:
    """A plant with none of it can be simulated: the cost without it is foreseen."""
    fit = context()
    effect = next(e for e in CATALOGUE if e.name == name)
    values = effect.faint(tuple(effect.starts(fit.scales)[0]), 0.2)
    problem = build(fit.records, (effect,))
    shared = np.concatenate([fit.linear.shared, values])
    base = minimize(problem, shared, start_local(problem, fit.linear), iterations=3)
    assert base is not None
    own = base.problem.layout.values[0]
    absent = np.array(effect.faint(tuple(map(float, base.shared[own])), 0.0))
    moved, left = without(base, own, absent)
    assert np.isfinite(left)
    assert np.all(moved >= problem.lower)
    assert np.all(moved <= problem.upper)
