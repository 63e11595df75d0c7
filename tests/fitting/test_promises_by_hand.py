"""What a step promises, how runs scatter, and what is told of a fit, with everything around them made up."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

import stepid
from stepid.core.base import Array
from stepid.fitting import covariance, deviations, left_over, problem, random_effects, run_fault, score_test
from stepid.fitting.coordinates import Coordinates
from stepid.fitting.input_fault import InputFault, changes_throughout
from stepid.fitting.multistart import FitContext
from stepid.fitting.screening import _why_still
from stepid.fitting.tangent import scaled_to_one


def run(volts: Array, **more: Any) -> stepid.Experiment:
    time = 0.01 * np.arange(volts.size)
    told: dict[str, Any] = {"position": 0 * time, "added_mass": 0.0, "spring": "s", "damper": "d"} | more
    return stepid.Experiment(name="r", time=time, input=volts, **told)


@pytest.mark.parametrize("volts", [0.05, 1.0, 20.0])
def test_an_input_that_changes_throughout_does_so_at_any_size(volts: float) -> None:
    t = 0.01 * np.arange(600)
    assert changes_throughout(run(volts * np.sin(3.0 * t)))
    assert not changes_throughout(run(volts * (t > 1.0)))
    assert not changes_throughout(run(0 * t))
    assert not changes_throughout(run(volts * (100 * (t > 1.0) + np.sin(3.0 * t))))  # it covers little of the range


def test_a_run_in_which_nothing_moves_is_told_with_its_command() -> None:
    assert _why_still(run(np.zeros(50))) == "nothing moves in it."
    for volts in (1.0, -2.5):
        assert f"although {abs(volts):g} V is commanded" in _why_still(run(volts * (np.arange(50) > 5)))


def test_nothing_is_scaled_to_nothing() -> None:
    least = np.array([1e-12, 0.0, 1e-13])
    assert scaled_to_one(np.zeros((5, 2)), least[:2]) is None
    assert scaled_to_one(np.full((5, 1), np.inf), least[:1]) is None
    found = scaled_to_one(np.array([[3.0, 0.0, 1e-14], [4.0, 0.0, 0.0]]), least)
    assert found is not None
    assert found[0].tolist() == [[0.6, 0.0, 0.0], [0.8, 0.0, 0.0]]
    assert found[1].tolist() == [5.0, math.inf, math.inf]


def test_a_step_along_one_column_is_that_of_least_squares(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gain p²/g, step p/g, error 1/√g; nothing where hardly any of the column is left."""
    columns = np.array([[2.0, 1.0], [0.0, 3.0]])
    gram = np.array([[4.0, 0.0], [0.0, 1e-14]])

    class Basis:
        finite = True

        def __init__(self, _: object) -> None: ...

        def project(self, _: Array) -> tuple[Array, Array]:
            return np.array([6.0, 1.0]), gram

    monkeypatch.setattr(deviations, "_Basis", Basis)
    any_: Any = None
    gain, value, error = deviations.promised_by(any_, columns)
    assert (gain.tolist(), value.tolist(), error.tolist()) == ([9.0, 0.0], [1.5, 0.0], [0.5, math.inf])
    Basis.finite = False
    assert [part.tolist() for part in deviations.promised_by(any_, columns)] == [[0, 0], [0, 0], [math.inf] * 2]


