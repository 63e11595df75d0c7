"""Runs reduced to triangles give the steps and the uncertainties of the whole Jacobian."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hidden.campaigns import make_campaign
from stepid.effects import resolve
from stepid.fitting.correlation import autocorrelations
from stepid.fitting.covariance import uncertain
from stepid.fitting.damped_step import Columns, Linearized
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.problem import build, start_local
from stepid.simulation.simulator import Simulator, Solved

CASES = [
    pytest.param((), "nine", id="no parameter of a run"),
    pytest.param(("coulomb_friction",), "four", id="where each run begins"),
    pytest.param(("flexible_coupling",), "nine", id="many columns"),
    pytest.param(("periodic_disturbance",), "four", id="a phase a run"),
]


def started(names: tuple[str, ...], kind: str) -> tuple[Problem, Solved, np.ndarray, np.ndarray]:
    campaign, _ = make_campaign(5, names, kind=kind, r0=10.0)
    context, effects = prepare(campaign), resolve(tuple(names))
    weight = np.random.default_rng(1).uniform(0.3, 1.0, context.records.size)
    problem = build(context.records.reweighted(weight), effects)
    shared = np.concatenate([context.linear.shared, *(next(iter(e.starts(context.scales))) for e in effects)])
    local = start_local(problem, context.linear)
    solved = problem.solve(shared, local)
    assert solved is not None
    return problem, solved, shared, local


@pytest.mark.parametrize(("names", "kind"), CASES)
def test_a_damped_step_is_that_of_the_whole_jacobian(names: tuple[str, ...], kind: str) -> None:
    problem, solved, begun, _ = started(names, kind)
    r = problem.records
    residual, cost = problem.weigh(solved)
    np.testing.assert_allclose(residual, r.weighted(r.position - solved.reading), atol=1e-15)
    assert cost == pytest.approx(residual @ residual)
    jacobian = problem.jacobian(solved)
    size = np.linalg.norm(jacobian, axis=0)
    size[size == 0] = np.inf
    scaled, damping, n = jacobian / size, 1e-3, int(problem.free.sum())
    whole = np.concatenate([scaled, np.sqrt(damping) * np.eye(size.size)])
    step = np.linalg.lstsq(whole, np.append(residual, np.zeros(size.size)), rcond=None)[0]
    decrease = cost - np.sum((residual - scaled @ step) ** 2)

    steps = problem.simulator.steps(begun)[: begun.size]
    linearized = Linearized(problem, Columns(problem), solved.derivatives, residual, steps)
    shared, local, gain = linearized.step(damping, np.zeros(n, dtype=bool), np.zeros_like(problem.active))
    assert gain == pytest.approx(decrease, rel=1e-8)
    np.testing.assert_allclose(linearized.pull, (jacobian.T @ residual)[:n], rtol=1e-8)
    np.testing.assert_allclose(shared * size[:n], step[:n], rtol=1e-9, atol=1e-12 * np.abs(step).max())
    own = local[problem.active] * np.where(np.isfinite(size[n:]), size[n:], 0.0)
    np.testing.assert_allclose(own, step[n:], rtol=1e-9, atol=1e-12 * np.abs(step).max())


def dense_covariance(optimum: Optimum, floor: float) -> np.ndarray:
    """The same by a singular value decomposition of all samples, and the residual's covariance written out."""
    problem = optimum.problem
    jacobian, residual = problem.jacobian(optimum.solved), problem.residual(optimum.solved)
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0] = 1.0
    u, s, vt = np.linalg.svd(jacobian / scale, full_matrices=False)
    inverse = vt.T * np.where(s > 1e-6 * s[0], 1 / np.maximum(s, 1e-300), 0.0) / scale[:, None]
    left = residual - u @ (u.T @ residual)
    level = max(floor**2, float(left @ left) / (residual.size - s.size))
    total = np.ones(s.size)
    for piece, shares in zip(problem.records.pieces(), autocorrelations(optimum, residual), strict=True):
        for lag, share in enumerate(shares, 1):
            total += 2 * share * np.sum(u[piece][lag:] * u[piece][:-lag], axis=0)
    found: np.ndarray = (inverse * (level * np.maximum(total, 1.0))) @ inverse.T
    return found


@pytest.mark.parametrize(("names", "kind"), CASES)
def test_uncertainties_are_those_of_the_whole_jacobian(names: tuple[str, ...], kind: str) -> None:
    problem, solved, shared, local = started(names, kind)
    exact = replace(problem.records, weight_uncertainty=0.0)
    simulator = Simulator(exact, problem.simulator.effects)
    optimum = Optimum(replace(problem, simulator=simulator), shared, local, solved, 1.0, True, 0)
    floor = 1e-1  # a far larger one than is left: the runs' disagreement does not count
    found, whole = uncertain(optimum, floor).noise, dense_covariance(optimum, floor)
    sigma = np.sqrt(np.maximum(np.diag(whole), 1e-300))
    np.testing.assert_allclose(found / np.outer(sigma, sigma), whole / np.outer(sigma, sigma), atol=1e-6)


def test_derivatives_that_nobody_reads_are_not_simulated(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, _, shared, local = started(("coulomb_friction",), "four")
    derive, calls = problem.simulator.derivatives, []

    def counted(*args: Any) -> tuple[np.ndarray, np.ndarray]:
        calls.append(1)
        return derive(*args)

    monkeypatch.setattr(problem.simulator, "derivatives", counted)
    found = minimize(problem, shared, local, iterations=1)
    assert found is not None
    assert found.iterations == len(calls) == 1
    first = problem.jacobian(found.solved)
    assert len(calls) == 2
    np.testing.assert_array_equal(problem.jacobian(found.solved), first)
    assert len(calls) == 2
