"""Of which candidate a result says by what the runs differ; nothing is searched."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from made_up_evidence import FRICTION, LINEAR, candidate
from stepid import Criteria
from stepid.diagnosis.answer import _differing
from stepid.diagnosis.rule import Answer

DAMPED = candidate(deviations=["damping"])


def evidence(share: float) -> Any:
    """Friction, then a linear plant whose runs differ in damping, which takes this share of the misfit."""
    weighed = [SimpleNamespace(candidate=c) for c in (FRICTION, DAMPED, LINEAR)]
    leads = SimpleNamespace(taken=lambda before, after: share if after is DAMPED else 0.0)
    return SimpleNamespace(weighed=weighed, leads=leads, linear=LINEAR, criteria=Criteria())


@pytest.mark.parametrize(("share", "told"), [(0.9, DAMPED), (0.8, FRICTION)])
def test_where_nothing_is_explained_what_runs_differ_by_is_told_if_it_takes_most(share: float, told: Any) -> None:
    """A coupling that may not be named had hidden damping that differed from run to run, 98 per cent of the misfit."""
    assert _differing(evidence(share), Answer("unexplained", FRICTION, (), ()), LINEAR) is told


def test_conditions_of_what_is_shown_go_before() -> None:
    late = candidate(["coulomb_friction"], deviations=["start_time"])
    assert _differing(evidence(0.9), Answer("unexplained", late, (), ()), LINEAR) is late
    assert _differing(evidence(0.9), Answer("named", FRICTION, (), ()), FRICTION) is FRICTION
