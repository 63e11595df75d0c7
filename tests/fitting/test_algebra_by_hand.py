"""Algebra of a joint fit, its profile limits and its faults, against dense matrices and closed forms."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import stepid
from made_up_evidence import Kept
from stepid.core.base import Array
from stepid.core.estimate import Estimate
from stepid.fitting import profile
from stepid.fitting.absent import Absent, linearized
from stepid.fitting.added_masses import weight_errors, with_added_masses
from stepid.fitting.correlation import Block
from stepid.fitting.covariance import _precision, _triangle
from stepid.fitting.levenberg_marquardt import Problem, _blocked, _held
from stepid.fitting.random_effects import _information
from stepid.fitting.run_fault import _has_size, told
from stepid.simulation.records import Records, lay_out


def test_columns_of_a_run_are_its_own_then_the_shared_ones() -> None:
    rng = np.random.default_rng(1)
    weight = np.array([1.0, 0.5, 2.0, 1.0, 1.0, 0.1, 1.0])
    records = SimpleNamespace(weight=weight, pieces=lambda: [slice(0, 4), slice(4, 7)])
    active = np.array([[True, True], [False, True]])
    problem: Any = SimpleNamespace(free=np.array([True, False, True]), active=active, records=records)
    shared, local = rng.standard_normal((3, 7)), rng.standard_normal((2, 7))
    found = list(Problem.blocks(problem, SimpleNamespace(derivatives=(shared, local))))  # type: ignore[arg-type]
    assert [columns.tolist() for _, columns, _ in found] == [[2, 0, 1], [3, 4, 0, 1]]
    for (piece, _, rows), own in zip(found, (local[:1], local), strict=True):
        w = weight[piece]
        every = np.concatenate([own, shared[[0, 2]]])[:, piece]
        np.testing.assert_allclose(rows, w * (every - (every @ w**2 / np.sum(w**2))[:, None]))
    steep = SimpleNamespace(derivatives=(1e300 * shared, local))
    assert all(np.isinf(rows[-2:]).any() for _, _, rows in Problem.blocks(problem, steep))  # type: ignore[arg-type]


def test_the_triangle_has_the_products_of_the_jacobian() -> None:
    """Two shared parameters, one of each run, and one part of the weights' error that acts as the first shared one."""
    rng = np.random.default_rng(2)
    pieces = [slice(0, 30), slice(30, 55)]
    blocks, jacobian = [], np.zeros((55, 5))
    for run, piece in enumerate(pieces):
        rows, columns = rng.standard_normal((3, piece.stop - piece.start)), np.array([2 + run, 0, 1, 4])
        grown = np.concatenate([np.eye(3), [[0.0, 0.3 + run, 0.0]]])
        blocks.append(Block(piece, columns, rows, grown))
        jacobian[piece, columns] = (grown @ rows).T
    residual, scale = rng.standard_normal(55), np.array([1.0, 2.0, 0.5, 3.0, 0.7])
    optimum: Any = SimpleNamespace(problem=SimpleNamespace(free=np.ones(2), active=np.ones((1, 2))))
    out, pull, left = _triangle(optimum, blocks, scale, residual)
    scaled = jacobian / scale
    np.testing.assert_allclose(out.T @ out, scaled.T @ scaled, atol=1e-12)
    np.testing.assert_allclose(out.T @ pull, scaled.T @ residual, atol=1e-12)
    best = np.linalg.lstsq(scaled, residual, rcond=None)[0]
    assert left == pytest.approx(float(np.sum((residual - scaled @ best) ** 2)))


