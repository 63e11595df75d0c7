"""Springs that are not linear: cubic, quadratic, free play, end stop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stepid.effects.base import Effect, Moment, Motion, Parameter, Regressor, Scales, Values


class CubicStiffness(Effect):
    """−k₃ x³, hardening for k₃ > 0."""

    name = "cubic_stiffness"
    parameters = (Parameter("coefficient", "N/m³", -np.inf),)
    law = "−k₃ x³"
    formula = r"-k_3\, x^3"
    symbols = ("k_3",)
    seen = "frequency changes with amplitude"
    advice = "take smaller steps or use a longer spring; keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ()

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.stiffness / scales.displacement**2,) for share in (0.1, -0.1)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        return [Regressor((-(m.x**3),), lambda a: (a[0],))]

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * m.x * m.x * m.x


class QuadraticStiffness(Effect):
    """−k₂ x²."""

    name = "quadratic_stiffness"
    parameters = (Parameter("coefficient", "N/m²", -np.inf),)
    law = "−k₂ x²"
    formula = r"-k_2\, x^2"
    symbols = ("k_2",)
    seen = "swings lopsided about rest"
    advice = "preload the spring so that it stays in its linear range; record steps in both directions"
    own_units: ClassVar[tuple[str, ...] | None] = ()

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.stiffness / scales.displacement,) for share in (0.1, -0.1)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        return [Regressor((-(m.x**2),), lambda a: (a[0],))]

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * m.x * m.x


class SineStiffness(Effect):
    """−k (sin(a x)/a − x): the spring force k x becomes k sin(a x)/a, a pendulum's."""

    name = "sine_stiffness"
    parameters = (Parameter("curvature", "1/m"),)
    law = "−k (sin(a x)/a − x)"
    formula = r"-k\left(\frac{\sin(a x)}{a} - x\right)"
    symbols = ("a",)
    seen = "slower at large swings, by more than a cubic allows"
    advice = "take smaller swings; keep it in the model: a pendulum's moment is a sine"
    own_units: ClassVar[tuple[str, ...] | None] = ()

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(part / scales.displacement,) for part in (0.5, 1.2)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        def at(curvature: float) -> Regressor:
            bend = m.x - np.sin(curvature * m.x) / curvature
            return Regressor((m.stiffness * bend,), lambda a: (curvature * math.sqrt(a[0]),) if a[0] > 0 else None)

        return [at(part / scales.displacement) for part in (0.3, 0.8, 1.3, 2.0)]

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        angle = p[0] * m.x
        if abs(angle) < 1e-3:  # sin(a x)/a − x by its series, exact to rounding there
            return m.stiffness * m.x * angle * angle / 6.0 * (1.0 - angle * angle / 20.0)
        return -m.stiffness * (math.sin(angle) / p[0] - m.x)


class FreePlay(Effect):
    """No spring force within ±gap of rest."""

    name = "free_play"
    parameters = (Parameter("gap", "m"),)
    law = "k x within ±gap, +k gap sign(x) outside (on top of −k x)"
    formula = r"+k\,\max(-g,\, \min(x,\, g))"
    symbols = ("g",)
    seen = "floats about zero, lower frequency at small amplitude"
    advice = "tighten the spring's clamps"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    affine: ClassVar[bool] = True
    n_switches: ClassVar[int] = 2
    rests_anywhere: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.displacement,) for share in (0.0003, 0.002, 0.01, 0.04, 0.12)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        def at(gap: float) -> Regressor:
            return Regressor((m.stiffness * np.clip(m.x, -gap, gap),), lambda a: (gap,) if a[0] > 0.02 else None)

        return [at(part * scales.displacement) for part in (0.0005, 0.003, 0.01, 0.03, 0.07, 0.15)]

    @staticmethod
    def switches(p: Values, m: Moment) -> tuple[float, ...]:
        return (m.x - p[0], m.x + p[0])

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        above, below = m.sides
        if above >= 0:
            return m.stiffness * p[0]
        return -m.stiffness * p[0] if below < 0 else m.stiffness * m.x


def _ends(scales: Scales) -> list[float]:
    """Ends of the motion, m, where a stop may stand."""
    return [end for end in (scales.high, scales.low) if abs(end) > 0.1 * scales.displacement]


_STOP = 0.01  # of the spring's stiffness, that a stop has at least


class EndStop(Effect):
    """Extra stiffness beyond a signed position."""

    name = "end_stop"
    parameters = (Parameter("stiffness", "N/m", 1.0), Parameter("position", "m", -np.inf))
    law = "−k_s (x − x_s) beyond x_s"
    formula = r"-k_s\,(x - x_s) \;\mathrm{beyond}\; x_s"
    symbols = ("k_s", "x_s")
    seen = "clipped, kinked peaks"
    advice = "move the stop out of the cart's way or take smaller steps"
    own_units: ClassVar[tuple[str, ...] | None] = ()
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
            return Regressor((-beyond,), lambda a: (a[0], position) if a[0] > _STOP * scales.stiffness else None)

        return [at(part * end) for end in _ends(scales) for part in (0.98, 0.95, 0.9, 0.84, 0.77, 0.68, 0.58)]

    @staticmethod
    def switches(p: Values, m: Moment) -> tuple[float, ...]:
        return (math.copysign(1.0, p[1]) * (m.x - p[1]),)

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * (m.x - p[1]) if m.sides[0] >= 0 else 0.0
