"""Inputs that are joined by lines, or smooth, between the samples: against scipy and the hidden reference."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.signal import lsim

import stepid
from exact_plants import COUNTS, EFFECTS, NEW_EFFECTS, PERIOD
from hidden import Run, reference
from stepid.core.samples import course
from stepid.simulation.records import lay_out

N = 240
TIME = PERIOD * np.arange(N)
MASS, STIFFNESS, DAMPING, GAIN, BEFORE = 1.45, 216.0, 6.0, 7.8, 0.1
A = np.array([[0.0, 1.0], [-STIFFNESS / MASS, -DAMPING / MASS]])
B = np.array([[0.0], [GAIN / MASS]])
REST = np.array([GAIN * BEFORE / STIFFNESS, 0.0])
INPUTS = {
    "random": 0.5 * np.random.default_rng(0).standard_normal(N),
    "multisine": 0.3 * np.sum([np.sin(2 * np.pi * f * TIME + f) for f in (0.5, 1.3, 2.9, 5.1)], axis=0),
    "step": np.repeat([BEFORE, 0.5], [10, N - 10]),
}
WAVY = 0.5 * np.sin(np.arange(N) / 9) + 0.02 * np.cumsum(np.random.default_rng(3).standard_normal(N)) + 0.02


def record(volts: np.ndarray, way: str, position: np.ndarray, **changes: object) -> stepid.Experiment:
    fields = {"name": "run", "time": TIME, "position": position, "input": volts, "added_mass": 0.5, "spring": "s"}
    return stepid.Experiment(**{**fields, "damper": "d", "input_before": BEFORE, "input_between": way, **changes})


def simulated(run: stepid.Experiment, effects: dict[str, dict[str, float]] | None = None) -> np.ndarray:
    model = stepid.PlantModel(
        base_mass={"cart": MASS - 0.5},
        stiffness={"s": STIFFNESS},
        damping={"d": DAMPING},
        force_gain=GAIN,
        effects=tuple(stepid.EffectModel(name=n, values=v) for n, v in (effects or {}).items()),
        runs={"run": stepid.RunState()},
    )
    return stepid.simulate(model, stepid.Campaign(name="one", experiments=(run,)))["run"]


@pytest.mark.parametrize("name", INPUTS)
def test_lines_are_what_lsim_joins(name: str) -> None:
    _, exact, _ = lsim((A, B, [[1.0, 0.0]], [[0.0]]), INPUTS[name], TIME, X0=REST)
    ours = simulated(record(INPUTS[name], "lines", exact))
    assert np.abs(ours - exact).max() < 1e-8 * np.ptp(exact)


@pytest.mark.parametrize("name", INPUTS)
def test_smooth_is_the_spline_through_all_samples(name: str) -> None:
    volts = CubicSpline(TIME, INPUTS[name])
    state, exact = REST, [REST[0]]
    for begin, end in pairwise(TIME):
        found = solve_ivp(
            lambda t, y: A @ y + B[:, 0] * volts(t), (begin, end), state, method="DOP853", rtol=1e-12, atol=1e-15
        )
        state = found.y[:, -1]
        exact.append(state[0])
    ours = simulated(record(INPUTS[name], "smooth", np.array(exact)))
    assert np.abs(ours - exact).max() < 1e-8 * np.ptp(exact)


@pytest.mark.parametrize(("ours", "theirs"), [("lines", "straight"), ("smooth", "smooth")])
@pytest.mark.parametrize(
    "names",
    [
        ("coulomb_friction",),
        ("cubic_stiffness",),
        ("free_play",),
        ("presliding_hysteresis",),
        ("actuator_lag",),
        ("input_delay",),
        ("actuator_dead_zone",),
        ("actuator_rate_limit",),
        ("coulomb_friction", "actuator_lag"),
        ("actuator_lag", "actuator_rate_limit"),
        ("actuator_lag", "actuator_dead_zone", "input_delay"),
    ],
)
def test_effects_see_the_input_between_the_samples(names: tuple[str, ...], ours: str, theirs: str) -> None:
    effects = {n: (EFFECTS | NEW_EFFECTS)[n] for n in names}
    run = Run(MASS, STIFFNESS, DAMPING, GAIN, PERIOD, WAVY, effects, input_before=BEFORE, input_between=theirs)
    exact = reference(run)
    off = simulated(record(WAVY, ours, exact), effects) - exact
    assert np.abs(off).max() < 0.5 / COUNTS


def test_a_course_goes_through_its_samples() -> None:
    for way, terms in (("held", 1), ("lines", 2), ("smooth", 4)):
        pieces = course(TIME, WAVY, way)
        assert pieces.shape == (N, terms)
        np.testing.assert_array_equal(pieces[:, 0], WAVY)
        if terms > 1:
            ends = pieces[:-1] @ PERIOD ** np.arange(terms)
            np.testing.assert_allclose(ends, WAVY[1:], atol=1e-12)
            assert not pieces[-1, 1:].any()


def test_records_keep_what_their_inputs_do() -> None:
    held, lines = (record(WAVY, way, WAVY, name=way) for way in ("held", "lines"))
    records = lay_out(stepid.Campaign(name="two", experiments=(held, lines)))
    assert records.coefficients.shape == (2 * N, 2)
    assert not records.coefficients[:N, 1].any()
    assert records.subset([0]).coefficients.shape == (N, 1)
    shifted = records.with_input(np.roll(records.volts, 1))
    np.testing.assert_array_equal(shifted.coefficients[N:], course(TIME, np.roll(records.volts, 1)[N:], "lines"))
    other = records.with_input_between("smooth", [0])
    np.testing.assert_array_equal(other.coefficients[:N], course(TIME, WAVY, "smooth"))
    np.testing.assert_array_equal(other.coefficients[N:, :2], records.coefficients[N:])
    assert [run.input_between for run in other.runs] == ["smooth", "lines"]
