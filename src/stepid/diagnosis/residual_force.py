"""The force that the linear plant lacks, from the residual of its joint fit, and what it follows."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array, Index
from stepid.diagnosis.phases import BEFORE, REST
from stepid.effects.base import Motion
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.spectrum import strongest_period
from stepid.simulation.records import Records

_NOISE = 0.25  # of the force: noise that may be left in it before averaging
_WIDEST = 0.2  # of the period: half width of the widest bump
_WIDER = 1.1  # times as wide a bump where one is too narrow
_SAMPLES = 40  # the least that tell a shape
SHAPES = ("sign of velocity", "velocity squared", "position squared", "position cubed")
CLEAR = 0.4  # share of the variance that a shape must explain to be named


class ResidualForce(NamedTuple):
    """The force that the linear plant lacks, N, and the motion it acts in, averaged alike; shape (k,) each.

    `features` (len(SHAPES), k) are the forces that it may follow, for a coefficient of one; `time`, s, and `run`, the
    index of the record, tell where each sample comes from.
    """

    force: Array
    x: Array
    v: Array
    volts: Array
    features: Array
    time: Array
    run: Array


def residual_force(records: Records, linear: Optimum, motion: Motion, phase: Index, floor: float) -> ResidualForce:
    """Force that would produce the residual: f = m r″ + c r′ + k r while the cart moves.

    The residual may be that of any fit; the motion then holds its mass, stiffness and damping.
    The residual is averaged with a bump φ, whose derivatives stand in for those of the residual (the weak form), so
    that noise is not differentiated; the motion is averaged with the same φ. The bump is as narrow as the noise allows.
    """
    residual, period = linear.residual, strongest_period(records)
    parts: list[list[Array]] = []
    for r, piece in enumerate(records.pieces()):
        h, values = records.evenly(r, residual)
        mass, stiffness, damping = (float(q[piece][0]) for q in (motion.mass, motion.stiffness, motion.damping))
        here = np.rint(records.evenly(r, phase.astype(np.float64))[1])
        x, v, volts, sign = (records.evenly(r, q)[1] for q in (motion.x, motion.v, motion.volts, motion.sign))
        time = records.evenly(r, motion.time)[1]
        signals = (x, v, volts, sign, v * np.abs(v), x**2, x**3, time, np.full(x.size, float(r)))
        found = _narrowest(values, (mass, damping, stiffness), h, floor, period)
        if found is None:
            continue
        half, kernel, force = found
        inner = slice(half, values.size - half)
        moves = (here[inner] != REST) & (here[inner] != BEFORE)
        parts.append([force[moves], *(_averaged(signal, kernel)[moves] for signal in signals)])
    if not parts:
        empty = np.zeros(0)
        return ResidualForce(empty, empty, empty, empty, np.zeros((len(SHAPES), 0)), empty, empty)
    joined = [np.concatenate(column) for column in zip(*parts, strict=True)]
    last = 4 + len(SHAPES)
    force, x, v, volts = joined[:4]
    return ResidualForce(force, x, v, volts, np.array(joined[4:last]), joined[last], np.rint(joined[last + 1]))


def _narrowest(
    residual: Array, plant: tuple[float, float, float], sample_time: float, floor: float, period: float
) -> tuple[int, Array, Array] | None:
    """Half width of the narrowest bump that noise allows, the bump, and the force; None for too short a record."""
    mass, damping, stiffness = plant
    half, most = 3, max(3, min(int(_WIDEST * period / sample_time), (residual.size // 3 - 1) // 2))
    while 2 * half + 1 <= residual.size:
        kernel, first, second = bump(half, sample_time)
        weight = mass * second + damping * first + stiffness * kernel
        force = _averaged(residual, weight)
        if half >= most or floor * float(np.linalg.norm(weight)) < _NOISE * float(np.std(force)):
            return half, kernel, force
        half = min(max(half + 1, round(_WIDER * half)), most)
    return None


def _averaged(values: Array, kernel: Array) -> Array:
    """Convolution where the kernel is within the record, by transforms where that is faster."""
    from scipy.signal import convolve

    out: Array = convolve(values, kernel, "valid")
    return out


@lru_cache(maxsize=128)
def bump(half: int, sample_time: float) -> tuple[Array, Array, Array]:
    """φ = (1 − s²)⁴ of area 1 and its first two derivatives by time, as kernels of a convolution.

    The derivatives are corrected to be exact for a parabola on so few samples.
    """
    s = np.arange(-half, half + 1) / (half + 1)
    time, q = s * (half + 1) * sample_time, 1 - s**2
    kernel = q**4 / np.sum(q**4)
    first = -s * q**3
    second = 6 * s**2 * q**2 - q**3
    second = second - kernel * second.sum()
    out = kernel, first / -(first @ time), 2 * second / (second @ time**2)
    for values in out:  # they are kept
        values.setflags(write=False)
    return out


class Shape(NamedTuple):
    """What the residual force follows best, beyond what a linear plant could take up.

    `name` is one of `SHAPES`, `coefficient` its factor (N over the power of m or m/s), `share` the part of the variance
    that it explains. `taken` is the force [N] on the same samples that the linear fit has put into its own parameters
    in place of the shape.
    """

    name: str
    coefficient: float
    share: float
    taken: Array


def shape(force: ResidualForce) -> Shape | None:
    """Find the shape that the residual force follows best; None where there is too little motion to tell."""
    if force.force.size < _SAMPLES:
        return None
    plain = np.column_stack([np.ones_like(force.x), force.x, force.v, force.volts])  # what a linear plant can take up
    scale = np.linalg.norm(plain, axis=0)
    basis, size, _ = np.linalg.svd(plain / np.where(scale > 0, scale, 1.0), full_matrices=False)
    basis = basis[:, size > 1e-9 * size[0]]

    def inside(values: Array) -> Array:
        out: Array = basis @ (basis.T @ values)
        return out

    left = force.force - inside(force.force)
    found = []
    for name, values in zip(SHAPES, force.features, strict=True):
        other = values - inside(values)
        power = float(other @ other)
        if power > 1e-12 * float(values @ values):
            along = float(other @ left)
            share = along**2 / power / max(float(left @ left), 1e-300)
            found.append(Shape(name, along / power, share, inside(force.force - along / power * values)))
    return max(found, key=lambda one: one.share, default=None)
