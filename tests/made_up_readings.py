"""Small seeded campaigns for the tests of readings: a plant by closed form in pieces, with friction, rounded, noisy."""

from __future__ import annotations

import numpy as np

import stepid

RATE, SHARE = 15.0, 0.12  # 1/s and damping ratio without added mass
BASE, LEVEL = 1.0, 0.012  # kg, m
WEIGHTS = (0.0, 0.5, 1.5, 2.0)  # kg
FINE = 16  # steps a sample


def swing(
    n: int,
    sample: float,
    added: float,
    *,
    release: bool = False,
    friction: float = 0.0,
    shake: float = 0.0,
    at: float = 0.0,
) -> np.ndarray:
    """Positions, m: a step on at 8 samples and off halfway, or a release.

    Friction and the force that shakes the cart `at` so many Hz are shares of the force at the full step.
    """
    m, k, c = BASE + added, BASE * RATE**2, 2 * SHARE * RATE * BASE
    x, v = (LEVEL if release else 0.0), 0.0
    dry = friction * k * LEVEL
    out = np.empty(n)
    h = sample / FINE
    for i in range(n):
        out[i] = x
        push = k * LEVEL if not release and 8 <= i < n // 2 else 0.0
        for j in range(FINE):
            shaken = shake * k * LEVEL * np.sin(2 * np.pi * at * (i * sample + j * h)) if shake else 0.0
            total = push + shaken - k * x - c * v
            if v == 0 and abs(total) <= dry:
                continue
            sign = np.sign(v) if v else np.sign(total)
            w = v + h * (total - dry * sign) / m
            v = 0.0 if dry and v and w * v < 0 else w
            x += h * v
    return out


def runs(*, sample: float = 0.006, n: int = 450, release: bool = False, friction: float = 0.0) -> list[np.ndarray]:
    """Noise-free positions of four runs, m."""
    return [swing(n, sample, w, release=release, friction=friction) for w in WEIGHTS]


def force(frequency: float, share: float) -> list[np.ndarray]:
    """The same with a periodic force."""
    return [swing(450, 0.006, w, shake=share, at=frequency) for w in WEIGHTS]


def campaign(
    positions: list[np.ndarray], *, sample: float = 0.006, release: bool = False, counts: float | None = None
) -> stepid.Campaign:
    """Make a campaign of readings, rounded where counts per meter are given."""
    out = []
    for i, (x, w) in enumerate(zip(positions, WEIGHTS, strict=True)):
        u = np.zeros(x.size)
        if not release:
            u[8 : x.size // 2] = 1.0
        y = x if counts is None else np.round(x * counts) / counts
        out.append(
            stepid.Experiment(
                name=f"case {i + 1}",
                time=sample * np.arange(x.size),
                position=y,
                input=u,
                added_mass=w,
                spring="medium",
                damper="half",
                counts_per_meter=counts,
            )
        )
    return stepid.Campaign(name="made up", experiments=tuple(out))
