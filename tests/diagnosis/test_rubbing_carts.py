"""Releases of carts with dry friction: what a hand may have held, and weights that are off, are no effects."""

from __future__ import annotations

import numpy as np
import pytest

import rubbing_carts
import stepid


def test_a_cart_without_damping_loses_four_times_friction_over_stiffness_a_cycle() -> None:
    time = np.linspace(0.0, 3.0, 3001)  # of a period of 1 s
    stiffness = 2.0 * (2 * np.pi) ** 2
    x = rubbing_carts.swing(time, 2.0, 0.0, stiffness, 0.1, (0.05, 0.0))
    np.testing.assert_allclose(x[[0, 1000, 2000, 3000]], 0.05 - 4 * 0.1 / stiffness * np.arange(4), atol=1e-9)


def test_a_cart_is_held_where_the_spring_is_weaker_than_friction() -> None:
    x = rubbing_carts.swing(np.linspace(0.0, 2.0, 201), 2.0, 1.0, 80.0, 1.0, (0.05, 0.0))
    assert np.ptp(x[-50:]) == 0
    assert abs(x[-1]) <= 1.0 / 80.0


@pytest.mark.parametrize("seed", [1, 5])
def test_a_hold_of_a_few_samples_that_nobody_sees_is_no_relaxing_spring(seed: int) -> None:
    d = stepid.diagnose(rubbing_carts.campaign(seed, hold=8.0))
    assert d.effects == ("coulomb_friction",)
    assert d.probability == 0.95
    assert any("a hand may still have held the cart" in note for note in d.notes)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 11])
def test_weights_that_are_off_as_far_as_they_may_be_are_no_second_effect(seed: int) -> None:
    d = stepid.diagnose(rubbing_carts.campaign(seed, weights=0.01))
    assert d.effects == ("coulomb_friction",)
    assert d.probability == 0.95
    assert d.gap.after < 1.05 * d.gap.noise
