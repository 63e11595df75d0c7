"""Starting displacements under friction: the scan leaves the minima that a descent cannot."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.effects import resolve
from stepid.fitting import multistart_sticking
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.multistart_sticking import other_sticking, scan_starts
from stepid.fitting.problem import build, fit_linear, start_local
from stepid.simulation.records import lay_out

TRUTH = stepid.datasets.lab_truth()
ELSEWHERE = multistart_sticking._ELSEWHERE


def test_the_made_up_campaign_settles_at_its_noise() -> None:
    records = lay_out(stepid.datasets.lab_campaign())
    linear = fit_linear(records)
    assert linear is not None
    problem = build(records, resolve(["coulomb_friction"]))
    stuck = minimize(problem, np.append(linear.shared, 0.2), start_local(problem, linear), iterations=12)
    assert stuck is not None
    assert stuck.rms > 2 * TRUTH.noise_rms  # a minimum with another pattern of sticking
    scanned = scan_starts(stuck)
    np.testing.assert_array_equal(scanned[1:], stuck.local[1:])
    found = other_sticking(stuck, tolerance=0.0)
    assert found.rms < 1.03 * TRUTH.noise_rms
    assert found.shared[-1] == pytest.approx(TRUTH.parameters["coulomb_friction.level"], rel=3e-3)


def _held(level: float) -> tuple[Problem, Array, Array]:
    """A start near the best fit, with another level of friction [N]."""
    records = lay_out(stepid.datasets.lab_campaign())
    problem = build(records, resolve(["coulomb_friction"]))
    local = np.zeros((problem.layout.n_run, len(records.runs)))
    local[0] = 1e-6 * np.array([-40.4, 984.2, -626.5, 132.8, -368.2, 535.7, 318.2, 895.8, -346.8, -226.3])
    shared = [0.95583, 0.83556, 216.619, 450.206, 175.512, 12.052, 22.0577, 4.6074, 5.0179, 7.82033, level]
    return problem, np.array(shared), local


@pytest.mark.parametrize("elsewhere", [ELSEWHERE[:1], ELSEWHERE[1:]], ids=["from rest", "kicked"])
def test_a_minimum_that_no_displacement_leaves_is_left(
    elsewhere: tuple[tuple[float, float], ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    stuck = minimize(*_held(0.285))
    assert stuck is not None
    assert stuck.rms > 2 * TRUTH.noise_rms
    monkeypatch.setattr(multistart_sticking, "scan_starts", lambda optimum: optimum.local)
    monkeypatch.setattr(multistart_sticking, "_ELSEWHERE", elsewhere)
    assert other_sticking(stuck, tolerance=0.0).rms < 1.015 * TRUTH.noise_rms


def test_where_a_scan_leads_nowhere_the_other_starts_have_their_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, shared, local = _held(0.285)
    stuck = minimize(problem, shared, local, iterations=2)
    assert stuck is not None
    begun: list[tuple[float, float]] = []

    def none(problem: Problem, shared: Array, local: Array, **_: float) -> None:
        begun.append((shared[-1] / stuck.shared[-1], local[0, 1] / stuck.local[0, 1]))

    monkeypatch.setattr(multistart_sticking, "scan_starts", lambda optimum: 1.5 * optimum.local)
    monkeypatch.setattr(multistart_sticking, "minimize", none)
    assert other_sticking(stuck, tolerance=0.0) is stuck
    assert begun == [pytest.approx(each) for each in ((1.0, 1.5), (1.0, 0.0), (0.98, 1.0), (1.02, 1.0))]


def test_runs_that_all_begin_at_zero_are_scanned_as_far_as_what_is_left() -> None:
    problem, shared, local = _held(0.285)
    at_zero = np.zeros_like(local)
    solved = problem.solve(shared, at_zero)
    assert solved is not None
    cost = float(np.sum(problem.residual(solved) ** 2))
    scanned = scan_starts(Optimum(problem, shared, at_zero, solved, cost, False, 0))
    moved = problem.solve(shared, scanned)
    assert moved is not None
    assert np.sum(problem.residual(moved) ** 2) < 0.6 * cost
    assert np.abs(scanned[0]).max() > 5e-4  # of up to 1 mm


def test_every_trial_finds_its_own_pattern_of_sticking() -> None:
    """From too strong a friction the descent passes other patterns of sticking and reaches the noise."""
    found = minimize(*_held(0.35))
    assert found is not None
    assert found.rms < 1.015 * TRUTH.noise_rms


def test_a_linear_plant_comes_back_as_it_is() -> None:
    records = lay_out(stepid.datasets.lab_campaign())
    linear = fit_linear(records)
    assert linear is not None
    assert other_sticking(linear, tolerance=0.0) is linear
