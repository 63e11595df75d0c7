"""Small campaigns of the hidden plant, and ways to break one of their runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import stepid
from hidden import Run, fast

SAMPLE_TIME = 0.0088542  # s
COUNTS = 226600.0
MASSES = (0.0, 0.5, 1.5, 2.0)
STIFFNESS = {"medium": 216.0, "stiff": 390.0}
DAMPING = {"half": 7.0}
FRICTION = {"coulomb_friction": {"level": 0.2}}
NOISE = 15e-6  # m


def inputs(volts: float = 0.5, *, size: int = 420, first: int = 12, back: int = 210) -> np.ndarray:
    """A step and back."""
    u = np.zeros(size)
    u[first:back] = volts
    return u


def campaign(
    seed: int,
    effects: Mapping[str, Mapping[str, float]] | None = None,
    *,
    masses: Sequence[float] = MASSES,
    true_masses: Sequence[float] | None = None,
    springs: Sequence[str] | None = None,
    true_springs: Sequence[str] | None = None,
    volts: Sequence[float] | None = None,
    drives: Sequence[np.ndarray] | None = None,
    noise: float = NOISE,
    base_mass: float = 0.95,
) -> stepid.Campaign:
    """One run a mass; `true_…` is what the plant has where it is not what the labels say."""
    rng = np.random.default_rng(seed)
    springs = springs or ["medium"] * len(masses)
    volts = volts or [0.5, -0.5, 0.5, 0.4, 0.5, -0.4][: len(masses)]
    drives = drives or [inputs(v) for v in volts]
    runs = [
        Run(
            mass=base_mass + m,
            stiffness=STIFFNESS[s],
            damping=DAMPING["half"],
            gain=7.8,
            sample_time=SAMPLE_TIME,
            inputs=u,
            effects=effects or {},
        )
        for m, s, u in zip(true_masses or masses, true_springs or springs, drives, strict=True)
    ]
    experiments = []
    for i, (x, u) in enumerate(zip(fast(runs), drives, strict=True)):
        y = x + rng.uniform(-1e-3, 1e-3) + noise * rng.standard_normal(x.size)
        experiments.append(
            stepid.Experiment(
                name=f"case {i + 1}",
                time=SAMPLE_TIME * np.arange(x.size),
                position=np.round(y * COUNTS) / COUNTS,
                input=u,
                added_mass=masses[i],
                spring=springs[i],
                damper="half",
                counts_per_meter=COUNTS,
            )
        )
    return stepid.Campaign(name=f"seed {seed}", experiments=tuple(experiments))


def changed(campaign: stepid.Campaign, run: int, **fields: Any) -> stepid.Campaign:
    """The campaign with some fields of one run replaced."""
    experiments = list(campaign.experiments)
    old = experiments[run]
    experiments[run] = stepid.Experiment(**{name: getattr(old, name) for name in type(old).model_fields} | fields)
    return stepid.Campaign(name=campaign.name, experiments=tuple(experiments))


def scaled(campaign: stepid.Campaign, run: int, factor: float) -> stepid.Campaign:
    """Readings of one run times a factor, as a wrong counts_per_meter makes them."""
    old = campaign.experiments[run]
    return changed(campaign, run, position=old.position * factor, counts_per_meter=COUNTS / factor)


def shifted(campaign: stepid.Campaign, run: int, samples: int) -> stepid.Campaign:
    """One run whose input is late in the file by so many samples (early where negative)."""
    u = np.roll(campaign.experiments[run].input, samples)
    return changed(campaign, run, input=u)


def jittered(campaign: stepid.Campaign, samples: Sequence[int]) -> stepid.Campaign:
    """Every run's input out of step by so many samples."""
    for run, n in enumerate(samples):
        campaign = shifted(campaign, run, n)
    return campaign
