"""Parts of the weak form against derivatives, sums and polynomials that are known, and a plant that it must return."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import stepid
from closed_form import Plant, make_run
from stepid.fitting.weak_form import WeakForm, _bump, _convolved, _smoothed, motion_along
from stepid.simulation.records import Records, lay_out

PLANT = Plant(base_mass=0.95, stiffness=216.0, damping=9.0)


def campaign(*, sign: float = 1.0, noise: float = 0.0) -> Records:
    rng = np.random.default_rng(2)
    steps = [(12, sign * 0.5), (200, -sign * 0.9)]
    runs = [
        make_run(PLANT, added, name=f"{added}", steps=steps, count=400, noise=noise, rng=rng) for added in (0.0, 1.0)
    ]
    return lay_out(stepid.Campaign(name="c", experiments=tuple(runs)))


def test_derivatives_of_the_bump_are_its_slopes() -> None:
    h = 1e-3
    phi, first, second = _bump(2001, h)
    assert (phi[0], phi[1000], phi[-1]) == (0.0, 1.0, 0.0)
    np.testing.assert_allclose(np.gradient(phi, h)[1:-1], first[1:-1], atol=1e-5 * np.abs(first).max())
    np.testing.assert_allclose(np.gradient(first, h)[1:-1], second[1:-1], atol=1e-5 * np.abs(second).max())


def test_forces_are_tested_by_sums_under_each_bump() -> None:
    records, width = campaign(), 0.1
    forces = np.random.default_rng(4).standard_normal((2, records.size))
    expected = []
    for piece, h in zip(records.pieces(), records.sample_time, strict=True):
        n = round(width / h)
        phi = (1 - np.linspace(-1, 1, n) ** 2) ** 4
        first = range(0, 400 - n + 1, n // 8)
        expected += [[h * float(phi @ force[piece][i : i + n]) for force in forces] for i in first]
    weak = WeakForm(records, width, fixed_mass=None)
    np.testing.assert_allclose(weak.test(forces), expected, atol=1e-12)
    assert weak.valleys([]) == []


@pytest.mark.parametrize("length", [11, 300])
def test_short_and_long_kernels_convolve_alike(length: int) -> None:
    rng = np.random.default_rng(3)
    y, kernel = 5.0 + rng.standard_normal(1000), rng.standard_normal(length)
    np.testing.assert_allclose(_convolved(y, kernel), np.convolve(y, kernel, "valid"), atol=1e-9)


def test_a_cubic_is_smoothed_to_itself_with_its_slope() -> None:
    place = np.arange(40.0)
    cubic = np.polynomial.Polynomial([3.0, -0.5, 0.02, 4e-4])
    value, slope = _smoothed(cubic(place), 9, 3)
    np.testing.assert_allclose(value, cubic(place), rtol=1e-9)
    np.testing.assert_allclose(slope, cubic.deriv()(place), atol=1e-9)


def test_the_plant_comes_back_from_exact_records() -> None:
    records = campaign()
    found = WeakForm(records, 0.3, fixed_mass=None).solve()
    assert found is not None
    assert found.shared == pytest.approx([0.95, 216.0, 9.0, 7.8], rel=0.01)
    assert found.displacement == pytest.approx([0.0, 0.0], abs=1e-4)
    assert WeakForm(campaign(sign=-1.0), 0.3, fixed_mass=None).solve().shared == pytest.approx(found.shared)  # type: ignore[union-attr]
    fixed = WeakForm(records, 0.3, fixed_mass=1.9).solve()  # twice the mass: as if the weights were twice as heavy
    assert fixed is not None
    assert fixed.shared[0] == 1.9
    assert fixed.left > 3 * found.left


def test_what_is_left_grows_with_the_noise() -> None:
    left = [
        found.left
        for noise in (1e-5, 2e-5, 4e-5)
        if (found := WeakForm(campaign(noise=noise), 0.3, fixed_mass=None).solve()) is not None
    ]
    assert left[1] / left[0] == pytest.approx(2.0, rel=0.3)
    assert left[2] / left[1] == pytest.approx(2.0, rel=0.2)


def test_a_plant_without_input_has_no_gain() -> None:
    t = 0.01 * np.arange(400)
    runs = []
    for added in (0.0, 1.0):
        decay, frequency = PLANT.rates(added)
        fields = {"time": t, "position": 0.02 * np.exp(-decay * t) * np.cos(frequency * t), "input": 0 * t}
        runs.append(stepid.Experiment(name=f"{added}", added_mass=added, spring="s", damper="d", **fields))
    found = WeakForm(lay_out(stepid.Campaign(name="c", experiments=tuple(runs))), 0.3, fixed_mass=None).solve()
    assert found is not None
    assert found.shared == pytest.approx([0.95, 216.0, 9.0, 0.0], rel=0.02)
    assert found.displacement == pytest.approx([0.02, 0.02], rel=0.02)


def test_what_pushes_outward_is_no_spring() -> None:
    records = campaign()
    t = records.time
    growing = np.concatenate([1e-4 * np.exp(2.0 * t[piece]) for piece in records.pieces()])
    runs = [
        run.model_copy(update={"position": growing[piece], "input": 0.0 * run.input})
        for run, piece in zip(records.runs, records.pieces(), strict=True)
    ]
    away = lay_out(stepid.Campaign(name="c", experiments=tuple(runs)))
    assert WeakForm(away, 0.3, fixed_mass=1.0).solve() is None


def test_a_missing_force_is_found_with_its_size() -> None:
    """x″ + c x′ + k x + a x³ made exact by choosing the input: u is free."""
    t = 0.005 * np.arange(800)
    x = 0.02 * np.sin(9.0 * t) * np.cos(2.3 * t)
    v, acceleration = np.gradient(x, t, edge_order=2), np.gradient(np.gradient(x, t, edge_order=2), t, edge_order=2)
    runs = []
    for added in (0.0, 1.0):
        volts = ((0.95 + added) * acceleration + 9.0 * v + 216.0 * x + 2e5 * x**3) / 7.8
        fields = {"time": t, "position": x, "input": volts, "input_between": "lines"}
        runs.append(stepid.Experiment(name=f"{added}", added_mass=added, spring="s", damper="d", **fields))
    records = lay_out(stepid.Campaign(name="c", experiments=tuple(runs)))
    weak = WeakForm(records, 0.2, fixed_mass=None)
    cube = -(records.position**3)
    plain, found = weak.solve(), weak.solve((cube,))
    assert plain is not None
    assert found is not None
    assert found.coefficients == pytest.approx([2e5], rel=0.02)
    assert found.shared == pytest.approx([0.95, 216.0, 9.0, 7.8], rel=0.02)
    assert found.left < 0.1 * plain.left
    assert weak.left_by_run([cube]) < 0.01
    assert weak.left_by_run([np.sin(40.0 * records.time)]) == pytest.approx(1.0, abs=0.05)
    assert weak.valleys([(np.sin(40.0 * records.time),), (cube,), (np.sin(44.0 * records.time),)]) == [1]


def test_effects_see_the_sign_of_the_velocity() -> None:
    records = campaign()
    v = np.where(np.arange(records.size) % 3 == 0, -0.01, 0.01) * (np.arange(records.size) % 5 > 0)
    seen = motion_along(records, np.array([0.95, 216.0, 9.0, 7.8]), records.position, v)
    np.testing.assert_array_equal(seen.sign, np.where(v < 0, -1.0, 1.0))
    assert set(seen.mass) == {0.95, 1.95}
    assert math.isclose(float(seen.stiffness[0]), 216.0)


def test_what_holds_a_cart_at_rest_does_not_count() -> None:
    """Friction that holds the cart from its second turn on is in no equation: only bumps along which it moves count."""
    records = campaign()
    position, speed = records.position.copy(), np.zeros(records.size)
    for piece in records.pieces():
        x = position[piece]
        first = 12 + int(np.argmax(x[12:200]))
        turn = first + int(np.argmin(x[first:200]))
        x[turn:] = x[turn]
        speed[piece][12:turn] = 0.1
    stuck = replace(records, position=position)
    every, moving = (WeakForm(stuck, 0.2, fixed_mass=None, speed=v) for v in (None, speed))
    assert moving.plain[1].size < 0.5 * every.plain[1].size
    errors = [
        np.inf if found is None else np.abs(found.shared / [0.95, 216.0, 9.0, 7.8] - 1).max()
        for found in (every.solve(), moving.solve())
    ]
    assert errors[1] < 0.1
    assert errors[0] > 5 * errors[1]
