"""The race of one set's starts: work that no clock measures, and patience with starts that seem to show little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from search_nodes import FRICTION, node, prepared
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.moves.add import Add
from stepid.diagnosis.selection.proposal import SearchContext
from stepid.effects import CATALOGUE, resolve
from stepid.fitting.candidate_fit import CandidateFit, is_short
from stepid.fitting.multistart import Start
from stepid.fitting.problem import start_local


def test_work_is_steps_times_states_and_the_same_each_time() -> None:
    fit = prepared("two")
    effects = resolve(["actuator_lag", "quadratic_damping"])
    start = Start(fit.coarse_linear.shared, ((0.01,), (20.0,)))
    works = []
    for _ in range(2):
        fitted = CandidateFit(fit, effects)
        assert fitted.work == 0
        fitted.begin([start], like=fit.coarse_linear, iterations=2)
        works.append(fitted.work)
        assert fitted.work == 3 * fitted.coarse.simulator.taken  # position, velocity and the lag's own
        fitted.run(iterations=2)
        assert fitted.work > works[-1]
    assert works[0] == works[1] > fit.decimated.size


def test_threads_take_the_same_steps() -> None:
    fit = prepared("friction")
    friction = node(fit, FRICTION).effects
    taken = []
    for workers in (1, 2):
        problem = CandidateFit(fit, friction).coarse
        simulator = type(problem.simulator)(fit.decimated, friction, workers=workers)
        shared = np.repeat(np.append(fit.coarse_linear.shared, 0.2)[None], 3, axis=0)
        simulator.readings(shared, np.repeat(start_local(problem, fit.coarse_linear)[None], 3, axis=0))
        taken.append(simulator.taken)
    assert taken[0] == taken[1] > 0


def test_fits_are_short_up_to_a_twentieth_of_a_second() -> None:
    assert is_short(1e5)
    assert not is_short(1e6)


@pytest.mark.parametrize("keep", [1, 2])
def test_patience_gives_as_many_starts_their_steps_as_are_kept(keep: int, monkeypatch: pytest.MonkeyPatch) -> None:
    fit = prepared("two")
    base = node(fit, FRICTION)
    proposals = Add().propose(base, SearchContext(fit, CATALOGUE, Effort()))
    (stop,) = [p for p in proposals if "end_stop" in p.key[0]]
    ways = []
    for patient in (False, True):
        fitted = CandidateFit(fit, stop.effects)
        runs: list[float] = []
        monkeypatch.setattr(fitted, "_reaches", lambda *given: [stop.like.cost] * len(stop.starts))  # nothing
        monkeypatch.setattr(fitted, "_try", lambda *given, runs=runs: runs.append(given[-1]))
        fitted.begin(list(stop.starts), like=stop.like, keep=keep, iterations=1, patient=patient)
        ways.append(runs)
    impatient, patient_runs = ways
    assert len(impatient) == 1  # none shows much
    assert patient_runs == [np.inf] * keep  # and none has to aim below another


def test_a_step_no_longer_matters_beside_what_is_left_above_the_floor() -> None:
    fit = prepared("two")
    noise = fit.records.weighed_size * fit.floor**2
    assert fit.linear.cost > 10 * noise
    assert fit.slight(fit.linear) == pytest.approx(0.003 * (fit.linear.cost - noise))
    assert fit.slight(replace(fit.linear, cost=noise)) == fit.tolerance


@pytest.mark.parametrize(("cost", "leads"), [(0.5, True), (3.0, False)])
def test_what_has_ended_above_the_noise_goes_on_from_the_best_end_of_another_start(
    cost: float, leads: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A start that lies behind after a few steps may lead further: an end stop's deeper one did."""
    fit = prepared("two")
    fitted = CandidateFit(fit, node(fit, FRICTION).effects)
    ends = [replace(fit.coarse_linear, cost=c * fit.coarse_linear.cost, converged=True) for c in (1.0, 2.0, 4.0, cost)]
    best, behind, last, further = ends
    like = replace(best, cost=3.5 * best.cost)  # what leaves more leads nowhere
    tried = iter([last, best, behind, last])
    monkeypatch.setattr("stepid.fitting.candidate_fit.minimize", lambda *_, **__: next(tried))
    for _ in range(4):
        fitted._try(fitted.coarse, best.shared, best.local, like, 1, np.inf)
    assert fitted.best is best
    begun = []

    def go_on(problem: object, begun_from: object, **_: object) -> object:
        begun.append(begun_from)
        return further if begun_from is behind else begun_from

    monkeypatch.setattr("stepid.fitting.candidate_fit._go_on", go_on)
    fitted.best = replace(best, converged=False)
    unfinished = fitted.best
    fitted.run(iterations=3, others=True)
    assert begun == [unfinished]  # it has not ended yet
    fitted.best = best
    fitted.run(iterations=3)
    assert begun == [unfinished]  # nor is it asked for
    for _ in range(2):
        fitted.run(iterations=3, others=True)
        assert begun == [unfinished, behind]  # once
        assert fitted.best is (further if leads else best)
