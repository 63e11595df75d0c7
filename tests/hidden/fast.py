"""Runs in micro-steps of classical Runge-Kutta, each change of mode located by a bracketed secant; see `steps`.

Another formulation than `reference`: the bristle force is the closed form along each branch between reversals, the
lagged drive is the exact exponential, and a delayed input splits each sample in two; a drive that changes within a
sample splits it at each of its corners.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .drive import course, is_curved
from .equations import begin, cart_of
from .plant import SLOWEST, Run
from .steps import follow

FINENESS = 0.05  # micro-step times the fastest rate of the run


def micro_steps(run: Run, fineness: float = FINENESS) -> int:
    """Micro-steps a sample, a power of two, from the fastest rate that the run's effects can show."""
    m, k = run.mass, run.stiffness
    stiff = k + run.get("viscoelastic_spring", "stiffness") + run.get("flexible_coupling", "stiffness")
    stiff += run.get("end_stop", "stiffness")
    swing = 2.2 * float(np.max(np.abs(run.drive))) / k + abs(run.start)
    stiff += 3 * abs(run.get("cubic_stiffness", "coefficient")) * swing**2
    stiff += 2 * abs(run.get("quadratic_stiffness", "coefficient")) * swing
    if run.stiffness_scale is not None:
        stiff *= float(np.max(run.stiffness_scale))
    pull = k * swing / m
    speed = swing * np.sqrt(k / m)
    drag = run.damping + 2 * run.get("quadratic_damping", "coefficient") * speed
    rates = [drag / m, 2 * np.pi * run.get("periodic_disturbance", "frequency")]
    if "flexible_coupling" in run.effects:
        m2 = run.get("flexible_coupling", "mass")
        rates.append(np.sqrt(run.get("flexible_coupling", "stiffness") / m2 * (1 + m2 / m)))
        rates.append(run.get("flexible_coupling", "damping") / m2)
    if "viscoelastic_spring" in run.effects:
        rates.append(run.get("viscoelastic_spring", "stiffness") / run.get("viscoelastic_spring", "damping"))
    if "presliding_hysteresis" in run.effects:
        distance = run.get("presliding_hysteresis", "distance")
        stiff += run.get("presliding_hysteresis", "level") / distance
        rates.append(0.4 * np.sqrt(pull / distance))
    if "stribeck_friction" in run.effects:
        rates.append(0.1 * pull / run.get("stribeck_friction", "velocity"))
    if "cogging" in run.effects:
        turn = 2 * np.pi / run.get("cogging", "pitch")
        stiff += run.get("cogging", "amplitude") * turn
        rates.append(0.12 * speed * turn)
    if "sine_stiffness" in run.effects:
        rates.append(speed * run.get("sine_stiffness", "curvature"))
    if "power_damping" in run.effects:
        p, drag = run.get("power_damping", "exponent"), run.get("power_damping", "coefficient") / m
        slowest = 0.03 * drag * SLOWEST ** (p - 1) if p < 1 else p * drag * speed ** (p - 1)
        rates.append(max(slowest, 0.05 * 32 / run.sample_time if p < 2 else 0.0))
    if run.sticky is not None:
        rates.append(speed / run.sticky[2])
    if run.law is not None:
        rates.append(0.2 * run.law.rate)
    if run.lag:
        rates.append(0.3 / run.lag)
    rates.append(np.sqrt(stiff / m))
    wanted = run.sample_time * max(rates) / fineness
    return int(2 ** np.ceil(np.log2(np.clip(wanted, 4, 1024))))


def _pieces(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """When each piece of the drive begins, and its cubic; one a sample where the drive is held."""
    if is_curved(run):
        before, pieces = course(run)
        begins = np.array([-np.inf, *(t for t, _ in pieces)])
        return begins, np.array([[before, 0.0, 0.0, 0.0], *(curve for _, curve in pieces)])
    delay, period = run.get("input_delay", "delay"), run.sample_time
    whole = int(np.floor(delay / period + 1e-12))
    drive, samples = np.roll(run.drive, 1), np.arange(run.size)
    curves = np.zeros((run.size + 1, 4))
    curves[0, 0] = drive[0]
    curves[1:, 0] = drive[np.maximum(samples - whole + 1, 0)]
    return np.array([-np.inf, *(samples * period + max(delay - whole * period, 0.0))]), curves


def _held(run: Run) -> np.ndarray:
    fields = ((run.held_force, 0.0), (run.stiffness_scale, 1.0), (run.mass_scale, 1.0), (run.damping_scale, 1.0))
    return np.array([np.full(run.size, blank) if v is None else np.asarray(v, float) for v, blank in fields])


def _one(run: Run, fineness: float) -> np.ndarray:
    cart = cart_of(run)
    y, now = begin(run, cart)
    x = follow(cart, now, y, *_pieces(run), _held(run), float(run.sample_time), micro_steps(run, fineness))
    return np.asarray(x + run.get("sensor_drift", "rate") * np.arange(run.size) * run.sample_time)


def fast(runs: Sequence[Run], *, fineness: float = FINENESS) -> list[np.ndarray]:
    """Reading at each sample of each run, m, from the spring's rest position; NaN after one runs away."""
    return [_one(run, fineness) for run in runs]
