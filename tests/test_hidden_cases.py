"""The acceptance cases: complete, and their reference far better than what it judges."""

from __future__ import annotations

import numpy as np
import pytest

from hidden import EVERY
from hidden.accuracy_cases import CASES, COUNTS, DRIVE, reference, run
from hidden.sets import requests


def test_every_effect_steps_and_is_released() -> None:
    assert {f"{name} {how}" for name in EVERY for how in ("step", "release")} <= set(CASES)
    combinations = [effects for name, (effects, _) in CASES.items() if name.startswith("combination")]
    assert len(combinations) == 30
    assert {len(effects) for effects in combinations} == {2, 3, 4}
    assert {name for effects in combinations for name in effects} == set(EVERY)


@pytest.mark.parametrize("name", ["power_damping release", "combination 11", "smooth drive", "stribeck_friction step"])
def test_the_reference_is_right_to_a_ten_thousandth_of_a_count(name: str) -> None:
    assert np.max(np.abs(reference(name) - reference(name, fineness=0.01))) < 1e-4 / COUNTS


@pytest.mark.parametrize("name", ["sine_stiffness", "power_damping", "actuator_rate_limit", "end_stop"])
@pytest.mark.parametrize("how", ["step", "release"])
def test_an_effect_shows_in_its_case(name: str, how: str) -> None:
    plain = ({}, CASES[f"{name} {how}"][1])
    assert np.max(np.abs(reference(f"{name} {how}") - reference(plain))) > 50 / COUNTS
    assert (run(f"{name} {how}").position != 0) == (how == "release")
    assert np.any(run(f"{name} {how}").inputs) == (how == "step" or name in DRIVE)


def test_the_new_effects_have_a_set_of_their_own() -> None:
    wanted = requests("new", 60)
    assert {r.effects[0] for r in wanted} == {"sine_stiffness", "power_damping", "actuator_rate_limit"}
    assert len({r.seed for r in wanted}) == 60