def test_what_may_differ_is_known_to_half_its_bound_or_to_what_runs_scatter_by(monkeypatch: pytest.MonkeyPatch) -> None:
    active = np.array([[True, False, False], [True, True, True]])
    layout = SimpleNamespace(deviation=lambda kind: ["damping", "gain"].index(kind))
    problem = SimpleNamespace(free=np.array([True, True]), active=active, layout=layout, most=None)
    optimum: Any = SimpleNamespace(problem=problem)
    sizes: dict[str, float] = {}
    monkeypatch.setattr("stepid.fitting.covariance.sizes_of_scatter", lambda _: sizes)
    assert _precision(optimum).tolist() == [0.0] * 6
    problem.most = np.array([[0.5, 0.5, 0.5], [4.0, 0.1, np.inf]])
    bounds = [0.0, 0.0, 4.0, 0.5, 20.0, 0.0]
    assert _precision(optimum).tolist() == bounds
    sizes |= {"damping": 1e-3, "gain": 0.0}  # one run tells no scatter, and nothing is known of what differs by nothing
    assert _precision(optimum).tolist() == bounds
    sizes["gain"] = 0.1  # Student's quantile of two degrees of freedom is 4.303
    known = 0.1 * math.sqrt(2 * 3 / 2) * 4.303 / 1.96
    assert _precision(optimum) == pytest.approx([0.0, 0.0, 4.0, 1 / known, 20.0, 0.0], rel=1e-3)


def test_what_sits_at_a_bound_is_blocked_where_it_is_pushed_outward() -> None:
    lower, upper = np.zeros(5), np.ones(5)
    problem: Any = SimpleNamespace(free=np.array([True, True, True, True, False]), lower=lower, upper=upper)
    shared = np.array([0.0, 0.0, 1.0, 1.0, 0.0])
    assert _blocked(problem, shared, np.array([-1.0, 1.0, 1.0, -1.0])).tolist() == [True, False, True, False]
    assert not _blocked(problem, np.full(5, 0.5), np.array([-1.0, 1.0, 1.0, -1.0])).any()
    own: Any = SimpleNamespace(most=np.array([[2.0, 2.0, 2.0]]), active=np.ones((1, 3), bool))
    assert _held(own, np.array([[2.0, -2.0, 1.9]]), np.array([[1.0, 1.0, 1.0]])).tolist() == [[True, False, False]]


@dataclass
class Parabola:
    """χ² of one parameter: `least` + (x − `best`)²·`bend`, on from the value given."""

    free: Any
    lower: Array
    upper: Array
    best: float = 2.0
    bend: float = 4.0
    least: float = 3.0
    records: Any = None
    layout: Any = field(default_factory=lambda: SimpleNamespace(values=()))


def parabola(monkeypatch: pytest.MonkeyPatch, **changes: Any) -> Any:
    told: dict[str, Any] = {"free": np.array([True]), "lower": np.array([-50.0]), "upper": np.array([50.0])}
    problem = Parabola(**told | changes)

    def minimize(held: Parabola, shared: Array, local: Array, **_: Any) -> Any:
        assert not held.free[0]
        cost = held.least + held.bend * float(shared[0] - held.best) ** 2
        return SimpleNamespace(problem=held, shared=shared, local=local, cost=cost)

    monkeypatch.setattr(profile, "minimize", minimize)
    return Kept(problem=problem, shared=np.array([problem.best]), local=np.zeros(1), cost=problem.least, rms=1e-5)


@pytest.mark.parametrize("distance", [0.3, 1.0, 8.0, -0.3, -8.0])
def test_a_limit_is_where_the_cost_has_grown_by_so_much(monkeypatch: pytest.MonkeyPatch, distance: float) -> None:
    found = profile._limit(parabola(monkeypatch), 0, distance, wanted=9.0)
    assert found == pytest.approx(2.0 + math.copysign(1.5, distance), abs=0.04)


def test_a_bound_before_it_is_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    optimum = parabola(monkeypatch, upper=np.array([2.5]))
    assert profile._limit(optimum, 0, 1.0, wanted=9.0) == 2.5
    assert profile._limit(optimum, 0, -1.0, wanted=9.0) == pytest.approx(0.5, abs=0.04)


def test_a_side_is_open_where_the_cost_hardly_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    flat = parabola(monkeypatch, bend=1e-12, upper=np.array([1e12]))
    assert profile._limit(flat, 0, 1.0, wanted=9.0) is None


@pytest.mark.parametrize("fits", [1, 2])
def test_after_all_tries_the_next_place_is_the_limit(monkeypatch: pytest.MonkeyPatch, fits: int) -> None:
    monkeypatch.setattr(profile, "_TRIES", fits)
    assert profile._limit(parabola(monkeypatch), 0, 0.6, wanted=9.0) == pytest.approx(3.5, abs=0.04)


