"""Damping that is not linear."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Motion, Parameter, Regressor, Scales, Values


class QuadraticDamping(Effect):
    """−c₂ v|v|."""

    name = "quadratic_damping"
    parameters = (Parameter("coefficient", "N·s²/m²"),)
    law = "−c₂ v|v|"
    formula = r"-c_2\, v |v|"
    symbols = ("c_2",)
    seen = "first swings shrink most, later ones hardly"
    advice = "open the damper's plug or take smaller steps; keep it in the model"
    reverses: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * (scales.damping + 0.1) / scales.velocity,) for share in (0.1, 0.6)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        return [Regressor((-m.v * np.abs(m.v),), lambda a: (a[0],) if a[0] > 0 else None)]

    def force(self, p: Values, m: Motion) -> Array | float:
        return -p[0] * m.sign * np.square(m.v)


class PositionDependentDamping(Effect):
    """−c β x v, on top of −c v."""

    name = "position_dependent_damping"
    parameters = (Parameter("slope", "1/m", -np.inf),)
    law = "−c β x v"
    formula = r"-c\,\beta\, x v"
    symbols = (r"\beta",)
    seen = "damping differs in and out (air damper)"
    advice = "center the damper's piston at the rest position; keep it in the model"

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share / scales.displacement,) for share in (0.1, -0.1)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        return [Regressor((-m.damping * m.x * m.v,), lambda a: (a[0],))]

    def force(self, p: Values, m: Motion) -> Array | float:
        return -m.damping * p[0] * m.x * m.v
