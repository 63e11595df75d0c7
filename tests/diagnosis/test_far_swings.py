"""A pendulum that swings far: the response of the linear plant, which loses its phase, tells nothing of a sine."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import stepid

FREQUENCY, DAMPING, FRICTION = 30.0, 0.015, 0.2  # 1/s², 1/s and rad/s², per unit inertia
NOISE = 0.9e-3  # rad


def swings(begin: float, *, step: float = 1 / 150, samples: int = 4500, within: int = 20) -> stepid.Campaign:
    """Three slices of one decay from `begin` [rad]: the midpoint rule, many steps a sample."""
    angle, rate, h = begin, 0.0, step / within

    def pull(x: float, v: float) -> float:
        return float(-FREQUENCY * np.sin(x) - DAMPING * v - FRICTION * np.tanh(v / 1e-3))

    out = []
    for _ in range(samples):
        out.append(angle)
        for _ in range(within):
            middle = rate + h / 2 * pull(angle, rate)
            rate, angle = rate + h * pull(angle + h / 2 * rate, middle), angle + h * middle
    reading = np.array(out) + NOISE * np.random.default_rng(1).standard_normal(samples)
    whole = stepid.Experiment(
        name="free", time=step * np.arange(samples), position=reading, input=np.zeros(samples), added_mass=0.0,
        spring="s", damper="d", starts="motion",
    )  # fmt: skip
    edges = np.linspace(0, samples, 4).round().astype(int).tolist()
    parts = [whole.slice(a, b, name=f"part {i}") for i, (a, b) in enumerate(pairwise(edges), 1)]
    return stepid.Campaign(name="pendulum", experiments=parts, motion="rotation")


@pytest.mark.slow
@pytest.mark.parametrize("begin", [1.53, 1.8])
def test_sine_and_friction_are_named(begin: float) -> None:
    """A cubic spring comes first, and leaves five to ten times the noise."""
    found = stepid.diagnose(swings(begin))
    sets = [set(effects) for effects in (found.effects, *found.alternatives)]
    assert {"sine_stiffness", "coulomb_friction"} in sets
    assert all("sine_stiffness" in effects for effects in sets)
    assert found.gap.after < 1.1 * NOISE