def limits(monkeypatch: pytest.MonkeyPatch, e: Estimate, **changes: Any) -> Estimate:
    """Profile limits of a parabola whose noise is twice that of white noise."""
    optimum = parabola(monkeypatch, **changes)
    near = SimpleNamespace(level=0.5, excess=np.array([4.0]))
    monkeypatch.setattr(profile, "uncertain", lambda *_: near)
    monkeypatch.setattr(profile, "parameter_names", lambda *_: (("a", "N"),))
    return profile.profiled({"a": e}, optimum, (), 1e-5)["a"]


def test_profile_limits_of_a_parabola_are_its_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    """σ = level·√(excess/bend); what comes of weights and scale is added in squares."""
    sigma = 0.5 * math.sqrt(4.0 / 0.3)
    parts = {"noise": sigma, "weights": 0.3, "scale": 0.4}
    vague = Estimate(value=2.0, uncertainty=math.hypot(sigma, 0.5), unit="N", parts=parts)
    half = 1.96 * math.hypot(sigma, 0.5)
    found = limits(monkeypatch, vague, bend=0.3)
    assert found.limits == pytest.approx((2.0 - half, 2.0 + half), rel=0.02)
    near = limits(monkeypatch, vague, bend=0.3, lower=np.array([0.5]))
    assert near.limits is not None
    assert near.limits[0] == 0.5
    assert near.limits[1] == pytest.approx(2.0 + half, rel=0.02)
    open_ = limits(monkeypatch, vague, bend=1e-12, lower=np.array([-1e12]), upper=np.array([1e12]))
    assert (open_.value, open_.uncertainty) == (2.0, None)


def test_only_what_is_near_a_bound_or_vague_is_profiled(monkeypatch: pytest.MonkeyPatch) -> None:
    sure = Estimate(value=2.0, uncertainty=0.1, unit="N", parts={"noise": 0.1})
    assert limits(monkeypatch, sure) is sure
    assert limits(monkeypatch, sure, lower=np.array([1.8])).limits is not None
    angle = Estimate(value=2.0, uncertainty=3.0, unit="rad", parts={"noise": 3.0})
    assert limits(monkeypatch, angle) is angle


def records_of(position: Array, volts: Array, **more: Any) -> Records:
    time = 0.001 * np.arange(position.size)
    told: dict[str, Any] = {"added_mass": 0.0, "spring": "s", "damper": "d", "starts": "rest"} | more
    run = stepid.Experiment(name="r", time=time, position=position, input=volts, **told)
    return lay_out(stepid.Campaign(name="c", experiments=(run,)))


def fault(kind: str, size: float, *, error: float = 0.0, scatter: float = 0.0, weights: float = np.inf) -> Any:
    layout = SimpleNamespace(mass=lambda _: np.array([2.0, 3.0]), stiffness=slice(0, 1), damping=slice(1, 2))
    records = SimpleNamespace(
        sample_time=[0.01, 0.02], spring=[0, 0], damper=[0, 0], added_mass=[0.5, 1.0], weight_uncertainty=weights
    )
    optimum = SimpleNamespace(problem=SimpleNamespace(layout=layout, records=records), shared=np.array([200.0, 8.0]))
    return SimpleNamespace(kind=kind, size=size, error=error, scatter=scatter, run=1, optimum=optimum)


def test_a_fault_is_told_in_the_unit_that_users_know() -> None:
    of = fault("stiffness", 0.5).optimum
    assert told(of, 1, "stiffness", 0.5) == 100.0
    assert told(of, 1, "damping", -0.25) == -2.0
    assert told(of, 1, "gain", 1.0) == 2.0
    assert told(of, 1, "start_time", 0.03) == 0.03


@pytest.mark.parametrize(("kind", "unit"), [("start_time", 0.02), ("gain", 1.0), ("damping", 1.0)])
def test_a_fault_has_a_size_worth_mentioning(kind: str, unit: float) -> None:
    from stepid.fitting.run_fault import _WORTH

    least = _WORTH[kind] * unit
    assert _has_size(fault(kind, 1.01 * least), 5.0)
    assert not _has_size(fault(kind, 0.99 * least), 5.0)
    assert _has_size(fault(kind, -2 * least, error=0.39 * least), 5.0)
    assert not _has_size(fault(kind, -2 * least, error=0.41 * least), 5.0)
    assert not _has_size(fault(kind, -2 * least, scatter=0.41 * least), 5.0)


