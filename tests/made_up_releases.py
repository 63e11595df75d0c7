"""Releases of a linear plant in closed form."""

from __future__ import annotations

import numpy as np

import stepid


def released(added: float, displacement: float = 0.02) -> stepid.Experiment:
    """A release from so far [m], with so much mass added [kg]."""
    time = np.arange(600) * 0.005
    mass, stiffness, damping = 0.8 + added, 300.0, 4.0
    decay = damping / (2 * mass)
    swing = np.sqrt(stiffness / mass - decay**2)
    y = displacement * np.exp(-decay * time) * (np.cos(swing * time) + decay / swing * np.sin(swing * time))
    noise = np.random.default_rng(3).normal(0.0, 1e-6, 600)
    return stepid.Experiment(
        name=f"release {added:g}",
        time=time,
        position=y + noise,
        input=np.zeros(600),
        added_mass=added,
        spring="soft",
        damper="oil",
    )
