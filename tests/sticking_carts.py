"""Carts that a step moves once, until friction holds them: no swing tells their period, and no weight their mass.

The record of a cart that moves one way is a closed form: until it stops, dry friction is a constant force.
"""

from __future__ import annotations

import numpy as np

import stepid

NOISE = 5e-6
ADDED = (0.0, 0.25, 0.5, 1.0)  # of the base mass


def rise(time: np.ndarray, mass: float, damping: float, stiffness: float, force: float, start: float) -> np.ndarray:
    """Position of a cart that is let go at `start` [m] with a constant force [N], and is held where it stops."""
    rate, end = np.sqrt(stiffness / mass), force / stiffness
    ratio = damping / 2 / np.sqrt(stiffness * mass)
    time = np.maximum(time, 0.0)
    if ratio < 1:
        swing = rate * np.sqrt(1 - ratio**2)
        time = np.minimum(time, np.pi / swing)
        fades = np.cos(swing * time) + ratio * rate / swing * np.sin(swing * time)
        return end + (start - end) * np.exp(-ratio * rate * time) * fades
    apart = rate * np.sqrt(ratio**2 - 1)
    fast, slow = -ratio * rate - apart, -ratio * rate + apart
    return end + (start - end) * (slow * np.exp(fast * time) - fast * np.exp(slow * time)) / (slow - fast)


def swings(
    time: np.ndarray, mass: float, damping: float, stiffness: float, force: float, friction: float
) -> np.ndarray:
    """Position of a cart that rests at zero and that a force [N] moves to and fro, until friction holds it."""
    rate = np.sqrt(stiffness / mass)
    half = np.pi / (rate * np.sqrt(1 - (damping / 2 / np.sqrt(stiffness * mass)) ** 2))
    out, start, way = np.zeros(time.size), 0.0, 1.0
    for begin in half * np.arange(200):
        if time[-1] < begin or abs(force - stiffness * start) <= friction:
            break
        since = time >= begin
        out[since] = rise(time[since] - begin, mass, damping, stiffness, force - way * friction, start)
        start = float(rise(np.array([half]), mass, damping, stiffness, force - way * friction, start)[0])
        way = -way
    return out


def campaign(seed: int, runs: int = 4) -> stepid.Campaign:
    """Runs of a cart with a friction that holds it where it first stops, each begun at another place."""
    rng = np.random.default_rng(seed)
    mass, stiffness = rng.uniform(0.5, 5), np.exp(rng.uniform(np.log(200), np.log(3000)))
    damping = 2 * np.exp(rng.uniform(np.log(0.35), np.log(2.5))) * np.sqrt(stiffness * mass)
    drive = 0.5 * rng.uniform(1, 50)
    masses = mass * (1 + np.array(ADDED[:runs]))
    ratios = np.minimum(damping / 2 / np.sqrt(stiffness * masses), 0.999)
    beyond = np.exp(-np.pi * ratios / np.sqrt(1 - ratios**2))
    friction = max(rng.uniform(0.12, 0.6), 1.05 * float(np.max(beyond / (2 + beyond)))) * drive
    experiments = []
    for i, own in enumerate(masses):
        step = float(rng.choice([0.002, 0.004, 0.01]))
        time, begin = step * np.arange(600), step * int(rng.integers(0, 20))
        start = rng.uniform(-0.8, 0.8) * friction / stiffness
        position = rise(time - begin, own, damping, stiffness, drive - friction, start)
        experiments.append(
            stepid.Experiment(
                name=f"run {i}", time=time, position=position + rng.normal(0, NOISE, time.size),
                input=np.where(time >= begin, 0.5, 0.0), added_mass=own - mass, spring="spring", damper="damper",
            )
        )  # fmt: skip
    return stepid.Campaign(name=f"sticks {seed}", experiments=experiments)
