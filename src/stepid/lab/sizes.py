"""Natural sizes of the catalogue's effects on a lab rig, as good as proportional to a strength."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from stepid.effects.friction import GRAVITY
from stepid.lab.rig import Scale

Values = dict[str, float]
Size = Callable[[np.random.Generator, Scale, float], Values]


def _log(stream: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(stream.uniform(np.log(low), np.log(high))))


def _sign(stream: np.random.Generator) -> float:
    return float(stream.choice([-1.0, 1.0]))


def _friction(at: Scale, strength: float) -> float:
    return min(0.03 * strength, 0.25) * at.plant.stiffness * at.reach


def _load(_: np.random.Generator, at: Scale, strength: float) -> Values:
    return {"coefficient": _friction(at, strength) / GRAVITY / at.heavy}


def _stribeck(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    level = 0.7 * _friction(at, strength)
    return {
        "level": level,
        "breakaway": level * float(stream.uniform(1.5, 2.5)),
        "velocity": _log(stream, 0.02, 0.1) * at.reach * at.rate,
    }


def _asymmetric(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    strong = _friction(at, strength)
    weak = strong * float(stream.uniform(0.3, 0.6))
    forward, backward = (strong, weak) if _sign(stream) > 0 else (weak, strong)
    return {"level_forward": forward, "level_backward": backward}


def _presliding(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    return {"level": _friction(at, strength), "distance": _log(stream, 0.01, 0.05) * at.reach}


def _quadratic_damping(_: np.random.Generator, at: Scale, strength: float) -> Values:
    return {"coefficient": min(0.5 * strength, 6.0) * at.plant.damping / (at.reach * at.rate)}


def _position_damping(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    return {"slope": _sign(stream) * min(0.2 * strength, 0.45) / at.reach}


def _cubic(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    # a softening spring beyond its hill has no way back
    size = min(0.1 * strength, 1.0) if _sign(stream) > 0 else -min(0.05 * strength, 0.11)
    return {"coefficient": size * at.plant.stiffness / at.reach**2}


def _quadratic_stiffness(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    return {"coefficient": _sign(stream) * min(0.05 * strength, 0.15) * at.plant.stiffness / at.reach}


def _sine(_: np.random.Generator, at: Scale, strength: float) -> Values:
    # as much of the spring force is missing at the full step; beyond the hill of the sine there is no way back
    return {"curvature": math.sqrt(6 * min(0.04 * strength, 0.08)) / at.reach}


def _power_damping(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    speed = at.reach * at.rate
    if _sign(stream) < 0:  # nearly dry, or more than viscous
        exponent, force = float(stream.uniform(0.3, 0.75)), _friction(at, strength)
    else:
        exponent, force = float(stream.uniform(1.6, 3.0)), min(0.5 * strength, 6.0) * at.plant.damping * speed
    return {"coefficient": force / speed**exponent, "exponent": exponent}


def _free_play(_: np.random.Generator, at: Scale, strength: float) -> Values:
    return {"gap": min(0.03 * strength, 0.25) * at.reach}


def _end_stop(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    # below the farthest overshoot, so that some peaks are clipped
    return {
        "stiffness": at.plant.stiffness * _log(stream, 3.0, 12.0),
        "position": at.peak * (1 - min(0.05 * strength, 0.4)),
    }


def _viscoelastic(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    branch = min(0.15 * strength, 1.0) * at.plant.stiffness
    return {"stiffness": branch, "damping": branch * _log(stream, 0.1, 0.4)}


def _coupling(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    mass = min(0.1 * strength, 0.5) * at.plant.mass
    spring = mass * (at.rate * float(stream.uniform(1.6, 2.6))) ** 2
    return {"mass": mass, "stiffness": spring, "damping": 0.04 * math.sqrt(spring * mass)}


def _ripple(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    return {
        "amplitude": min(0.03 * strength, 0.25) * at.plant.stiffness * at.reach,
        "frequency": at.rate / 2 / math.pi * _log(stream, 1.4, 3.0),
    }


def _cogging(stream: np.random.Generator, at: Scale, strength: float) -> Values:
    return {
        "amplitude": min(0.05 * strength, 0.3) * at.plant.stiffness * at.reach,
        "pitch": at.reach * float(stream.uniform(0.15, 0.4)),
        "phase": float(stream.uniform(0, 2 * math.pi)),
    }


SIZES: Mapping[str, Size] = MappingProxyType(
    {
        "coulomb_friction": lambda _, at, strength: {"level": _friction(at, strength)},
        "load_proportional_friction": _load,
        "stribeck_friction": _stribeck,
        "asymmetric_friction": _asymmetric,
        "presliding_hysteresis": _presliding,
        "quadratic_damping": _quadratic_damping,
        "power_damping": _power_damping,
        "position_dependent_damping": _position_damping,
        "cubic_stiffness": _cubic,
        "quadratic_stiffness": _quadratic_stiffness,
        "sine_stiffness": _sine,
        "free_play": _free_play,
        "end_stop": _end_stop,
        "viscoelastic_spring": _viscoelastic,
        "flexible_coupling": _coupling,
        "actuator_lag": lambda _, at, strength: {"time_constant": min(0.1 * strength, 1.0) / at.rate},
        "input_delay": lambda _, at, strength: {"delay": min(0.1 * strength, 1.0) / at.rate},
        "actuator_dead_zone": lambda _, at, strength: {"level": min(0.05 * strength, 0.4) * at.volts},
        "actuator_saturation": lambda _, at, strength: {"level": (1 - min(0.05 * strength, 0.35)) * at.volts},
        "actuator_rate_limit": lambda _, at, strength: {"rate": at.volts * at.rate / min(0.4 * strength, 3.0)},
        "periodic_disturbance": _ripple,
        "cogging": _cogging,
        "sensor_drift": lambda stream, at, strength: {
            "rate": _sign(stream) * min(0.05 * strength, 0.5) * at.reach / at.duration
        },
    }
)
"""Canonical name to the effect's parameter values at a strength of about 1; shapes are drawn from the stream."""
