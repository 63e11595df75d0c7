"""Structure that the one-mass model lacks: a creeping spring, a second mass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stepid.effects.base import Effect, Moment, Parameter, Scales, Values
from stepid.effects.swing import OWN, Swing


class ViscoelasticSpring(Effect):
    """A spring and damper in series beside k (standard linear solid)."""

    name = "viscoelastic_spring"
    parameters = (Parameter("stiffness", "N/m"), Parameter("damping", "N·s/m", 1e-6))
    law = "−f, f′ = k_v v − (k_v/c_v) f"
    formula = r"-f, \quad \dot f = k_v\, v - \frac{k_v}{c_v}\, f"
    symbols = ("k_v", "c_v")
    seen = "creep after the step, stiffness that depends on speed"
    advice = "use a steel spring, wait longer between runs; keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ("N",)
    linear: ClassVar[bool] = True
    n_extra: ClassVar[int] = 1

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        branch, swing = 0.15 * scales.stiffness, math.sqrt(scales.mass / scales.stiffness)
        return [(branch, branch * times * swing) for times in (0.35, 1.75, 7.0, 23.0)]

    def faint(self, values: tuple[float, ...], share: float) -> tuple[float, ...]:
        return tuple(share * v for v in values)

    def imitates(self, values: tuple[float, ...], swing: Swing) -> str:
        time = values[1] / max(values[0], 1e-12)
        if time * min(swing.rates) > swing.slow:
            return "the stiffness of the spring"
        return "the damper" if time * max(swing.rates) < swing.fast else ""

    def remark(self, values: tuple[float, ...]) -> str:
        if not values[0]:
            return ""
        several = "Step responses hardly tell one such time from several."
        return f"The spring creeps with a relaxation time of {values[1] / values[0]:.3g} s. {several}"

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -m.extra[0]

    @staticmethod
    def rates(p: Values, m: Moment) -> tuple[float, ...]:
        return (p[0] * (m.v - m.extra[0] / p[1]),)


class FlexibleCoupling(Effect):
    """A second mass carried on a spring and damper."""

    name = "flexible_coupling"
    parameters = (
        Parameter("mass", "kg", 1e-4),
        Parameter("stiffness", "N/m", 1e-2),
        Parameter("damping", "N·s/m"),
    )
    law = "k₂(x₂ − x) + c₂(v₂ − v), m₂ x₂″ = −that"
    formula = r"+q, \quad q = k_2\,(x_2 - x) + c_2\,(\dot x_2 - v), \quad m_2\, \ddot x_2 = -q"
    symbols = ("m_2", "k_2", "c_2")
    seen = "a faster ripple on the response"
    advice = "tighten what is loose on the cart (weights, rack); keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ("m", "m/s")
    linear: ClassVar[bool] = True
    n_extra: ClassVar[int] = 2

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        natural = np.sqrt(scales.stiffness / scales.mass)
        around = [2 * np.pi * f for f in scales.resonances[:2]] + [1.5 * natural, 2.5 * natural, 4.5 * natural]
        masses = [0.2 * scales.mass] * len(around)
        around += [4.5 * natural, 6.5 * natural]
        masses += [0.5 * scales.mass] * 2
        return [(m, m * w**2 / 1.2, 0.06 * m * w) for m, w in zip(masses, around, strict=True)]

    def faint(self, values: tuple[float, ...], share: float) -> tuple[float, ...]:
        return tuple(share * v for v in values)

    def imitates(self, values: tuple[float, ...], swing: Swing) -> str:
        return "" if swing.splits(values[0], values[1]) else OWN

    def unseen(self, values: tuple[float, ...], swing: Swing) -> str:
        return swing.unseen(_rate(values) / math.tau)

    def remark(self, values: tuple[float, ...]) -> str:
        rate = _rate(values) / math.tau
        return f"The second mass alone swings at {rate:.3g} Hz: a further mode of the plant."

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return p[1] * (m.extra[0] - m.x) + p[2] * (m.extra[1] - m.v)

    @staticmethod
    def rates(p: Values, m: Moment) -> tuple[float, ...]:
        coupling = p[1] * (m.extra[0] - m.x) + p[2] * (m.extra[1] - m.v)
        return (m.extra[1], -coupling / p[0])

    @staticmethod
    def at_rest(p: Values, x: float, volts: float) -> tuple[float, ...]:
        return (x, 0.0)


def _rate(coupling: tuple[float, ...]) -> float:
    """Rate at which the second mass of a flexible coupling swings alone, rad/s."""
    return math.sqrt(coupling[1] / coupling[0])
