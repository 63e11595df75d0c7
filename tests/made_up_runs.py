"""Characteristics of made-up runs, and the mass offsets between them."""

from __future__ import annotations

import numpy as np

import stepid


def run(name: str, mass: float, *, spring: str = "medium", stiffness: float = 200.0, base: str = "cart"):
    natural = np.sqrt(stiffness / mass)
    ratio = 14 / (2 * np.sqrt(stiffness * mass))
    return stepid.Characteristics(
        name=name,
        damped_frequency=natural * np.sqrt(1 - ratio**2),
        damping_ratio=ratio,
        spring=spring,
        base=base,
        uncertainty=stepid.CharacteristicsUncertainty(damped_frequency=0.05, damping_ratio=0.002),
    )


def offset(one: str, two: str, difference: float) -> stepid.MassOffset:
    return stepid.MassOffset(from_run=one, to_run=two, difference=difference, uncertainty=0.005 * (difference != 0))
