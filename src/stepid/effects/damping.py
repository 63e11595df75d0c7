"""Damping that is not linear."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stepid.effects.base import Effect, Moment, Motion, Parameter, Regressor, Scales, Values
from stepid.effects.swing import Swing

_VISCOUS = (0.85, 1.2)  # exponents that no recording tells from 1, beside viscous damping


def _least(scales: Scales) -> float:
    """The plant's damping, or a little of what it could have, N·s/m."""
    return scales.damping + 0.006 * math.sqrt(scales.mass * scales.stiffness)


class QuadraticDamping(Effect):
    """−c₂ v|v|."""

    name = "quadratic_damping"
    parameters = (Parameter("coefficient", "N·s²/m²"),)
    law = "−c₂ v|v|"
    formula = r"-c_2\, v |v|"
    symbols = ("c_2",)
    seen = "first swings shrink most, later ones hardly"
    advice = "open the damper's plug or take smaller steps; keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    reverses: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * _least(scales) / scales.velocity,) for share in (0.1, 0.6)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        return [Regressor((-m.v * np.abs(m.v),), lambda a: (a[0],) if a[0] > 0 else None)]

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * m.sign * m.v * m.v


class PowerDamping(Effect):
    """−c_p v (v² + ε²)^((p−1)/2), ε = 1e-6 m/s: viscous at p = 1, quadratic at 2, close to dry friction toward 0."""

    name = "power_damping"
    parameters = (Parameter("coefficient", "N·(s/m)^p"), Parameter("exponent", "", 0.3, 3.0))
    law = "−c_p v |v|^(p − 1)"
    formula = r"-c_p\, v\, |v|^{p-1}"
    symbols = ("c_p", "p")
    seen = "neither a straight nor an exponential envelope"
    advice = "find what the cart moves through (oil, air, a brush); keep it in the model"
    reverses: ClassVar[bool] = True
    power: ClassVar[tuple[int, int] | None] = (0, 1)
    contains = ("coulomb_friction", "quadratic_damping")  # the first as the limit p → 0

    def grow(self, inner: tuple[float, ...], scales: Scales) -> Sequence[tuple[float, ...]]:
        of_level = [(inner[0] * scales.velocity**-p, p) for p in (0.3, 0.6)]
        return [*of_level, *((inner[0] * scales.velocity ** (2.0 - p), p) for p in (1.7, 2.3))]

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.3 * _least(scales) * scales.velocity ** (1.0 - p), p) for p in (0.5, 1.5, 2.5)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        def at(exponent: float) -> Regressor:
            force = -np.sign(m.v) * np.abs(m.v) ** exponent
            return Regressor((force,), lambda a: (a[0], exponent) if a[0] > 0 else None)

        return [at(p) for p in (0.5, 1.4, 1.7, 2.4)]

    def imitates(self, values: tuple[float, ...], swing: Swing) -> str:
        return "the damper" if _VISCOUS[0] <= values[1] <= _VISCOUS[1] else ""

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * m.v * math.pow(m.v * m.v + 1e-12, 0.5 * (p[1] - 1.0))


class PositionDependentDamping(Effect):
    """−c β x v, on top of −c v."""

    name = "position_dependent_damping"
    parameters = (Parameter("slope", "1/m", -np.inf),)
    law = "−c β x v"
    formula = r"-c\,\beta\, x v"
    symbols = (r"\beta",)
    seen = "damping differs in and out (air damper)"
    advice = "center the damper's piston at the rest position; keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ()

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share / scales.displacement,) for share in (0.1, -0.1)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        return [Regressor((-m.damping * m.x * m.v,), lambda a: (a[0],))]

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -m.damping * p[0] * m.x * m.v
