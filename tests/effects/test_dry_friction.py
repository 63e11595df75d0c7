"""The force of dry friction along a measured motion, where the cart rests, too; steps in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.effects import resolve
from stepid.effects.base import Motion, Scales

SCALES = Scales(0.01, 0.1, 2.0, 1.0, 200.0, 8.0, 1.0, 1.0, 0.004, 1.0, 1e-5, -0.01, 0.01)
TIME = 0.01 * np.arange(300)
MASS, STIFFNESS, DAMPING, GAIN, FRICTION = 1.0, 350.0, 60.0, 5.0, 0.2


def test_a_cart_at_rest_is_held_by_nothing_or_as_it_last_moved() -> None:
    """Two runs: at rest, forward, at rest, back and slowly on; and one that moves back, then rests."""
    v = np.array([0.0, 0.0, 0.1, 0.0005, 0.0, -0.1, -0.001]), np.array([0.0, -0.1, -0.0005, 0.0])
    time = np.concatenate([np.arange(part.size) * SCALES.sample_time for part in v])
    speed = np.concatenate(v)
    motion = Motion(speed, speed, np.sign(speed), time, *(np.full(speed.size, 2.0),) * 4)
    soft = np.array([0.0, 0.0, 1.0, 0.25, 0.0, -1.0, -0.5, 0.0, -1.0, -0.25, 0.0])
    held = np.array([0.0, 0.0, 1.0, 1.0, 1.0, -1.0, -1.0, 0.0, -1.0, -1.0, -1.0])
    for name, scale in (("coulomb_friction", 1.0), ("load_proportional_friction", 2.0 * 9.81)):
        ((effect),) = resolve([name])
        found = [r.forces[0] for r in effect.regressors(SCALES, motion)]
        assert np.allclose(found, [-scale * soft, -scale * held])


def creeping(added: float, volts: float, seed: int) -> stepid.Experiment:
    """An overdamped step with dry friction, in closed form: it moves one way only, against a force that stays."""
    mass = MASS + added
    decay = DAMPING / (2 * mass)
    root = np.sqrt(decay**2 - STIFFNESS / mass)
    slow, fast = decay - root, decay + root
    late = np.maximum(TIME - 0.25, 0.0)
    end = (GAIN * volts - np.sign(volts) * FRICTION) / STIFFNESS
    y = end * (1.0 - (fast * np.exp(-slow * late) - slow * np.exp(-fast * late)) / (fast - slow))
    noise = 15e-6 * np.random.default_rng(seed).standard_normal(TIME.size)
    return stepid.Experiment(
        name=f"step {seed}", time=TIME, position=y + noise, input=np.where(TIME < 0.25, 0.0, volts), added_mass=added,
        spring="s", damper="d",
    )  # fmt: skip


@pytest.mark.parametrize("seed", [0, 100])
def test_friction_and_a_dead_zone_are_not_told_apart_where_a_cart_creeps_to_its_rest(seed: int) -> None:
    """Both take a constant from the force of every step: the readings are the same."""
    plan = ((0.0, 1.0), (0.0, -2.0), (0.5, 1.0), (0.5, 2.0), (1.0, -1.0), (1.0, 3.0))
    runs = [creeping(added, volts, seed + i) for i, (added, volts) in enumerate(plan)]
    found = stepid.diagnose(stepid.Campaign(name="creeping", experiments=runs))
    assert found.verdict == "ambiguous"
    assert {("coulomb_friction",), ("actuator_dead_zone",)} <= {found.effects, *found.alternatives}
