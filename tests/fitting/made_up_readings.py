"""Small seeded campaigns for the tests of readings: a plant by closed form in pieces, with friction, rounded, noisy."""

from __future__ import annotations

import numpy as np

import stepid

RATE, SHARE = 15.0, 0.12  # 1/s and damping ratio without added mass
BASE = 1.0


def swing(
    n: int, sample: float, added: float, *, release: bool, friction: float = 0.0, level: float = 0.012
) -> np.ndarray:
    """Positions, m: a step on at 8 samples and off halfway, or a release; friction as a share of the spring's force."""
    fine = 16
    m = BASE + added
    k, c = BASE * RATE**2, 2 * SHARE * RATE * BASE
    x, v = (level if release else 0.0), 0.0
    out = np.empty(n)
    h = sample / fine
    for i in range(n):
        out[i] = x
        push = k * level if not release and 8 <= i < n // 2 else 0.0
        for _ in range(fine):
            force = push - k * x - c * v
            dry = friction * k * level
            if v == 0 and abs(force) <= dry:
                continue
            sign = np.sign(v) if v else np.sign(force)
            w = v + h * (force - dry * sign) / m
            v = 0.0 if dry and v and w * v < 0 else w
            x += h * v
    return out


def runs(
    seed: int, *, sample: float = 0.006, n: int = 500, release: bool = False, friction: float = 0.0
) -> list[np.ndarray]:
    """Noise-free positions of four runs with 0, 0.5, 1.5 and 2 kg added."""
    return [swing(n, sample, w, release=release, friction=friction) for w in (0.0, 0.5, 1.5, 2.0)]


def campaign(
    positions: list[np.ndarray], *, sample: float = 0.006, release: bool = False, counts: float | None = None
) -> stepid.Campaign:
    """Make a campaign of readings, rounded where counts per meter are given."""
    out = []
    for i, (x, w) in enumerate(zip(positions, (0.0, 0.5, 1.5, 2.0), strict=True)):
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
