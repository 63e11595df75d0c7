"""Plants of any size: a light disk, a heavy sled; and records without any noise."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.fitting.noise_floor import least_floor, repeats
from stepid.simulation.records import lay_out


def release(added: float, *, mass: float, noise: float = 0.0, seed: int = 0, step: float = 0.005) -> stepid.Experiment:
    """A release of 0.02 m or rad in closed form, of 10 rad/s at `mass` and 5 % damping there."""
    time = np.arange(400) * step
    total, stiffness, damping = mass + added, 100.0 * mass, mass
    decay = damping / (2 * total)
    swing = np.sqrt(stiffness / total - decay**2)
    y = 0.02 * np.exp(-decay * time) * (np.cos(swing * time) + decay / swing * np.sin(swing * time))
    return stepid.Experiment(
        name=f"release {added:g} {step:g}",
        time=time,
        position=y + np.random.default_rng(seed).normal(0.0, noise, time.size) if noise else y,
        input=np.zeros(time.size),
        added_mass=added,
        spring="rod",
        damper="oil",
    )


@pytest.mark.parametrize("mass", [2e-5, 2e-3, 1.0, 500.0])
def test_masses_of_any_size_are_found(mass: float) -> None:
    runs = tuple(release(part * mass, mass=mass, noise=2e-6, seed=i) for i, part in enumerate((0.0, 0.5, 1.0)))
    found = stepid.fit(stepid.Campaign(name="plant", experiments=runs))
    assert found.parameters["base_mass"].value == pytest.approx(mass, rel=0.02)
    assert found.parameters["stiffness[rod]"].value == pytest.approx(100.0 * mass, rel=0.02)


def test_records_without_noise_are_linear() -> None:
    campaign = stepid.Campaign(name="exact", experiments=(release(0.0, mass=1.0), release(0.5, mass=1.0)))
    d = stepid.diagnose(campaign, effort=stepid.Effort.quick())
    assert d.verdict == "adequate"
    assert d.gap.noise >= 0.9 * least_floor(lay_out(campaign)) > 0  # of a run whose first samples a hand may have held
    assert not any("More than noise" in note for note in stepid.fit(campaign).notes)


def stepped(step: float) -> stepid.Experiment:
    """A step from rest, 100 samples."""
    time = np.arange(100) * step
    volts = (np.arange(100) >= 5) * 2.0
    y = 0.01 * np.where(volts > 0, 1.0 - np.cos(9.0 * (time - time[5])), 0.0)
    return stepid.Experiment(
        name=f"step {step:g}", time=time, position=y, input=volts, added_mass=0.0, spring="rod", damper="oil"
    )


def test_repeats_have_one_clock() -> None:
    def groups(*steps: float) -> list[tuple[int, ...]]:
        runs = tuple(stepped(step).model_copy(update={"name": f"run {i}"}) for i, step in enumerate(steps))
        return repeats(lay_out(stepid.Campaign(name="steps", experiments=runs)))

    assert groups(0.005, 0.005) == [(0, 1)]
    assert groups(0.005, 0.01) == []
