"""What runs differ by is drawn for each of them: what goes with the input, a mass or a spring is a law."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from scattered_campaigns import scattered
from stepid.diagnosis.exchangeable import Condition, followed_condition
from stepid.fitting.deviations import with_deviations
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import minimize

MASSES = (0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 0.0, 1.0)
VOLTS = (0.5, -0.4, 0.4, -0.5, 0.5, -0.4, 0.4, -0.5)
WEAKER_BACK = [0.0 if volts > 0 else -0.02 for volts in VOLTS]


def campaign(seed: int = 0, **relative: list[float]) -> stepid.Campaign:
    return scattered(seed, masses=MASSES, volts=VOLTS, **relative)


def asked(of: stepid.Campaign, kind: str) -> Condition:
    """What the deviations of a linear plant follow."""
    context = prepare(of)
    linear = context.linear
    fitted = minimize(with_deviations(linear.problem, [kind]), linear.shared, linear.local)
    assert fitted is not None
    found = followed_condition(fitted, context.floor)
    assert found is not None
    return found


def test_a_gain_that_goes_with_the_direction_of_the_input_is_found() -> None:
    found = asked(campaign(gain=WEAKER_BACK), "gain")
    assert (found.kind, found.words) == ("gain", "the direction of the input")
    assert found.beyond > 5


def test_a_damping_that_goes_with_the_added_mass_is_found() -> None:
    found = asked(campaign(damping=[0.1 * mass for mass in MASSES]), "damping")
    assert (found.kind, found.words) == ("damping", "the added mass")
    assert found.beyond > 4


def test_drawn_deviations_go_with_nothing() -> None:
    rng = np.random.default_rng(11)
    beyond = [asked(campaign(seed, gain=list(0.02 * rng.standard_normal(8))), "gain").beyond for seed in range(25)]
    assert max(beyond) < stepid.Criteria().shape
    assert -0.5 < np.median(beyond) < 1.5  # the largest of three normal deviates is 0.8 in the middle


def test_runs_that_differ_in_nothing_follow_nothing() -> None:
    context = prepare(campaign())
    assert followed_condition(context.linear, context.floor) is None


def test_runs_of_one_condition_follow_nothing() -> None:
    alike = scattered(0, masses=(0.0, 0.0, 0.0), volts=(0.5, 0.5, 0.5), gain=(0.02, -0.01, 0.03))
    assert asked(alike, "gain").beyond == -np.inf


def test_a_weaker_drive_one_way_is_no_scatter() -> None:
    d = stepid.diagnose(campaign(gain=WEAKER_BACK))
    assert d.verdict == "unexplained"
    assert any("that goes with the direction of the input" in reason for reason in d.reasons)


def test_gains_that_scatter_leave_a_linear_model() -> None:
    gains = [0.0, -0.02, 0.012, -0.003, -0.025, 0.008, -0.013, 0.02]
    d = stepid.diagnose(campaign(gain=gains))
    assert d.verdict == "adequate"
    assert d.scatter["gain"].deviation == pytest.approx(np.std(gains, ddof=1), rel=0.05)