def test_runs_scatter_about_the_mean_of_those_that_have_it(monkeypatch: pytest.MonkeyPatch) -> None:
    row = {name: i for i, name in enumerate((*deviations.SCATTER, "start_offset", "start_velocity"))}
    active = np.zeros((6, 4), bool)
    active[[0, 2, 4]] = True
    begun = [0.001, -0.002, 0.004, 9.0]
    local = np.array([[0.1, 0.2, 0.6, 9.0], [9.0] * 4, [1.0, 2.0, 5.0, 7.0], [9.0] * 4, begun, [9.0] * 4])
    position = np.array([1.0, 3.0, 2.0, 2.0, 5.0, 5.0, 0.0, 0.0])
    records = SimpleNamespace(
        weight=np.array([1.0, 2.0, 1, 1, 1, 1, 1, 1]), position=position, first=np.arange(0, 8, 2),
        damper=np.array([0, 0, 0, 1]), runs=[None] * 4,
    )  # fmt: skip
    three = np.array([True, True, True, False])
    use = {"start_time": three, "damping": np.ones(4, bool), "start_offset": three}
    monkeypatch.setattr(deviations, "applies", lambda _, kind: use[kind])
    problem = SimpleNamespace(records=records, layout=SimpleNamespace(deviation=row.get), active=active)
    solved = SimpleNamespace(reading=np.zeros(8))
    optimum: Any = SimpleNamespace(problem=problem, local=local, solved=solved)
    found = deviations.scatter_values(optimum)
    assert set(found) == {"rest", "start_time", "damping", "start_offset"}
    np.testing.assert_allclose(found["start_offset"], [*begun[:3], np.nan])  # from the rest position
    rest = np.array([(1 + 4 * 3) / 5, 2.0, 5.0, 0.0])
    np.testing.assert_allclose(found["rest"], rest - rest.mean())
    np.testing.assert_allclose(found["start_time"], [-0.2, -0.1, 0.3, np.nan])
    np.testing.assert_allclose(found["damping"], [1 - 8 / 3, 2 - 8 / 3, 5 - 8 / 3, np.nan])  # one run of the other
    spread = random_effects.deviation_std(found, problem.records.damper)
    assert spread["start_time"] == pytest.approx(float(np.std([0.1, 0.2, 0.6], ddof=1)))
    assert spread["damping"] == pytest.approx(float(np.std([1, 2, 5], ddof=1)))  # one label
    assert spread["start_offset"] == pytest.approx(float(np.sqrt(np.mean(np.square(begun[:3])))))  # about no mean


@pytest.mark.parametrize(
    ("times", "ratio", "means", "colored", "said"),
    [
        (1.1, 1.0, 9.0, None, False),
        (1.3, 1.0, 0.0, None, True),
        (1.1, 1.6, 5.5, None, True),  # slower than white noise, by both
        (1.1, 1.6, 4.5, None, False),
        (1.1, 1.4, 5.5, None, False),  # of 100, five standard deviations are a half
        (1.1, 1.6, 5.5, "ar1", False),
    ],
)
def test_more_than_noise_is_told(
    monkeypatch: pytest.MonkeyPatch, times: float, ratio: float, means: float, colored: str | None, said: bool
) -> None:
    monkeypatch.setattr(left_over, "von_neumann_ratio", lambda *_: (ratio, 100))
    monkeypatch.setattr(left_over, "block_mean_deviate", lambda *_: means)
    monkeypatch.setattr(left_over, "least_floor", lambda _: 0.0)
    problem = SimpleNamespace(records=None, residual=lambda _: None)
    optimum: Any = SimpleNamespace(rms=times * 1e-5, problem=problem, residual=None, solved=None)
    context: Any = SimpleNamespace(floor=1e-5, colored=colored, period=0.5)
    note = left_over.left_over(optimum, context)
    assert (note is not None) is said
    assert note is None or f"{10 * times:.1f} µm where the noise is 10.0 µm" in note


def test_a_start_promises_what_its_change_takes_of_the_residual(monkeypatch: pytest.MonkeyPatch) -> None:
    """Less what the simpler law's own parameters, here a constant, can do: (d·r)²/d·d."""
    residual = np.array([1.0, -1.0, 2.0, -2.0])
    change = np.array([0.5, -0.5, 0.5, -0.5])
    layout = SimpleNamespace(n_run=2, own_states=slice(2, 2), deviations=slice(2, 2))

    class Simulator:
        def __init__(self, *_: object) -> None:
            self.layout = layout

        def readings(self, shared: Array, _: Array) -> Array:
            return seen + 3.0 + np.array([change, -change, 1e9 * change, np.full(4, np.nan)])[: len(shared)]

    monkeypatch.setattr(score_test, "Simulator", Simulator)
    jacobian = np.ones((4, 1))
    problem = SimpleNamespace(layout=layout, jacobian=lambda _: jacobian, residual=lambda _: residual)
    seen = np.array([1.0, 2.0, -4.0, 0.5])  # what the simpler law reads
    solved = SimpleNamespace(reading=seen)
    inner: Any = SimpleNamespace(problem=problem, solved=solved, local=np.zeros((2, 1)))
    context: Any = SimpleNamespace(decimated=SimpleNamespace(weighted=lambda values: values))
    start: Any = SimpleNamespace(linear=np.zeros(1), values=(np.zeros(1),))
    found = score_test.promises(context, inner, (), [start] * 4)
    assert found[:2] == pytest.approx([3.0**2 / 1.0, 0.0])
    assert found[2] == 0.0  # it asks for hardly any of the change
    assert found[3] == math.inf
    assert score_test.promises(context, inner, (), []) == []
    jacobian[0] = np.inf
    assert score_test.promises(context, inner, (), [start] * 2) == [math.inf] * 2


