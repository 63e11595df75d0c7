"""Random plants, protocols and effect strengths of the kind that a teaching lab has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

Strengths = dict[str, dict[str, float]]
TABLE_1 = (
    # added weights, damper, spring, share of the step (less where the travel would not suffice)
    (2, "half", "medium", 1.0),
    (2, "full", "medium", 0.8),
    (2, "none", "medium", 1.0),
    (0, "half", "medium", 1.0),
    (1, "half", "medium", 1.0),
    (3, "half", "medium", 1.0),
    (4, "half", "medium", 1.0),
    (2, "half", "stiff", 1.0),
    (2, "half", "light", 0.8),
)
KINDS = ("four", "five", "nine", "release", "multi")
DRIVE = ("actuator_lag", "input_delay", "actuator_dead_zone", "actuator_saturation", "actuator_rate_limit")


@dataclass(frozen=True)
class Slot:
    """One run of a protocol: what is fixed before any effect is added."""

    name: str
    added_mass: float
    spring: str
    damper: str
    inputs: np.ndarray
    position: float = 0.0  # of a release


@dataclass(frozen=True)
class Setup:
    base_mass: float
    stiffness: dict[str, float]
    damping: dict[str, float]
    gain: float
    volts: float
    sample_time: float
    counts_per_meter: float
    slots: tuple[Slot, ...]
    kind: str
    reach: float = 0.0  # static displacement of the full step on the medium spring, m
    extra: Mapping[str, float] = field(default_factory=dict)

    @property
    def rate(self) -> float:
        return float(np.sqrt(self.stiffness["medium"] / (self.base_mass + self.slots[0].added_mass)))

    @property
    def middle_mass(self) -> float:
        return self.base_mass + float(np.mean([s.added_mass for s in self.slots]))


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def choose_kind(rng: np.random.Generator, effects: tuple[str, ...]) -> str:
    """A protocol that can show the effects at all."""
    weights = dict(zip(KINDS, (0.22, 0.33, 0.28, 0.08, 0.09), strict=True))
    if any(e in DRIVE for e in effects):
        weights["release"] = 0.0
    if {"actuator_dead_zone", "actuator_saturation", "actuator_rate_limit"} & set(effects):
        weights["four"] = 0.0  # with one step size they are only another gain, or a delay
    values = np.array(list(weights.values()))
    return str(rng.choice(list(weights), p=values / values.sum()))


def _records(
    rng: np.random.Generator, kind: str, volts: float, period: float, sample: float
) -> list[tuple[float, np.ndarray]]:
    """(weights, input) of each run of a protocol, before the labels of Table 1."""
    back = rng.random() < 0.7
    swings = float(rng.uniform(3.0, 7.0 if not back else 12.0))
    if kind == "nine":
        shares = [(w, s) for w, _, _, s in TABLE_1]
    elif kind == "five":
        shares = [(0, 1.0), (1, 1.0), (3, 1.0), (4, -1.0), (2, 0.6)]
    else:
        shares = [(0, 1.0), (1, 1.0), (3, 1.0), (4, 1.0)]
    runs = []
    for weights, share in shares:
        n = max(70, int(swings * period / sample * rng.uniform(0.85, 1.15)))
        n = min(n, 1300)
        first = 0 if rng.random() < 0.08 else int(rng.integers(1, 12))
        u = np.zeros(n)
        if kind == "multi":
            edges = np.sort(rng.choice(np.arange(first + 10, n - 10), size=int(rng.integers(1, 5)), replace=False))
            values = volts * rng.choice([-1.0, -0.5, 0.0, 0.4, 0.7, 1.0], size=edges.size + 1)
            values[0] = volts * share
            for begin, value in zip([first, *edges], values, strict=True):
                u[begin:] = value
            if rng.random() < 0.25:  # a pulse instead
                u[:] = 0
                u[first : first + max(4, int(0.3 * period / sample))] = volts * share
        elif kind != "release":
            u[first : n // 2 if back else n] = volts * share
        runs.append((float(weights), u))
    return runs


def draw_setup(rng: np.random.Generator, kind: str) -> Setup:
    """A plant and its protocol, spread like the labs that publish theirs."""
    base = _log(rng, 0.65, 1.3)
    unit = 0.5
    if rng.random() < 0.22:  # a bigger machine with bigger weights
        base, unit = base * (grow := _log(rng, 1.4, 3.5)), 0.5 * grow
        unit = round(unit, 5)
    rate = float(rng.uniform(11.5, 22.0))
    k = base * rate**2
    zeta = float(rng.choice([rng.uniform(0.08, 0.16), rng.uniform(0.16, 0.35), rng.uniform(0.35, 0.6)]))
    c = 2 * zeta * np.sqrt(k * base)
    period = 2 * np.pi / rate
    per = float(rng.choice([24, 48, 97])) * float(rng.uniform(0.93, 1.03))
    sample = float(f"{period / per:.9g}")
    volts = float(rng.choice([0.5, 1.0, 2.0]))
    reach = float(rng.uniform(0.008, 0.02))
    slots = []
    for i, (weights, u) in enumerate(_records(rng, kind, volts, period, sample)):
        _, damper, spring, _ = TABLE_1[i] if kind == "nine" else (0, "half", "medium", 1.0)
        start = float(rng.choice([-1, 1])) * reach * float(rng.uniform(0.7, 1.2)) if kind == "release" else 0.0
        slots.append(Slot(f"case {i + 1}", weights * unit, spring, damper, u, start))
    return Setup(
        base_mass=base,
        stiffness={"medium": k, "stiff": 2 * k, "light": 0.7 * k},
        damping={"half": c, "full": 1.8 * c, "none": 0.35 * c},
        gain=reach * k / volts,
        volts=volts,
        sample_time=sample,
        counts_per_meter=float(rng.choice([-1, 1])) * float(rng.choice([226600, 226600, 160410, 56000])),
        slots=tuple(slots),
        kind=kind,
        reach=reach,
    )


def _stop(rng: np.random.Generator, p: Setup, strength: float) -> dict[str, float]:
    sign = 1.0 if rng.random() < 0.8 or p.kind not in ("five", "release") else -1.0
    zeta = p.damping["half"] / 2 / np.sqrt(p.stiffness["medium"] * p.base_mass)
    peak = 1.0 if p.kind == "release" else 1 + np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2))
    depth = min(0.95, float(rng.uniform(0.15, 0.5)) * strength)  # share of the overshoot that is cut off
    position = p.reach * (1 + (peak - 1) * (1 - depth)) if p.kind != "release" else p.reach * 0.65 * (1.3 - depth)
    return {"stiffness": p.stiffness["medium"] * _log(rng, 3, 25), "position": sign * position}


def draw_effect(rng: np.random.Generator, name: str, p: Setup, strength: float = 1.0) -> dict[str, float]:
    """Parameters of one effect, of natural size at strength 1 and as good as proportional to strength."""
    k, c, push, rate = p.stiffness["medium"], p.damping["half"], p.stiffness["medium"] * p.reach, p.rate
    sign = float(rng.choice([-1, 1]))
    friction = min(0.2, strength * _log(rng, 0.01, 0.06)) * push
    if name == "coulomb_friction":
        return {"level": friction}
    if name == "load_proportional_friction":
        return {"coefficient": friction / 9.81 / p.middle_mass}
    if name == "stribeck_friction":
        level = 0.7 * friction
        return {"level": level, "breakaway": level * rng.uniform(1.4, 3.0), "velocity": _log(rng, 0.003, 0.03)}
    if name == "asymmetric_friction":
        ratio = rng.uniform(0.4, 0.75) ** sign
        return {"level_forward": friction, "level_backward": friction * ratio}
    if name == "presliding_hysteresis":
        return {"level": friction, "distance": _log(rng, 5e-5, 8e-4)}
    if name == "quadratic_damping":
        return {"coefficient": min(6.0, strength * rng.uniform(0.2, 1.0)) * c / (p.reach * rate)}
    if name == "position_dependent_damping":
        return {"slope": sign * min(0.45, strength * rng.uniform(0.1, 0.35)) / p.reach}
    if name == "cubic_stiffness":
        size = min(1.2, strength * rng.uniform(0.05, 0.4))
        size = size if rng.random() < 0.75 else -min(size / 4, 0.11)
        return {"coefficient": size * k / p.reach**2}
    if name == "quadratic_stiffness":
        return {"coefficient": sign * min(0.16, strength * rng.uniform(0.03, 0.13)) * k / p.reach}
    if name == "free_play":
        return {"gap": min(0.25, strength * rng.uniform(0.015, 0.1)) * p.reach}
    if name == "end_stop":
        return _stop(rng, p, strength)
    if name == "viscoelastic_spring":
        branch = min(1.0, strength * rng.uniform(0.05, 0.3)) * k
        return {"stiffness": branch, "damping": branch * _log(rng, 0.03, 0.4)}
    if name == "flexible_coupling":
        mass = min(0.6, strength * rng.uniform(0.1, 0.35)) * p.base_mass
        spring = mass * (p.rate * rng.uniform(2.2, 4.0)) ** 2
        return {"mass": mass, "stiffness": spring, "damping": 2 * rng.uniform(0.015, 0.06) * np.sqrt(spring * mass)}
    if name == "actuator_lag":
        return {"time_constant": min(0.06, strength * _log(rng, 0.003, 0.02))}
    if name == "input_delay":
        return {"delay": min(0.06, strength * _log(rng, 0.003, 0.02))}
    if name == "actuator_dead_zone":
        return {"level": min(0.45, strength * rng.uniform(0.03, 0.2)) * p.volts}
    if name == "actuator_saturation":
        return {"level": (1 - min(0.35, strength * rng.uniform(0.03, 0.2))) * p.volts}
    if name == "periodic_disturbance":
        top = min(8.0, 0.25 * 2 * np.pi / p.sample_time / rate)
        return {
            "amplitude": min(0.25, strength * rng.uniform(0.01, 0.07)) * push,
            "frequency": rate / 2 / np.pi * _log(rng, 1.4, top),
        }
    if name == "cogging":
        return {
            "amplitude": min(0.3, strength * rng.uniform(0.02, 0.1)) * push,
            "pitch": p.reach * rng.uniform(0.15, 0.45),
            "phase": float(rng.uniform(0, 2 * np.pi)),
        }
    if name == "sensor_drift":
        span = p.sample_time * float(np.mean([s.inputs.size for s in p.slots]))
        return {"rate": sign * min(0.5, strength * rng.uniform(0.02, 0.15)) * p.reach / span}
    return _new_effect(rng, name, p, strength, friction)


def _new_effect(rng: np.random.Generator, name: str, p: Setup, strength: float, friction: float) -> dict[str, float]:
    """The same for the effects of the second round."""
    if name == "sine_stiffness":
        share = strength * rng.uniform(0.01, 0.06)  # of the spring force that is missing at the full step
        return {"curvature": min(0.4 if p.kind == "multi" else 0.6, float(np.sqrt(6 * share))) / p.reach}
    if name == "power_damping":
        speed = p.reach * p.rate
        if rng.random() < 0.5:  # nearly dry, or more than viscous
            exponent, force = rng.uniform(0.3, 0.75), friction
        else:
            exponent = rng.uniform(1.5, 3.0)
            force = min(6.0, strength * rng.uniform(0.2, 1.0)) * p.damping["half"] * speed
        return {"coefficient": force / speed**exponent, "exponent": exponent}
    if name == "actuator_rate_limit":
        return {"rate": p.volts / min(0.12, strength * _log(rng, 0.006, 0.05))}
    raise KeyError(name)
