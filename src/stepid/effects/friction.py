"""Dry friction in its forms: constant, load-proportional, Stribeck, asymmetric, presliding."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import ClassVar

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Moment, Motion, Parameter, Regressor, Scales, Values

GRAVITY = 9.81  # m/s²
_SHARES = (0.01, 0.04, 0.12)  # of the largest spring force


class _DryFriction(Effect):
    dry: ClassVar[bool] = True
    reverses: ClassVar[bool] = True
    rests_anywhere: ClassVar[bool] = True


def _direction(scales: Scales, m: Motion) -> Array:
    """Sign of the measured velocity, softened where noise hides it."""
    return np.clip(m.v / (0.02 * scales.velocity), -1.0, 1.0)


def _directions(scales: Scales, m: Motion) -> tuple[Array, Array]:
    """Direction of the friction by the two ends of what it may do to a cart at rest: nothing, and all that it can.

    That keeps the direction of the last motion: a cart that creeps to its rest is held so.
    """
    soft = _direction(scales, m)
    begins = np.diff(m.time, prepend=np.inf) <= 0
    known = (np.abs(soft) == 1.0) | begins
    last = np.maximum.accumulate(np.where(known, np.arange(soft.size), 0))
    held = np.where(begins[last], 0.0, soft[last])
    return soft, held


class CoulombFriction(_DryFriction):
    """−F_c sign(v), and sticking within ±F_c at rest."""

    name = "coulomb_friction"
    parameters = (Parameter("level", "N"),)
    law = "−F_c sign(v)"
    formula = r"-F_c\,\mathrm{sign}(v)"
    symbols = ("F_c",)
    seen = "straight-line envelope, dead stop off zero, c and K that drift with mass in the paper's table"
    advice = "clean and align the rails, oil the bearings; keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    affine: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.force,) for share in _SHARES]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        return [Regressor((-d,), lambda a: (a[0],) if a[0] > 0 else None) for d in _directions(scales, m)]

    @staticmethod
    def friction(p: Values, m: Moment) -> float:
        return p[0]


class LoadProportionalFriction(_DryFriction):
    """Coulomb friction with F_c = μ m g, m the moving mass of the run."""

    name = "load_proportional_friction"
    parameters = (Parameter("coefficient", "", length=1.0),)
    law = "−μ m g sign(v)"
    formula = r"-\mu\, m g\,\mathrm{sign}(v)"
    symbols = (r"\mu",)
    seen = "as Coulomb friction, growing with added mass"
    advice = "the friction sits under the cart's weight: check wheels and rails, keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    affine: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.force / (scales.mass * GRAVITY),) for share in _SHARES]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        weight = m.mass * GRAVITY
        return [Regressor((-d * weight,), lambda a: (a[0],) if a[0] > 0 else None) for d in _directions(scales, m)]

    @staticmethod
    def friction(p: Values, m: Moment) -> float:
        return p[0] * GRAVITY * m.mass


class StribeckFriction(_DryFriction):
    """Friction that falls from F_s at rest to F_c with exp(−(v/v_s)²); with F_s below F_c it is Coulomb friction."""

    name = "stribeck_friction"
    parameters = (Parameter("level", "N"), Parameter("breakaway", "N"), Parameter("velocity", "m/s", 1e-5))
    law = "−(F_c + (F_s − F_c) exp(−(v/v_s)²)) sign(v)"
    formula = r"-(F_c + (F_s - F_c)\, e^{-(v/v_s)^2})\,\mathrm{sign}(v)"
    symbols = ("F_c", "F_s", "v_s")
    seen = "stick-slip, longer dead stops"
    advice = "thin the lubricant, dither the drive; keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    contains = ("coulomb_friction",)

    def grow(self, inner: tuple[float, ...], scales: Scales) -> Sequence[tuple[float, ...]]:
        return [
            (0.8 * inner[0], times * inner[0], part * scales.velocity) for times in (1.3, 2.2) for part in (0.02, 0.1)
        ]

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [
            (share * scales.force, 2.0 * share * scales.force, part * scales.velocity)
            for share in (0.01, 0.05)
            for part in (0.02, 0.1)
        ]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        sign = _direction(scales, m)

        def at(velocity: float) -> Regressor:
            return Regressor(
                (-sign, -sign * np.exp(-np.square(m.v / velocity))),
                lambda a: (a[0], a[0] + a[1], velocity) if a[0] > 0 and a[1] > 0 else None,
            )

        return [at(part * scales.velocity) for part in (0.02, 0.05, 0.12, 0.3)]

    @staticmethod
    def friction(p: Values, m: Moment) -> float:
        return p[0] + max(p[1] - p[0], 0.0) * math.exp(-((m.v / p[2]) ** 2))

    @staticmethod
    def breakaway(p: Values, m: Moment) -> float:
        return max(p[0], p[1])


class AsymmetricFriction(_DryFriction):
    """Coulomb friction with different levels forward and backward."""

    name = "asymmetric_friction"
    parameters = (Parameter("level_forward", "N"), Parameter("level_backward", "N"))
    law = "−F_c⁺ for v > 0, +F_c⁻ for v < 0"
    formula = r"-F_c^+ \;\mathrm{for}\; v > 0, \quad +F_c^- \;\mathrm{for}\; v < 0"
    symbols = ("F_c^+", "F_c^-")
    seen = "halves of the envelope shrink differently"
    advice = "look for a tilted rail or a one-sided seal; record steps in both directions"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    affine: ClassVar[bool] = True
    contains = ("coulomb_friction",)

    def grow(self, inner: tuple[float, ...], scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(up * inner[0], (2 - up) * inner[0]) for up in (0.9, 1.1)]

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [
            (forward * share * scales.force, (1 - forward) * share * scales.force)
            for share in (0.03, 0.15)
            for forward in (0.3, 0.7)
        ]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        sign = _direction(scales, m)
        forces = (-np.maximum(sign, 0.0), -np.minimum(sign, 0.0))
        return [Regressor(forces, lambda a: (a[0], a[1]) if min(a) > 0 else None)]

    @staticmethod
    def friction(p: Values, m: Moment) -> float:
        return p[0] if m.sign > 0 else p[1]


class PreslidingHysteresis(Effect):
    """Friction that builds up over a small displacement (Bouc–Wen, n = 1, β = γ).

    z′ = v(1 − max(0, sign(v)·z/distance)) depends on the path only, so z is a closed form of the displacement.
    """

    name = "presliding_hysteresis"
    parameters = (Parameter("level", "N"), Parameter("distance", "m", 5e-6))
    law = "−F z/d, z′ = v(1 − max(0, sign(v) z/d))"
    formula = r"-F z/d, \quad \dot z = v\,(1 - \max(0,\, \mathrm{sign}(v)\, z/d))"
    symbols = ("F", "d")
    seen = "stiff at small moves, loops"
    advice = "keep it in the model; before a record that begins at rest, let the cart make one full swing"
    own_units: ClassVar[tuple[str, ...] | None] = ("m",)
    reverses: ClassVar[bool] = True
    n_memory: ClassVar[int] = 1
    n_switches: ClassVar[int] = 1  # loading and unloading differ in their curvature
    contains = ("coulomb_friction",)

    def grow(self, inner: tuple[float, ...], scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(inner[0], part * scales.displacement) for part in (0.003, 0.02)]

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.03 * scales.force, part * scales.displacement) for part in (0.003, 0.02, 0.1)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        def at(distance: float, built: Array) -> Regressor:
            return Regressor((-built / distance,), lambda a: (a[0], distance) if a[0] > 0 else None)

        distances = [part * scales.displacement for part in (0.005, 0.02, 0.08)]
        return [at(*one) for one in zip(distances, self._along(distances, m), strict=True)]

    def _along(self, distances: Sequence[float], m: Motion) -> Array:
        """Memories along a path of several runs, each from none, one a distance, shape (k, S)."""
        distance = np.array(distances)[:, None]
        built = np.zeros((distance.size, m.x.size))
        begins = np.flatnonzero(np.diff(m.time, prepend=np.inf) <= 0).tolist()
        for first, end in pairwise([*begins, m.x.size]):
            x, z = m.x[first:end], built[:, first:end]
            turns = np.flatnonzero(np.diff(np.sign(np.diff(x)))) + 1
            for turn, to in pairwise([0, *turns.tolist(), x.size - 1]):  # `remember`, of a stretch at once
                sign = 1.0 if x[to] > x[turn] else -1.0
                along, path = sign * z[:, turn : turn + 1], np.abs(x[turn : to + 1] - x[turn])
                free = np.maximum(-along, 0.0)
                loaded = distance - (distance - np.maximum(along, 0.0)) * np.exp((free - path) / distance)
                z[:, turn : to + 1] = sign * np.where(path < free, along + path, loaded)
        return built

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * m.memory[0] / p[1]

    @staticmethod
    def switches(p: Values, m: Moment) -> tuple[float, ...]:
        return (m.memory[0],)

    @staticmethod
    def remember(p: Values, memory: tuple[float, ...], shift: float, sign: float) -> tuple[float, ...]:
        distance = p[1]
        along = sign * memory[0]
        path = abs(shift)
        free = max(-along, 0.0)  # unloading is elastic until z = 0
        if path < free:
            return (sign * (along + path),)
        built = max(along, 0.0)
        return (sign * (distance - (distance - built) * math.exp(-(path - free) / distance)),)

    @staticmethod
    def memory_slopes(p: Values, m: Moment) -> tuple[float, ...]:
        return (1.0 - max(m.sign * m.memory[0] / p[1], 0.0),)
