"""Slices of a driven record that do not say how they start: what moves at first is no effect."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lsim

import stepid
from stepid.core.slices import of_one_recording
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


ENDS = [(60, 220, 440), (220, 480, 580), (100, 220, 440, 580)]


@pytest.mark.parametrize("first", [(220, 440), *(pytest.param(ends, marks=pytest.mark.slow) for ends in ENDS)])
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


@pytest.mark.slow
def test_parts_of_one_swing_have_one_damping() -> None:
    """A pendulum with air drag, 200 s long: its damping falls with the swing, in each part it is another."""
    time = 0.02 * np.arange(5000)
    swing = solve_ivp(
        lambda _, y: [y[1], -20.0 * np.sin(y[0]) - 0.02 * y[1] - 0.05 * y[1] * abs(y[1])],
        (0.0, time[-1]), [0.9, 0.0], t_eval=time, rtol=1e-9, atol=1e-9,
    ).y[0]  # fmt: skip
    whole = stepid.Experiment(
        name="swing", time=time, position=swing + 1e-3 * np.random.default_rng(1).standard_normal(time.size),
        input=np.zeros(time.size), added_mass=0.0, spring="gravity", damper="air", starts="motion",
    )  # fmt: skip
    parts = [whole.slice(a, a + 1600, name=f"from {a}") for a in (0, 1650, 3300)]
    assert of_one_recording(parts)
    d = stepid.diagnose(stepid.Campaign(name="swing", experiments=parts))
    assert not d.scatter
    assert "sine_stiffness" in d.effects
    assert {"quadratic_damping", "power_damping"} & {name for one in d.ranking[:2] for name in one.effects}
