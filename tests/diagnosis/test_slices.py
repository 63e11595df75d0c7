"""Slices of a driven record that do not say how they start: what moves at first is no effect."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

import stepid
from stepid.diagnosis.selection.candidate import Candidate

STEP = 0.01


def slices(*first: int, noise: float = 1e-5) -> stepid.Campaign:
    """160 samples each from these on, of a linear plant that random levels drive, solved by scipy."""
    levels = np.repeat(np.random.default_rng(5).uniform(-1, 1, 40), 37)
    time = STEP * np.arange(levels.size)
    _, position, _ = lsim(([7.8], [1.0, 1.6, 216.0]), levels, time, interp=False)
    position = position + noise * np.random.default_rng(3).standard_normal(time.size)
    runs = []
    for begin in first:
        part = slice(begin, begin + 160)
        runs.append(
            stepid.Experiment(
                name=f"from {begin}", time=time[part] - time[begin], position=position[part], input=levels[part],
                input_before=levels[begin - 1], added_mass=0.0, spring="spring", damper="damper",
            )
        )  # fmt: skip
    return stepid.Campaign(name="slices", experiments=runs)


@pytest.mark.parametrize("first", [(220, 440), (60, 220, 440), (220, 480, 580), (100, 220, 440, 580)])
def test_starts_off_rest_are_no_effect(first: tuple[int, ...]) -> None:
    d = stepid.diagnose(slices(*first))
    assert d.verdict == "adequate"
    assert set(d.scatter) <= {"start_offset", "start_velocity"}
    assert d.gap.after < 1.15 * d.gap.noise


def test_offset_and_velocity_of_a_start_are_one_condition() -> None:
    def complexity(*conditions: str) -> int:
        return Candidate((), frozenset(conditions), None, 0.0).complexity  # type: ignore[arg-type]

    assert complexity() == 0
    assert complexity("start_velocity") == complexity("start_offset", "start_velocity") == 1
    assert complexity("start_offset", "start_velocity", "gain") == complexity("gain", "damping") == 2
