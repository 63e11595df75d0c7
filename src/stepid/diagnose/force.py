"""The force that the linear plant lacks, from the residual of its joint fit, and what it follows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stepid._base import Array
from stepid.diagnose.phases import BEFORE, REST
from stepid.effects.base import Motion
from stepid.engine.least_squares import Optimum
from stepid.engine.problem import strongest_period
from stepid.engine.records import Index, Records

_NOISE = 0.25  # of the force: noise that may be left in it before averaging
_WIDEST = 0.2  # of the period: half width of the widest bump
_SAMPLES = 40  # the least that tell a shape
CLEAR = 0.4  # share of the variance that a shape must explain to be named


class ResidualForce(NamedTuple):
    """The force that the linear plant lacks, N, and the motion it acts in, averaged alike; shape (k,) each."""

    force: Array
    x: Array
    v: Array
    direction: Array
    volts: Array


def residual_force(records: Records, linear: Optimum, motion: Motion, phase: Index, floor: float) -> ResidualForce:
    """Force that would produce the residual: f = m r″ + c r′ + k r while the cart moves.

    The residual is averaged with a bump φ, whose derivatives stand in for those of the residual (the weak form), so
    that noise is not differentiated; the motion is averaged with the same φ. The bump is as narrow as the noise allows.
    """
    residual, period = linear.residual, strongest_period(records)
    parts: list[ResidualForce] = []
    for r, piece in enumerate(records.pieces()):
        h = float(records.sample_time[r])
        mass, stiffness, damping = (float(q[piece][0]) for q in (motion.mass, motion.stiffness, motion.damping))
        values, here = residual[piece], phase[piece]
        signals = (motion.x[piece], motion.v[piece], motion.sign[piece], motion.volts[piece])
        half = 3
        while True:
            kernel, first, second = _bump(half, h)
            weight = mass * second + damping * first + stiffness * kernel
            noise = floor * float(np.linalg.norm(weight))
            widest = (half + 1) * h > _WIDEST * period or 2 * (half + 1) + 1 > values.size // 3
            if widest or 2 * half + 1 > values.size:
                break
            force = np.convolve(values, weight, "valid")
            if noise < _NOISE * float(np.std(force)):
                break
            half += 1
        if 2 * half + 1 > values.size:
            continue
        force = np.convolve(values, weight, "valid")
        inner = slice(half, values.size - half)
        moves = (here[inner] != REST) & (here[inner] != BEFORE)
        x, v, direction, volts = (np.convolve(s, kernel, "valid")[moves] for s in signals)
        parts.append(ResidualForce(force[moves], x, v, direction, volts))
    if not parts:
        return ResidualForce(*[np.zeros(0)] * 5)
    return ResidualForce(*(np.concatenate([part[i] for part in parts]) for i in range(5)))


def _bump(half: int, sample_time: float) -> tuple[Array, Array, Array]:
    """φ = (1 − s²)⁴ of area 1 and its first two derivatives by time, as kernels of a convolution."""
    s = np.arange(-half, half + 1) / (half + 1)
    width, q = (half + 1) * sample_time, 1 - s**2
    area = float(np.sum(q**4))
    return q**4 / area, -8 * s * q**3 / (width * area), (48 * s**2 * q**2 - 8 * q**3) / (width**2 * area)


class Shape(NamedTuple):
    """What the residual force follows best, beyond what a linear plant could take up.

    `name` is ``"sign of velocity"``, ``"velocity squared"``, ``"position squared"`` or ``"position cubed"``,
    `coefficient` its factor (N over the power of m or m/s), `share` the part of the variance that it explains. `taken`
    is the force [N] on the same samples that the linear fit has put into its own parameters in place of the shape.
    """

    name: str
    coefficient: float
    share: float
    taken: Array


def shape(force: ResidualForce) -> Shape | None:
    """Find the shape that the residual force follows best; None where there is too little motion to tell."""
    if force.force.size < _SAMPLES:
        return None
    x, v = force.x, force.v
    plain = np.column_stack([np.ones_like(x), x, v, force.volts])  # what a linear plant can take up
    scale = np.linalg.norm(plain, axis=0)
    basis, size, _ = np.linalg.svd(plain / np.where(scale > 0, scale, 1.0), full_matrices=False)
    basis = basis[:, size > 1e-9 * size[0]]

    def inside(values: Array) -> Array:
        out: Array = basis @ (basis.T @ values)
        return out

    left = force.force - inside(force.force)
    found = []
    features = {
        "sign of velocity": force.direction,
        "velocity squared": v * np.abs(v),
        "position squared": x**2,
        "position cubed": x**3,
    }
    for name, values in features.items():
        other = values - inside(values)
        power = float(other @ other)
        if power > 1e-12 * float(values @ values):
            along = float(other @ left)
            share = along**2 / power / max(float(left @ left), 1e-300)
            found.append(Shape(name, along / power, share, inside(force.force - along / power * values)))
    return max(found, key=lambda one: one.share, default=None)
