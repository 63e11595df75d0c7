"""How a fit goes on, and when it ends."""

from __future__ import annotations

import numpy as np
import pytest

from hidden.campaigns import make_campaign
from stepid.effects import resolve
from stepid.fitting import decimation
from stepid.fitting.coordinates import Coordinates
from stepid.fitting.cross_validation import held_out_residuals
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.problem import build, start_local
from stepid.simulation.triangles import weigh


@pytest.fixture(scope="module")
def context() -> FitContext:
    return prepare(make_campaign(5, ("quadratic_damping",), kind="four", r0=10.0)[0])


def start(context: FitContext, exponent: float) -> tuple[np.ndarray, float]:
    """A power law of the right force at the speeds that occur, of a wrong exponent."""
    speed = float(np.sqrt(np.mean(context.linear.solved.states[1] ** 2)))
    force = 0.3 * context.scales.damping * speed
    return np.array([*context.linear.shared, force / speed**exponent, exponent]), speed


def test_the_square_of_a_residual_is_the_same_wherever_its_arrays_lie() -> None:
    random, n = np.random.default_rng(3), 1001
    values = random.normal(size=(3, n))
    bounds = np.array([0, 400, n])
    costs = set()
    for shift in range(8):
        room = [np.empty(n + 8)[shift * (i + 1) % 8 :][:n] for i in range(4)]
        for own, value in zip(room, values, strict=False):
            own[:] = value
        costs.add(weigh(*room[:3], bounds, room[3]))
    assert len(costs) == 1


def test_identical_fits_end_alike_to_the_last_bit(context: FitContext) -> None:
    problem = build(context.decimated, resolve(("power_damping",)))
    shared, _ = start(context, 1.3)
    ends = []
    for size in (1, 77, 1503):
        _kept = np.empty(size)  # the next arrays lie elsewhere
        found = minimize(problem, shared, start_local(problem, context.coarse_linear), iterations=6)
        assert found is not None
        ends.append((found.cost, *found.shared))
    assert ends[0] == ends[1] == ends[2]


def test_a_power_moves_along_its_force_at_the_speeds_that_occur(context: FitContext) -> None:
    problem = build(context.decimated, resolve(("power_damping",)))
    shared, _ = start(context, 1.3)
    solved = problem.solve(shared, start_local(problem, context.coarse_linear))
    assert solved is not None
    inner = Coordinates(problem, shared, solved)
    step = np.zeros(int(problem.free.sum()))
    step[-1] = 0.5  # of the exponent alone
    moved = inner.moved(shared, step)
    speed = float(np.sqrt(np.mean(solved.states[1] ** 2)))
    assert moved[-1] == pytest.approx(1.8)
    assert moved[-2] * speed**1.8 == pytest.approx(shared[-2] * speed**1.3)
    slopes = inner.slopes(shared, solved)[0]
    plain = solved.derivatives[0]
    np.testing.assert_allclose(slopes[-2], plain[-2] * shared[-2])
    np.testing.assert_allclose(slopes[-1], plain[-1] - np.log(speed) * shared[-2] * plain[-2])
    assert np.abs(np.corrcoef(slopes[-2], slopes[-1])[0, 1]) < np.abs(np.corrcoef(plain[-2], plain[-1])[0, 1])


def test_a_fit_that_cannot_reach_its_aim_ends(context: FitContext) -> None:
    problem = build(context.decimated, ())
    begin = context.coarse_linear.shared.copy()
    begin[problem.layout.damping] *= 1.5
    local = start_local(problem, context.coarse_linear)
    whole = minimize(problem, begin, local)
    near = minimize(problem, begin, local, aim=1.1 * context.coarse_linear.cost)
    far = minimize(problem, begin, local, aim=0.01 * context.coarse_linear.cost)
    assert whole is not None
    assert near is not None
    assert far is not None
    assert whole.converged
    assert near.cost == whole.cost
    assert not far.converged
    assert far.iterations < whole.iterations


def test_a_fit_without_a_run_is_made_once(context: FitContext, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def counted(*given, **how):
        calls.append(given[0].records.size)
        return minimize(*given, **how)

    monkeypatch.setattr("stepid.fitting.cross_validation.minimize", counted)
    whole = held_out_residuals(context.linear, tolerance=context.tolerance)
    first = len(calls)
    held_out_residuals(context.linear, tolerance=context.tolerance, first=0.4)
    assert whole
    assert first == 2 * len(whole)
    assert len(calls) == first + len(whole)


def test_all_samples_are_kept_where_the_linear_plant_runs_away_on_some(
    context: FitContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = decimation.decimated(context.records, context.linear, 10.0, context.floor)  # s, as if it swung that slowly
    assert few.size < context.records.size
    monkeypatch.setattr(decimation, "minimize", lambda *a, **k: None)
    optimum = decimation.fit_coarsely(few, context.linear)
    assert optimum is context.linear
    assert optimum.problem.records is context.records
