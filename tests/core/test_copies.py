"""Records that are copies, and runs that are repeats, whatever clock wrote their time stamps."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.core.copies import are_repeats, copies


def run(
    name: str, *, begin: float = 0.0, late: float = 0.0, zero: float = 0.0, added_mass: float = 0.0
) -> stepid.Experiment:
    time = 0.007 * np.arange(300)
    time[150:] += late
    position = 0.01 * (1 - np.exp(-3 * time) * np.cos(20 * time))
    drive = np.where(time > 0.0, 0.5, zero)
    return stepid.Experiment(
        name=name, time=begin + time, position=position, input=drive, added_mass=added_mass, spring="s", damper="d"
    )


@pytest.mark.parametrize("begin", [1.0, 137.3, 200.0, 1.7e9])
def test_a_copy_with_another_clock_is_a_copy(begin: float) -> None:
    left_out = copies([run("one"), run("two", begin=begin)])
    assert list(left_out) == ["two"]
    assert "copies, no repeats" in left_out["two"]


def test_a_repeat_may_begin_at_any_time_with_any_zero_of_its_input() -> None:
    assert are_repeats(run("one"), run("two", begin=137.3))
    assert are_repeats(run("one"), run("two", zero=-0.0))
    assert not are_repeats(run("one"), run("two", late=0.001))
    assert not are_repeats(run("one"), run("two", added_mass=0.5))
    assert not are_repeats(run("one"), run("two", zero=0.1))


def test_other_labels_are_told_whatever_the_clock() -> None:
    left_out = copies([run("one"), run("two", begin=137.3, added_mass=0.5)])
    assert set(left_out) == {"one", "two"}
    assert "different labels" in left_out["one"]
