"""Releases that dry friction stops: each number of half swings is a minimum of its own; a fit walks to the best."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.effects import resolve
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.multistart_sticking import other_turns
from stepid.fitting.problem import start_local

RATE, LEVEL, NOISE = 10.0, 1.0, 10e-6  # rad/s, F/m [m/s²] and m
STARTS = (0.115, 0.128, 0.142)  # m; they stop after 6, 6 and 7 half swings


def _decay(begin: float, time: Array) -> Array:
    """Closed form of a release under Coulomb friction alone: half cosines, each 2 F/k smaller (Den Hartog 1931)."""
    out, drop = np.empty_like(time), LEVEL / RATE**2
    for i, t in enumerate(time):
        place, half = begin, math.floor(RATE * t / math.pi)
        for _ in range(half):
            if abs(place) <= drop:
                break
            place = -place + math.copysign(2 * drop, place)
        center = math.copysign(drop, place)
        moves = abs(place) > drop
        out[i] = center + (place - center) * math.cos(RATE * t - half * math.pi) if moves else place
    return out


@pytest.fixture(scope="module")
def releases() -> stepid.Campaign:
    random, time = np.random.default_rng(1), np.arange(600) * 5e-3
    return stepid.Campaign(
        name="releases",
        experiments=tuple(
            stepid.Experiment(
                name=f"from {begin * 1e3:.0f} mm",
                time=time,
                position=_decay(begin, time) + NOISE * random.standard_normal(time.size),
                input=np.zeros_like(time),
                added_mass=0.0,
                spring="s",
                damper="d",
                starts="motion",
            )
            for begin in STARTS
        ),
    )


@pytest.fixture(scope="module")
def fit(releases: stepid.Campaign) -> FitContext:
    return prepare(releases)


def _ended(fit: FitContext, level: float) -> Optimum:
    """Where a descent ends that begins at a level of friction."""
    problem = CandidateFit(fit, resolve(["coulomb_friction"])).coarse
    shared = np.append(fit.coarse_linear.shared, level)
    found = minimize(problem, shared, start_local(problem, fit.coarse_linear), iterations=40)
    assert found is not None
    return found


@pytest.mark.parametrize("level", [0.3, 0.75, 1.0, 2.0])
def test_the_number_of_half_swings_is_found_from_another(fit: FitContext, level: float) -> None:
    found = other_turns(_ended(fit, level), tolerance=fit.tolerance)
    assert found.cost < fit.noise_limit
    assert found.shared[-1] == pytest.approx(LEVEL, rel=1e-3)


@pytest.mark.parametrize("level", [0.3, 0.75, 1.0, 2.0])
def test_no_descent_leads_there_beside_the_damping_of_the_linear_plant(fit: FitContext, level: float) -> None:
    assert _ended(fit, level).cost > 1e3 * fit.noise_limit


def test_the_best_comes_back_as_it_is(fit: FitContext) -> None:
    best = _ended(fit, 0.6 * LEVEL)
    assert best.cost < fit.noise_limit
    assert other_turns(best, tolerance=fit.tolerance) is best


def test_a_model_without_dry_friction_comes_back_as_it_is(fit: FitContext) -> None:
    assert other_turns(fit.coarse_linear, tolerance=fit.tolerance) is fit.coarse_linear


def test_runs_that_do_not_stop_have_nothing_to_count(fit: FitContext, monkeypatch: pytest.MonkeyPatch) -> None:
    faint = _ended(fit, 0.3)
    faint.solved.states[1][faint.solved.states[1] == 0] = 1e-9
    monkeypatch.setattr("stepid.fitting.multistart_sticking.minimize", None)
    assert other_turns(faint, tolerance=0.0) is faint


def test_a_single_effect_that_runs_on_is_walked_once_from_each_end(
    fit: FitContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    fitted = CandidateFit(fit, resolve(["coulomb_friction"]))
    fitted.best = _ended(fit, 2.0)
    asked: list[Optimum] = []

    def none(optimum: Optimum, **_: float) -> Optimum:
        asked.append(optimum)
        return optimum

    with monkeypatch.context() as patched:
        patched.setattr("stepid.fitting.candidate_fit.other_turns", none)
        for others in (False, True, True):
            fitted.run(iterations=5, others=others)
    assert len(asked) == 1
    fitted._turned_from = None
    fitted.run(iterations=5, others=True)
    assert fitted.cost < fit.noise_limit
