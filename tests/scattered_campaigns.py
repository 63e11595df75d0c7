"""Small campaigns of the hidden plant whose runs differ: in start time, gain, damping, friction, mass, stiffness."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import stepid
from broken_campaigns import COUNTS, MASSES, NOISE, SAMPLE_TIME, inputs
from hidden import Run, fast

FINE = 20  # steps a sample


def scattered(
    seed: int,
    *,
    masses: Sequence[float] = (*MASSES, 1.0, 0.25),
    volts: Sequence[float] = (0.5, -0.5, 0.5, 0.4, 0.5, -0.4),
    late: Sequence[float] | None = None,
    gain: Sequence[float] | None = None,
    damping: Sequence[float] | None = None,
    friction: Sequence[float] | None = None,
    level: float = 0.0,
    noise: float = NOISE,
) -> stepid.Campaign:
    """One run a mass; `late` in samples, the others relative to the plant."""
    rng = np.random.default_rng(seed)
    none = [0.0] * len(masses)
    late, gain, damping, friction = (x or none for x in (late, gain, damping, friction))
    runs = [
        Run(
            mass=0.95 + m,
            stiffness=216.0,
            damping=7.0 * (1 + damping[i]),
            gain=7.8 * (1 + gain[i]),
            sample_time=SAMPLE_TIME / FINE,
            inputs=np.repeat(inputs(volts[i]), FINE),
            effects={"coulomb_friction": {"level": level * (1 + friction[i])}} if level else {},
        )
        for i, m in enumerate(masses)
    ]
    experiments = []
    for i, x in enumerate(fast(runs)):
        size = x.size // FINE
        at = np.clip(FINE * np.arange(size) - round(FINE * late[i]), 0, x.size - 1)
        y = x[at] + rng.uniform(-1e-3, 1e-3) + noise * rng.standard_normal(size)
        experiments.append(
            stepid.Experiment(
                name=f"case {i + 1}",
                time=SAMPLE_TIME * np.arange(size),
                position=np.round(y * COUNTS) / COUNTS,
                input=inputs(volts[i]),
                added_mass=masses[i],
                spring="medium",
                damper="half",
                counts_per_meter=COUNTS,
            )
        )
    return stepid.Campaign(name=f"seed {seed}", experiments=tuple(experiments))
