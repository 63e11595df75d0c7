"""How strong the laws of `laws` are: what a campaign shares of one, and what differs from run to run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .laws import Law

if TYPE_CHECKING:
    from .draw import Setup


@dataclass(frozen=True)
class Scale:
    """Magnitudes of a campaign that strengths are measured in: N, m, m/s, 1/s, N·s/m, N/m, s."""

    push: float
    reach: float
    speed: float
    rate: float
    damping: float
    stiffness: float
    lasts: float


def scale_of(setup: Setup) -> Scale:
    k = setup.stiffness["medium"]
    lasts = setup.sample_time * float(np.mean([s.inputs.size for s in setup.slots]))
    speed = setup.reach * setup.rate
    return Scale(k * setup.reach, setup.reach, speed, setup.rate, setup.damping["half"], k, lasts)


def draw_law(name: str, q: Scale, strength: float, common: np.random.Generator, own: np.random.Generator) -> Law:
    """The law in one run; `common` draws what the campaign shares, `own` what differs from run to run."""
    some = [float(w) for w in common.random(4)]
    side, phase = float(common.choice([-1, 1])), float(own.uniform(0, 2 * np.pi))
    a, b, c = some[:3]

    def capped(share: float, most: float) -> float:
        return min(most, strength * share)

    if name in ("eddy_brake", "saturating_damping", "memory_friction"):
        size, at = capped(0.03 + 0.15 * a, 0.8) * q.damping * q.speed, (0.12 + 0.4 * b) * q.speed
        if name == "memory_friction":
            late = (0.15 + 0.6 * c) / q.rate
            return Law(name, (min(size, 0.15 * q.push), at, late), max(1 / late, 0.3 * q.rate * q.speed / at))
        return Law(name, (size, at), 0.2 * q.rate * q.speed / at)
    if name == "detent":
        width = (0.08 + 0.2 * b) * q.reach
        return Law(name, (capped(0.02 + 0.08 * a, 0.4) * q.push, (0.2 + c) * q.reach, width), q.speed / width)
    if name == "preload":
        width = (0.03 + 0.1 * b) * q.reach
        return Law(name, (capped(0.02 + 0.1 * a, 0.3) * q.push, width), 0.5 * q.speed / width)
    if name == "log_spring":
        bend = (0.05 + 0.3 * b) * q.reach
        return Law(name, (capped(0.05 + 0.2 * a, 0.8) * q.push / float(np.log1p(q.reach / bend)), bend))
    if name == "exponential_spring":
        bend = (0.15 + 0.35 * b) * q.reach
        size = capped(0.02 + 0.1 * a, 0.5) * q.push / float(np.expm1(q.reach / bend))
        return Law(name, (size, side * bend), q.rate)
    if name == "two_way_damper":
        return Law(name, (side * capped(0.1 + 0.4 * a, 0.9) * q.damping,))
    if name == "bowl_damping":
        return Law(name, (capped(0.2 + 0.6 * a, 4.0) * q.damping, q.reach))
    if name == "two_relaxations":
        stiff = capped(0.03 + 0.12 * a, 0.5) * q.stiffness
        slow, quick = (2 + 8 * c) / q.rate, (0.05 + 0.2 * some[3]) / q.rate
        return Law(name, (stiff, stiff * (0.4 + b), slow, quick), 1 / quick)
    if name == "negative_damping":
        at = (0.1 + 0.3 * b) * q.speed
        return Law(name, (capped(0.15 + 0.4 * a, 0.8) * q.damping * at, at), 0.2 * q.rate * q.speed / at)
    return _draw_more(name, q, capped, (a, b, c), phase)


def _draw_more(
    name: str, q: Scale, capped: Callable[[float, float], float], some: tuple[float, ...], phase: float
) -> Law:
    a, b, c = some
    if name == "pumped_spring":
        omega = q.rate * (0.4 + b)
        return Law(name, (capped(0.02 + 0.1 * a, 0.3) * q.stiffness, omega, phase), omega)
    if name == "chirp":
        low, high = (0.3 + 0.7 * b) * q.rate, (2 + 4 * c) * q.rate
        return Law(name, (capped(0.01 + 0.05 * a, 0.25) * q.push, low, (high - low) / q.lasts, phase), high)
    if name == "viscous_pad":
        width = (0.03 + 0.07 * c) * q.reach
        return Law(name, (capped(0.3 + a, 5.0) * q.damping, (0.5 + 0.5 * b) * q.reach, width), 0.5 * q.speed / width)
    if name == "speed_droop":
        return Law(name, (capped(0.1 + 0.4 * a, 0.8) / q.speed,))
    if name == "fringe_field":
        return Law(name, (capped(0.05 + 0.2 * a, 0.3) / q.reach**2,))
    if name == "hot_motor":
        return Law(name, (capped(0.05 + 0.2 * a, 0.6), (0.1 + 0.4 * b) * q.lasts, q.push))
    if name == "escapement":
        width = (0.05 + 0.15 * b) * q.reach
        size = capped(0.03 + 0.15 * a, 0.4) * q.push
        return Law(name, (size, (0.2 + 0.5 * c) * q.reach, width, 0.1 * q.speed), q.speed / width)
    raise KeyError(name)


def by_sample(
    name: str,
    size: int,
    period: float,
    q: Scale,
    strength: float,
    common: np.random.Generator,
    own: np.random.Generator,
) -> dict[str, Any]:
    """Fields of a `Run`, sample by sample, for the laws that go on in time."""
    share, part = float(common.random()), np.arange(size) / size
    pace = float(common.uniform(0.1, 0.5))
    settle = -np.expm1(-part / pace)
    if name == "mass_leak":  # sand runs out of the cart
        return {"mass_scale": 1.0 - min(0.4, strength * (0.05 + 0.2 * share)) * part}
    if name == "thermal_spring":
        return {"stiffness_scale": 1.0 - min(0.4, strength * (0.02 + 0.1 * share)) * settle}
    if name == "damper_warming":  # the oil thins
        return {"damping_scale": 1.0 - min(0.8, strength * (0.1 + 0.4 * share)) * settle}
    if name == "wind":  # gusts: an Ornstein-Uhlenbeck force
        tau = float(common.uniform(0.5, 3.0)) / q.rate
        keep = float(np.exp(-period / tau))
        kicks, force = own.standard_normal(size), np.empty(size)
        force[0] = kicks[0]
        for i in range(1, size):
            force[i] = keep * force[i - 1] + np.sqrt(1 - keep**2) * kicks[i]
        return {"held_force": min(0.2, strength * (0.005 + 0.03 * share)) * q.push * force}
    raise KeyError(name)
