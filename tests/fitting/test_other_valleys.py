"""Ends that no descent leaves, and what does: another rest position of all runs, a stronger mode."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hidden.sets import one
from scattered_campaigns import scattered
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.moves.add import Add
from stepid.diagnosis.selection.proposal import Node, SearchContext
from stepid.effects import CATALOGUE, resolve
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import FitContext, Start
from stepid.fitting.multistart_modes import stronger
from stepid.fitting.multistart_sticking import other_sticking

GAINS = frozenset({"gain"})


def ended(number: int, salt: str, shared: list[float], local: Any) -> tuple[FitContext, Optimum, tuple[float, ...]]:
    """Where a fit of three effects ends on a campaign of the hidden simulator, from where a search had come."""
    campaign, truth = one("triples", number, salt)
    fit = prepare(campaign)
    problem = CandidateFit(fit, resolve(list(truth["effects"]))).coarse
    begun = np.zeros((problem.layout.n_run, len(campaign.experiments)))
    begun[: len(local)] = local
    order = [p.name for e in problem.simulator.effects for p in e.parameters]
    assert len(order) == len(shared) - problem.layout.linear.stop
    found = minimize(problem, np.array(shared), begun, iterations=60)
    assert found is not None
    return fit, found, tuple(truth["parameters"].values())


def test_all_runs_that_stuck_as_far_from_the_rest_position_are_another_end() -> None:
    shared = [2.57588, 875.560, 9.35356, 7.53368, 0.0105103, 1.53171, 7612.53, 6.83063, 0.0129166]
    fit, stuck, true = ended(19, "dev21", shared, [[-391e-6, -730e-6, -387e-6, -1386e-6]])
    assert stuck.cost > 4 * fit.noise_cost
    found = other_sticking(stuck, tolerance=fit.tolerance)
    assert found.cost < fit.noise_cost
    assert found.shared[4:] == pytest.approx(true, rel=0.02)
    assert np.abs(found.local[0] - stuck.local[0]) == pytest.approx(0.3e-3, abs=0.05e-3)


def test_a_faint_mode_that_its_own_start_moves_stands_for_a_strong_one() -> None:
    shared = [2.86266, 668.238, 32.9261, 0.0, 6407.66, 7.71147e-3, 9.80970e-3, 61.1377, 0.166578, 2.51084e-3]
    local = [
        [9.786e-3, -8.907e-3, 14.351e-3, 13.935e-3],
        [-24.116e-3, 42.297e-3, -106.293e-3, -75.573e-3],
        [-44.665e-3, -31.763e-3, -131.312e-3, -167.206e-3],
        [9.90561, -1.78141, 22.1321, 16.3315],
    ]
    fit, stuck, true = ended(3, "dev22", shared, local)
    assert stuck.cost > 30 * fit.noise_cost
    found = stronger(stuck, tolerance=fit.tolerance, iterations=40)  # some 20: rounding, which machines differ in
    assert found.cost < fit.noise_cost
    assert found.shared[4:] == pytest.approx(true, rel=0.02)
    assert stronger(found, tolerance=fit.tolerance) is found  # no better one


@pytest.mark.parametrize(("names", "moving"), [(["flexible_coupling"], False), (["presliding_hysteresis"], True)])
def test_only_a_mode_that_its_own_start_moves_is_tried_stronger(
    names: list[str], moving: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs at rest have none; a memory has no strength of its own."""
    fit = prepare(one("triples", 3, "dev22")[0] if moving else scattered(1))
    fitted = CandidateFit(fit, resolve(names))
    fitted.begin(effect_starts(fit, *names), like=fit.coarse_linear, keep=1, iterations=1)
    assert fitted.best is not None
    monkeypatch.setattr("stepid.fitting.multistart_modes.minimize", None)
    assert stronger(fitted.best, tolerance=fit.tolerance) is fitted.best


def effect_starts(fit: FitContext, name: str) -> list[Start]:
    (effect,) = resolve([name])
    return [Start(fit.coarse_linear.shared, (tuple(effect.starts(fit.scales)[0]),))]


@pytest.mark.parametrize(("name", "looked"), [("free_play", ["modes"]), ("coulomb_friction", ["sticking", "modes"])])
def test_valleys_are_looked_for_once_from_each_end(
    name: str, looked: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    fit = prepare(scattered(1))
    fitted = CandidateFit(fit, resolve([name]))
    fitted.best = first = fit.coarse_linear
    asked: list[str] = []
    better = [fit.linear, fit.linear]  # then none

    def sticking(optimum: Optimum, **_: float) -> Optimum:
        asked.append("sticking")
        return optimum

    def modes(optimum: Optimum, **_: float) -> Optimum:
        asked.append("modes")
        return better.pop() if better else optimum

    monkeypatch.setattr("stepid.fitting.candidate_fit.other_sticking", sticking)
    monkeypatch.setattr("stepid.fitting.candidate_fit.stronger", modes)
    assert fitted.other_valleys()
    assert fitted.best is fit.linear is not first
    assert not fitted.other_valleys()  # it is where they led
    assert asked == looked


def test_starts_are_told_apart_by_what_is_left_once_the_runs_may_differ() -> None:
    """Beside gains that differ by 6 % a force of the right frequency seems to leave more than one that does nothing."""
    campaign, truth = one("perturbed-single-seen", 17, "dev22")
    fit = prepare(campaign)
    plain = CandidateFit(fit, (), GAINS)
    plain.begin([Start(fit.coarse_linear.shared, ())], like=fit.coarse_linear, iterations=20)
    proposals = Add().propose(Node(plain), SearchContext(fit, CATALOGUE, Effort()))
    (periodic,) = [p for p in proposals if p.key[0] == {"periodic_disturbance"}]
    fitted = CandidateFit(fit, periodic.effects, GAINS)
    fitted.begin(list(periodic.starts), like=periodic.like)
    assert fitted.best is not None
    assert fitted.cost < 1.1 * fit.noise_cost < plain.cost / 5
    assert fitted.best.shared[-1] == pytest.approx(truth["parameters"]["periodic_disturbance.frequency"], rel=5e-3)
