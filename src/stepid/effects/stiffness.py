"""Springs that are not linear: cubic, quadratic, free play, end stop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Motion, Parameter, Regressor, Scales, Values


class CubicStiffness(Effect):
    """−k₃ x³, hardening for k₃ > 0."""

    name = "cubic_stiffness"
    parameters = (Parameter("coefficient", "N/m³", -np.inf),)
    law = "−k₃ x³"
    formula = r"-k_3\, x^3"
    symbols = ("k_3",)
    seen = "frequency changes with amplitude"
    advice = "take smaller steps or use a longer spring; keep it in the model"

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.stiffness / scales.displacement**2,) for share in (0.1, -0.1)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        return [Regressor((-(m.x**3),), lambda a: (a[0],))]

    def force(self, p: Values, m: Motion) -> Array | float:
        return -p[0] * m.x * np.square(m.x)


class QuadraticStiffness(Effect):
    """−k₂ x²."""

    name = "quadratic_stiffness"
    parameters = (Parameter("coefficient", "N/m²", -np.inf),)
    law = "−k₂ x²"
    formula = r"-k_2\, x^2"
    symbols = ("k_2",)
    seen = "swings lopsided about rest"
    advice = "preload the spring so that it stays in its linear range; record steps in both directions"

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.stiffness / scales.displacement,) for share in (0.1, -0.1)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        return [Regressor((-(m.x**2),), lambda a: (a[0],))]

    def force(self, p: Values, m: Motion) -> Array | float:
        return -p[0] * np.square(m.x)


class FreePlay(Effect):
    """No spring force within ±gap of rest."""

    name = "free_play"
    parameters = (Parameter("gap", "m"),)
    law = "k x within ±gap, +k gap sign(x) outside (on top of −k x)"
    formula = r"+k\,\max(-g,\, \min(x,\, g))"
    symbols = ("g",)
    seen = "floats about zero, lower frequency at small amplitude"
    advice = "tighten the spring's clamps"
    affine: ClassVar[bool] = True
    n_switches: ClassVar[int] = 2
    rests_anywhere: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.displacement,) for share in (0.0003, 0.002, 0.01, 0.04, 0.12)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        def at(gap: float) -> Regressor:
            return Regressor((m.stiffness * np.clip(m.x, -gap, gap),), lambda a: (gap,) if a[0] > 0.02 else None)

        return [at(part * scales.displacement) for part in (0.0005, 0.003, 0.01, 0.03, 0.07, 0.15)]

    def switches(self, p: Values, m: Motion) -> tuple[Array, ...]:
        return (m.x - p[0], m.x + p[0])

    def force(self, p: Values, m: Motion) -> Array | float:
        above, below = m.sides
        inside = (above < 0) & (below >= 0)
        return m.stiffness * np.where(inside, m.x, np.where(above >= 0, p[0], -p[0]))


def _ends(scales: Scales) -> list[float]:
    """Ends of the motion, m, where a stop may stand."""
    return [end for end in (scales.high, scales.low) if abs(end) > 0.1 * scales.displacement]


class EndStop(Effect):
    """Extra stiffness beyond a signed position."""

    name = "end_stop"
    parameters = (Parameter("stiffness", "N/m", 1.0), Parameter("position", "m", -np.inf))
    law = "−k_s (x − x_s) beyond x_s"
    formula = r"-k_s\,(x - x_s) \;\mathrm{beyond}\; x_s"
    symbols = ("k_s", "x_s")
    seen = "clipped, kinked peaks"
    advice = "move the stop out of the cart's way or take smaller steps"
    affine: ClassVar[bool] = True
    n_switches: ClassVar[int] = 1

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [
            (times * scales.stiffness, part * end)
            for end in _ends(scales)
            for part in (0.97, 0.9, 0.78)
            for times in (2.0, 10.0)
        ]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        def at(position: float) -> Regressor:
            beyond = np.maximum(np.sign(position) * (m.x - position), 0.0) * np.sign(position)
            return Regressor((-beyond,), lambda a: (a[0], position) if a[0] > 1.0 else None)

        return [at(part * end) for end in _ends(scales) for part in (0.98, 0.95, 0.9, 0.84, 0.77, 0.68, 0.58)]

    def switches(self, p: Values, m: Motion) -> tuple[Array, ...]:
        return (np.sign(p[1]) * (m.x - p[1]),)

    def force(self, p: Values, m: Motion) -> Array | float:
        return np.where(m.sides[0] >= 0, -p[0] * (m.x - p[1]), 0.0)

    def pieces(self, p: Values, m: Motion, acceleration: Array, length: Array) -> Array | float:
        needed: Array = np.where(m.sides[0] >= 0, np.sqrt(p[0] / m.mass) * length / 0.2, 1.0)
        return needed
