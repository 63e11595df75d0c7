"""A linear plant whose rest position moves as the drive first does: what frees the starts is no sign of an effect."""

from __future__ import annotations

import numpy as np
import pytest

import stepid


def rise(time: np.ndarray, rate: float, ratio: float) -> np.ndarray:
    """Response to a step at 0, its end 1."""
    swing, t = rate * np.sqrt(1 - ratio**2), np.maximum(time, 0.0)
    faded = np.exp(-ratio * rate * t) * (np.cos(swing * t) + ratio * rate / swing * np.sin(swing * t))
    return np.where(time > 0, 1.0 - faded, 0.0)


def campaign(seed: int) -> stepid.Campaign:
    rng = np.random.default_rng([seed, 5])
    mass, stiffness, gain = rng.uniform(0.5, 2), rng.uniform(200, 1000), rng.uniform(1, 10)
    damping = 2 * rng.uniform(0.08, 0.25) * np.sqrt(stiffness * mass)
    reach, step = rng.uniform(0.005, 0.03), 2 * np.pi * np.sqrt(mass / stiffness) / rng.uniform(40, 90)
    time, runs = step * np.arange(500), []
    for i, part in enumerate((0.0, 0.25, 0.5, 1.0, 1.0, 0.5)):
        own = mass * (1 + part)
        rate, ratio = np.sqrt(stiffness / own), damping / 2 / np.sqrt(stiffness * own)
        first, back = 4, int(rng.integers(200, 300))
        moved = 0.012 * reach * np.clip(rng.standard_normal(), -2, 2)
        y = (reach + moved) * rise(time - time[first], rate, ratio) - reach * rise(time - time[back], rate, ratio)
        number = np.arange(time.size)
        runs.append(
            stepid.Experiment(
                name=f"run {i}", time=time, position=y + rng.normal(0, 1e-3 * reach, time.size),
                input=np.where((number >= first) & (number < back), stiffness * reach / gain, 0.0),
                added_mass=mass * part, spring="spring", damper="damper",
            )
        )  # fmt: skip
    return stepid.Campaign(name=f"moved {seed}", experiments=runs, weight_uncertainty=1e-9)


@pytest.mark.parametrize("seed", [0, 4])
def test_a_rest_position_that_moves_with_the_first_step_is_no_effect(seed: int) -> None:
    d = stepid.diagnose(campaign(seed))
    assert (d.verdict, d.effects) == ("adequate", ())
    assert d.scatter["start_offset"].unit == "m"
    assert d.scatter["start_offset"].explained > 0.5
    assert any("The runs start off their rest position by " in note for note in d.notes)