def test_a_wrong_mass_is_worth_mentioning_beyond_what_one_weight_is_known_to() -> None:
    """However little or much of the 3 kg that move that is: an error that a weight may have is no fault."""
    assert _has_size(fault("added_mass", 0.026, weights=0.005), 5.0)
    assert not _has_size(fault("added_mass", 0.024, weights=0.005), 5.0)
    assert _has_size(fault("added_mass", 0.26, weights=0.05), 5.0)
    assert not _has_size(fault("added_mass", 0.24, weights=0.05), 5.0)
    assert not _has_size(fault("added_mass", 0.026, error=0.006, weights=0.005), 5.0)


def test_no_weight_is_less_than_none() -> None:
    """By more than 2 % of the 3 kg that move, or than weights are known to: what was not mounted scatters about it."""
    assert _has_size(fault("added_mass", -1.05, weights=0.005), 5.0)
    assert not _has_size(fault("added_mass", -1.07, weights=0.005), 5.0)
    assert _has_size(fault("added_mass", -1.09, weights=0.1), 5.0)
    assert not _has_size(fault("added_mass", -1.11, weights=0.1), 5.0)


def test_errors_of_weights_that_were_found_come_back() -> None:
    runs = tuple(
        records_of(np.zeros(60), np.ones(60), added_mass=mass).runs[0].model_copy(update={"name": f"{mass}"})
        for mass in (0.0, 0.5, 1.5)
    )
    records = lay_out(stepid.Campaign(name="c", experiments=runs, weight_uncertainty=0.005))
    moved = with_added_masses(records, np.array([1.0, -2.0]))
    np.testing.assert_allclose(moved.added_mass, [0.0, 0.505, 1.505 - 2 * 0.005 * math.sqrt(2)])
    np.testing.assert_allclose(weight_errors(moved).found, [1.0, -2.0])


def test_a_deviation_is_known_by_the_weighted_variance_of_its_derivative() -> None:
    rng = np.random.default_rng(5)
    plain = records_of(np.zeros(80), np.ones(80))
    records, slope = replace(plain, weight=rng.uniform(0.2, 3.0, 80)), rng.standard_normal((1, 80))
    simulator = SimpleNamespace(derivatives=lambda *_: (None, slope))
    told = {"records": records, "simulator": simulator, "free": np.array([True]), "active": np.array([[True]])}
    problem = SimpleNamespace(layout=SimpleNamespace(deviations=slice(0, 1)), **told)
    solved = SimpleNamespace(reading=None, states=None)
    optimum: Any = SimpleNamespace(problem=problem, solved=solved, shared=None, local=None)
    expected = float(np.cov(slope, aweights=records.weight**2, ddof=0))
    assert _information(optimum).ravel() == pytest.approx([expected])


def test_derivatives_of_a_row_that_is_taken_away_go_with_it() -> None:
    jacobian, reading = np.arange(12.0).reshape(2, 6), np.array([0.5, -0.5])
    records = SimpleNamespace(position=np.array([1.0, 2.0]), weighted=lambda values: 2 * values)
    fit = {"residual": lambda _: np.zeros(2), "jacobian": lambda _: jacobian, "records": records}
    simulator = SimpleNamespace(readings=lambda _, local: reading[None] if not local[0, 0].any() else None)
    problem = SimpleNamespace(free=np.ones(2, bool), active=np.ones((2, 2), bool), simulator=simulator, **fit)
    base: Any = SimpleNamespace(problem=problem, solved=None, shared=np.zeros(2), local=np.ones((2, 2)))
    residual, left, place = linearized(base, Absent(row=0))
    assert residual.tolist() == [1.0, 5.0]
    assert left.tolist() == jacobian[:, [0, 1, 4, 5]].tolist()  # the global ones, and the other row's
    assert place.tolist() == [0, 1]
