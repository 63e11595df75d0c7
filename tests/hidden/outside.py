"""What the catalogue has no word for: changes of a run that a diagnosis must not give a wrong name."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .draw import Setup
from .law_draws import by_sample, draw_law, scale_of
from .laws import BY_SAMPLE, NEED_DRIVE, NEW_LAWS, SEEN_NEW
from .plant import Run

OUTSIDE = ("bump", "parameter_jump", "mass_loss", "square_wave", "sensor_ripple", "sticky_spot", "fading_drive")
SEEN_OUTSIDE = (*OUTSIDE, *SEEN_NEW)
NEW_OUTSIDE = tuple(name for name in NEW_LAWS if name not in SEEN_NEW)
EVERY_OUTSIDE = (*SEEN_OUTSIDE, *NEW_OUTSIDE)
DRIVEN_OUTSIDE = NEED_DRIVE


def apply_outside(
    name: str, run: Run, setup: Setup, strength: float, common: np.random.Generator, own: np.random.Generator
) -> Run:
    """`run` with the disturbance; `common` draws what the campaign shares, `own` what differs from run to run."""
    if name in BY_SAMPLE:
        fields: dict[str, Any] = by_sample(name, run.size, run.sample_time, scale_of(setup), strength, common, own)
        return replace(run, **fields)
    if name in NEW_LAWS:
        return replace(run, law=draw_law(name, scale_of(setup), strength, common, own))
    n, push = run.size, setup.stiffness["medium"] * setup.reach
    if name == "bump":  # a hand touches the cart once, in about half of the runs
        force = np.zeros(n)
        hit, size = own.random() < 0.6, float(own.choice([-1, 1])) * own.uniform(0.3, 1.0)
        begin, width = int(own.uniform(0.1, 0.8) * n), max(2, int(0.06 / run.sample_time))
        if hit:
            force[begin : begin + width] = strength * 0.5 * push * size
        return replace(run, held_force=force)
    if name == "parameter_jump":  # a coil of the spring lets go
        at = int(common.uniform(0.25, 0.6) * n)
        jump = min(0.4, strength * common.uniform(0.05, 0.2)) * common.choice([-1, 1])
        return replace(run, stiffness_scale=np.where(np.arange(n) < at, 1.0, 1.0 + jump))
    if name == "mass_loss":  # a weight falls off
        at = int(common.uniform(0.1, 0.4) * n)
        lost = min(0.45, strength * common.uniform(0.08, 0.25))
        return replace(run, mass_scale=np.where(np.arange(n) < at, 1.0, 1.0 - lost))
    if name == "square_wave":  # a fan, a relay: a force that switches
        period = 2 * np.pi / setup.rate * common.uniform(0.7, 3.0)
        phase = own.uniform(0, period)
        level = strength * push * common.uniform(0.01, 0.05)
        times = run.sample_time * np.arange(n)
        return replace(run, held_force=level * np.where((times + phase) % period < period / 2, 1.0, -1.0))
    if name == "sticky_spot":  # a dent in the guide
        extra = strength * push * common.uniform(0.1, 0.4)
        return replace(
            run, sticky=(extra, setup.reach * common.uniform(0.3, 1.3), setup.reach * common.uniform(0.04, 0.12))
        )
    if name == "fading_drive":  # the amplifier's supply sags during the run
        fade = np.exp(-strength * common.uniform(0.05, 0.25) * np.arange(n) / n)
        return replace(run, inputs=np.asarray(run.inputs) * fade)
    return run  # sensor_ripple is in the reading, not in the motion


def ripple(x: np.ndarray, setup: Setup, strength: float, common: np.random.Generator) -> np.ndarray:
    """Reading of an eccentric encoder wheel: a wave over position."""
    pitch = setup.reach * common.uniform(0.3, 1.0)
    size = strength * setup.reach * common.uniform(0.003, 0.02)
    phase = common.uniform(0, 2 * np.pi)
    return np.asarray(x + size * (np.sin(2 * np.pi * x / pitch + phase) - np.sin(phase)))