class Made:
    """Something made up that can be referenced weakly."""

    def __init__(self, **fields: Any) -> None:
        self.__dict__.update(fields)


@pytest.mark.parametrize(
    ("gain", "left", "square", "told"),
    [
        (1.05, 1.04, 0.95, True),
        (0.95, 1.01, 0.95, False),  # errors of noise gain as much
        (1.05, 1.06, 0.95, False),  # they do not explain it
        (1.05, 1.04, 1.05, False),  # they are larger than their uncertainty makes them in one case of a hundred
    ],
)
def test_weights_explain_what_is_left_where_their_errors_are_likely(
    monkeypatch: pytest.MonkeyPatch, gain: float, left: float, square: float, told: bool
) -> None:
    rare = float(chi2.ppf(0.99, 8))
    found = np.full(8, math.sqrt(square * rare / 8))
    likely = Made(rms=left * 1e-5, problem=Made(records="found"), cost=7e-10)
    linear: Any = Made(rms=1e-5, problem=Made(records="known"), cost=7e-10 + (square + gain) * rare * 1e-10)
    monkeypatch.setattr(covariance, "most_likely", lambda *_: likely)
    monkeypatch.setattr(covariance, "weight_errors", lambda r: Made(found=found if r == "found" else np.zeros(8)))
    assert covariance.by_weights(linear, 1e-5) is (likely if told else None)


def test_noise_in_the_race_scatters_above_its_cost() -> None:
    context: Any = Made(decimated=Made(size=450), noise_cost=2.0)
    assert FitContext.noise_limit.func(context) == pytest.approx((1.05 + 3 / 30) ** 2 * 2.0)


@pytest.mark.parametrize(
    ("kind", "size", "cost", "extreme", "left", "others", "explained"),
    [
        ("stiffness", 0.2, 26.0, True, 1.0, 9.0, True),
        ("stiffness", 0.2, 24.0, True, 1.0, 9.0, False),  # of the run with the largest input a bent curve asks it, too
        ("stiffness", 0.2, 26.0, True, 1.2, 9.0, False),
        ("damping", 0.2, 26.0, True, 1.0, 9.0, False),
        ("gain", 0.2, 26.0, True, 1.0, 9.0, False),
        ("gain", 1.0, 9.0, True, 1.0, 9.0, True),  # twice is a wrong scale
        ("sensor_drift", 0.2, 9.0, True, 1.0, 9.0, True),
        ("stiffness", 0.2, 9.0, False, 1.0, 9.0, True),
        ("stiffness", 0.2, 9.0, False, 2.6, 9.0, True),
        ("stiffness", 0.2, 9.0, False, 2.8, 9.0, False),
        ("stiffness", 0.2, 9.0, False, 2.6, 8.0, False),  # another run's fault does nearly as well
    ],
)
def test_a_fault_explains_what_is_missing(
    monkeypatch: pytest.MonkeyPatch,
    kind: str,
    size: float,
    cost: float,
    extreme: bool,
    left: float,
    others: float,
    explained: bool,
) -> None:
    """With one sample and a floor of one: the cost is in squares of the floor."""
    monkeypatch.setattr(run_fault, "is_witness", lambda *_, beside: extreme)
    monkeypatch.setattr(run_fault, "noise_cost", lambda *_: 1.1)
    found: Any = Made(kind=kind, size=size, cost=left, run=0)
    optimum: Any = Made(cost=cost, problem=Made(records=Made(weighed_size=1.0), simulator=Made(effects=())))
    rival: Any = Made(cost=others)
    assert run_fault._explains(found, optimum, [rival], 1.0) is explained


@pytest.mark.parametrize("every", [True, False])
def test_the_remedy_of_an_input_names_every_run_or_these(every: bool) -> None:
    fault = InputFault(runs=("a", "b"), all_runs=every, way="lines", said=("held",), evidence=9.0)
    assert fault.remedy.startswith(f'Set input_between="lines" for {"every run" if every else "these runs"},')
    assert fault.words.startswith("The input of runs 'a', 'b' is plainly joined by straight lines")
    assert "records say 'held'" in fault.words


