"""Single steps of affine plants against scipy's matrix exponential and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from stepid.effects import resolve
from stepid.simulation.exact import FullStep, exponential
from stepid.simulation.flow import advance, linearize
from stepid.simulation.law import DAMPING, FIRST, GAIN, LENGTH, MASS, STIFFNESS, VOLTS, Law
from stepid.simulation.series import along, crossing, series
from stepid.simulation.stretch import Stretch

RATE, DECAY = 14.0, 1.5  # rad/s and 1/s, of a free swing
LOST = np.array([[0.0, 1.0], [-(RATE**2 + DECAY**2), -2 * DECAY]])


def lane_table(law: Law, values: tuple[float, ...], lanes: int) -> np.ndarray:
    """One plant on many lanes."""
    table = np.zeros((law.n_rows, lanes))
    table[[MASS, STIFFNESS, DAMPING, GAIN, VOLTS, LENGTH]] = np.array([1.2, 210.0, 6.0, 8.0, 0.4, 0.009])[:, None]
    table[FIRST:] = np.array(values)[:, None]
    return table


def test_exponentials_and_their_integrals_are_scipys() -> None:
    rng = np.random.default_rng(3)
    stack = rng.normal(size=(40, 3, 3)) * rng.choice([0.05, 1.0, 6.0], size=(40, 1, 1))
    whole, mean = exponential(stack)
    for a, phi, gamma in zip(stack, whole, mean, strict=True):
        both = expm(np.block([[a, np.eye(3)], [np.zeros((3, 6))]]))
        size = np.abs(both).max()
        np.testing.assert_allclose(phi, both[:3, :3], rtol=1e-11, atol=1e-12 * size)
        np.testing.assert_allclose(gamma, both[:3, 3:], rtol=1e-11, atol=1e-12 * size)


@given(st.floats(0.0, 1.0), st.floats(-1e-2, 1e-2), st.floats(-0.3, 0.3))
def test_a_series_is_the_exact_path_at_any_moment(share: float, x: float, v: float) -> None:
    length, z = np.array([0.05]), np.array([[x], [v]])
    terms = series(LOST[:, :, None], LOST @ z, length)
    assert terms is not None
    there = z + along(terms, share * length)
    np.testing.assert_allclose(there, expm(LOST * share * 0.05) @ z, rtol=0, atol=1e-13)


def test_a_motion_too_fast_for_its_step_has_no_series() -> None:
    assert series(1e4 * LOST[:, :, None], LOST @ np.array([[1e-2], [0.0]]), np.array([0.05])) is None


@given(st.floats(0.02, 0.98), st.sampled_from([-1.0, 1.0]))
def test_a_swing_turns_where_its_closed_form_does(share: float, side: float) -> None:
    # v(t) = e^(−σt) sin(ω (t* − t)) is zero at t*; the stretch ends before the next reversal
    length = np.array([0.9 * np.pi / RATE])
    turn = share * length
    v = side * np.sin(RATE * turn)
    slope = -side * (DECAY * np.sin(RATE * turn) + RATE * np.cos(RATE * turn))
    x = -(slope + 2 * DECAY * v) / (RATE**2 + DECAY**2)
    z = np.array([x, v])
    terms = series(LOST[:, :, None], LOST @ z, length)
    assert terms is not None
    end = (z + along(terms, length))[1]
    at = crossing(side * z[1], side * terms[:, 1], length, side * end)
    np.testing.assert_allclose(at, turn, rtol=0, atol=1e-11)


@pytest.mark.parametrize("lag", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize("fineness", [0.25, 1.0])
def test_a_lag_beside_a_curved_spring_is_followed_however_fast(lag: float, fineness: float) -> None:
    law = Law(resolve(("cubic_stiffness", "actuator_lag")), fineness)
    table = lane_table(law, (2e5, lag), 1)
    z = np.array([[0.004], [0.2], [0.0]])  # the drive has just been switched on

    def rates(t: float, y: np.ndarray) -> list[float]:
        force = 8.0 * y[2] - 210.0 * y[0] - 6.0 * y[1] - 2e5 * y[0] ** 3
        return [y[1], force / 1.2, (0.4 - y[2]) / lag]

    expected = solve_ivp(rates, (0, 0.009), z[:, 0], method="Radau", rtol=1e-10, atol=1e-13).y[:, -1]
    found = advance(law, table, z)[:, 0]
    assert abs(found[0] - expected[0]) < (5e-6 if fineness < 1 else 2e-7)
    assert abs(found[2] - expected[2]) < 1e-6


def test_a_lag_that_has_followed_stays_where_it_is() -> None:
    """However stiff: no rounding error grows in it."""
    law = Law(resolve(("cubic_stiffness", "actuator_lag")), 0.25)
    table = lane_table(law, (2e5, 1e-5), 1)
    z = np.array([[0.004], [0.0], [0.4]])
    for _ in range(500):
        z = advance(law, table, z)
    assert z[2, 0] == 0.4
    assert abs(z[0, 0]) < 0.03


@pytest.mark.parametrize("lag", [3e-2, 1e-3, 1e-5])
def test_within_a_step_it_is_where_a_shorter_step_leads(lag: float) -> None:
    """However fast the lag: by its series, or by the exponential where that would need too many terms."""
    law = Law(resolve(("coulomb_friction", "actuator_lag")))
    table = lane_table(law, (0.6, lag), 50)
    z = np.random.default_rng(6).normal(size=(3, 50)) * np.array([0.01, 0.1, 0.2])[:, None]
    group, left = np.zeros(50, dtype=np.intp), table[LENGTH]
    sign = np.where(z[1] < 0, -1.0, 1.0)
    blank, none, moving = np.zeros(50), np.ones((0, 50)), np.ones(50)
    way = Stretch(law, table, z, blank, left, sign, none, moving, FullStep(law, table[:, :1]), group)
    assert (way.terms is None) == (lag == 1e-5)
    shorter = table.copy()
    shorter[LENGTH] *= 0.37
    expected = FullStep(law, shorter[:, :1])(group, shorter, z, sign, none)
    np.testing.assert_allclose(way.at(0.37 * left), expected, rtol=1e-9, atol=1e-13)


@pytest.mark.parametrize(
    ("names", "values"),
    [
        (("coulomb_friction",), (0.6,)),
        (("free_play",), (0.004,)),
        (("coulomb_friction", "actuator_lag"), (0.6, 0.03)),
    ],
)
def test_the_derivative_of_a_step_is_that_of_its_differences(names: tuple[str, ...], values: tuple[float, ...]) -> None:
    """Exact where nothing happens within the step; the events are differences themselves."""
    law = Law(resolve(names))
    rng = np.random.default_rng(5)
    lanes = 200
    table = lane_table(law, values, lanes)
    z = rng.normal(size=(law.n_states, lanes)) * np.array([0.01, 0.1, 0.2])[: law.n_states, None]
    eps = np.array([1e-7, 1e-6, 1e-6])[: law.n_states]
    full, group = FullStep(law, table[:, :1]), np.zeros(lanes, dtype=np.intp)
    after, slope = linearize(law, table, z, eps, full, group)
    np.testing.assert_array_equal(after, advance(law, table, z, full, group))
    for j in range(law.n_states):
        moved = z.copy()
        moved[j] += eps[j]
        change = (advance(law, table, moved, full, group) - after) / eps[j]
        near = np.isclose(slope[:, j], change, rtol=1e-5, atol=1e-5).all(axis=0)
        assert near.mean() > 0.98  # a difference may just meet an event that the lane itself does not
