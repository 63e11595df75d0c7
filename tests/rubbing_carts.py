"""Carts with dry friction that a hand lets go, in closed form: between two turns the friction is a constant force."""

from __future__ import annotations

import numpy as np

import stepid

ADDED = (0.0, 0.25, 0.5, 1.0, 1.0)  # of the base mass


def swing(
    time: np.ndarray, mass: float, damping: float, stiffness: float, friction: float, start: tuple[float, float]
) -> np.ndarray:
    """Position of an underdamped cart that begins at `start` [m, m/s], until friction holds it."""
    decay = damping / 2 / mass
    rate = np.sqrt(stiffness / mass - decay**2)
    out, begun = np.empty(time.size), 0.0
    x, v = start
    side = -np.sign(x) if v == 0 else np.sign(v)
    while begun <= time[-1]:
        middle = -side * friction / stiffness
        cosine, sine = x - middle, (v + decay * (x - middle)) / rate
        turn = np.arctan2(v, (decay * v + stiffness / mass * (x - middle)) / rate) % np.pi or np.pi
        ends = begun + turn / rate
        now = (time >= begun) & (time <= ends)
        t = time[now] - begun
        out[now] = middle + np.exp(-decay * t) * (cosine * np.cos(rate * t) + sine * np.sin(rate * t))
        x, v = float(middle + np.exp(-decay * turn / rate) * (cosine * np.cos(turn) + sine * np.sin(turn))), 0.0
        begun, side = ends, -np.sign(x)
        if stiffness * abs(x) <= friction:
            out[time > begun] = x
            break
    return out


def campaign(seed: int, *, hold: float = 0.0, weights: float = 0.0) -> stepid.Campaign:
    """Releases of one cart, each held for up to so many samples first.

    Weights are off by so much [kg] for each of 0.5 kg, one standard deviation, and are known to that; else exact.
    """
    rng = np.random.default_rng(seed)
    mass, stiffness = rng.uniform(0.5, 3), np.exp(rng.uniform(np.log(200), np.log(1500)))
    rate = np.sqrt(stiffness / mass)
    damping = 2 * np.exp(rng.uniform(np.log(0.02), np.log(0.2))) * np.sqrt(stiffness * mass)
    samples = np.exp(rng.uniform(np.log(30), np.log(150)))
    step, count = 2 * np.pi / rate / samples, int(min(1200, 8 * samples))
    reach = rng.uniform(0.005, 0.03)
    noise, friction = (
        reach * np.exp(rng.uniform(np.log(5e-4), np.log(4e-3))),
        stiffness * reach * rng.uniform(0.02, 0.08),
    )
    time, push = step * np.arange(count), np.exp(rng.uniform(np.log(0.002), np.log(0.03)))
    steps = np.unique(ADDED)
    off = weights * np.sqrt(mass * np.diff(steps) / 0.5) * rng.standard_normal(steps.size - 1)
    errors = dict(zip(steps[1:], np.cumsum(off), strict=True))
    runs = []
    for i, part in enumerate(ADDED):
        x = reach * rng.uniform(0.7, 1) * rng.choice([-1, 1, 1])
        held = hold * step * rng.uniform(0.1, 1)
        speed = push * rate * abs(x) * np.clip(rng.standard_normal(), -2, 2) if hold else 0.0
        true = mass * (1 + part) + errors.get(part, 0.0)
        free, y = time > held, np.full(count, x)
        y[free] = swing(time[free] - held, true, damping, stiffness, friction, (x, speed))
        runs.append(
            stepid.Experiment(
                name=f"run {i}", time=time, position=y + rng.normal(0, noise, count), input=np.zeros(count),
                added_mass=mass * part, spring="spring", damper="damper",
            )
        )  # fmt: skip
    return stepid.Campaign(name=f"rubs {seed}", experiments=runs, weight_uncertainty=weights or 1e-9)