def test_phases_are_read_off_by_least_squares() -> None:
    """Of a reading m + a cos φ + b sin φ the phase is that of the best (cos φ, sin φ), whatever their size."""
    rng = np.random.default_rng(1)
    middle, cosine, sine = rng.standard_normal((3, 12))
    phases = np.array([0.7, -2.2])
    of_run = np.repeat(phases, 6)
    position = middle + 1.3 * (cosine * np.cos(of_run) + sine * np.sin(of_run))

    def readings(_: Array, local: Array) -> Array:
        angle = np.repeat(local[:, 0], 6, axis=1)
        return middle + cosine * np.cos(angle) + sine * np.sin(angle)

    records = Made(weighted=lambda values: values, position=position, pieces=lambda: [slice(0, 6), slice(6, 12)])
    made: Any = Made(simulator=Made(records=records, readings=readings))
    found = problem._read_phases(made, np.zeros(1), np.zeros((1, 2)), 0)
    np.testing.assert_allclose(found, [phases])


def test_an_interval_takes_the_scatter_of_runs_times_students_quantile(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of it is √(1.96² (σ_noise² + σ_weights²) + t² σ_runs²); without scatter 1.96 σ is told by σ alone."""
    records = SimpleNamespace(scale_uncertainty=0.0)
    optimum: Any = SimpleNamespace(
        problem=SimpleNamespace(free=np.array([True, True]), records=records), shared=np.array([200.0, 8.0])
    )
    noise, weights, runs = np.array([3.0, 0.3]), np.array([2.0, 0.4]), np.array([1.5, 0.0])
    near = SimpleNamespace(noise=np.diag(noise**2), weights=np.diag(weights**2), open=np.zeros(2, bool))
    monkeypatch.setattr(covariance, "centered", lambda made: made)
    monkeypatch.setattr(covariance, "uncertain", lambda *_: near)
    monkeypatch.setattr(covariance, "mean_of_runs", lambda _: np.eye(2))
    monkeypatch.setattr(covariance, "between_runs", lambda _: (np.diag(runs**2), np.array([4.3, 1.96])))
    monkeypatch.setattr(covariance, "parameter_names", lambda *_: (("stiffness", "N/m"), ("damping", "N·s/m")))
    monkeypatch.setattr(covariance, "mass_is_held", lambda _: False)
    found, correlation = covariance.estimates(optimum, (), 1e-5)
    assert found["stiffness"].uncertainty == pytest.approx(math.sqrt(9.0 + 4.0 + 2.25))
    half = math.hypot(1.96 * math.hypot(3.0, 2.0), 4.3 * 1.5)
    assert found["stiffness"].limits == pytest.approx((200.0 - half, 200.0 + half))
    assert (found["damping"].uncertainty, found["damping"].limits) == (pytest.approx(0.5), None)
    np.testing.assert_allclose(correlation, np.eye(2))


@pytest.mark.parametrize("coefficient", [0.3, 30.0])
def test_a_power_moves_along_its_force_at_the_motions_speed(coefficient: float) -> None:
    """By the exponent at c·vᵖ held: ∂/∂p − ln v · c ∂/∂c."""
    effect, solved = SimpleNamespace(power=(0, 1)), SimpleNamespace(states=np.full((2, 9), 0.2))
    problem: Any = SimpleNamespace(
        simulator=SimpleNamespace(effects=(effect,)), layout=SimpleNamespace(values=(slice(0, 2),)),
        free=np.ones(2, bool), lower=np.full(2, -99.0), upper=np.full(2, 99.0),
    )  # fmt: skip
    shared = np.array([coefficient, 1.5])
    along: Any = SimpleNamespace(derivatives=(np.array([[2.0], [7.0]]), None))
    made = Coordinates(problem, shared, solved)  # type: ignore[arg-type]
    slopes = made.slopes(shared, along)[0]
    assert slopes.ravel() == pytest.approx([2 * coefficient, 7 - math.log(0.2) * 2 * coefficient])
    c, p = made.moved(shared, np.array([0.0, 0.4]))
    assert c * 0.2**p == pytest.approx(coefficient * 0.2**1.5)
