"""What happens between the commanded voltage and the force on the cart, and forces that come from outside."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Motion, Parameter, Regressor, Scales, Values

_SETTLED = 2.0  # time constants, in which a lag is no more followed but taken at its mean
_THERE = 1e-6  # of the voltage, to which a lagging drive has followed it


class ActuatorLag(Effect):
    """The drive force follows the voltage through a first-order lag."""

    name = "actuator_lag"
    parameters = (Parameter("time_constant", "s", 1e-5),)
    law = "K_f w, τ w′ = u − w"
    formula = r"K_f\, w, \quad \tau\, \dot w = u - w"
    symbols = (r"\tau",)
    seen = "rounded start, later peak"
    advice = "faster amplifier, or keep it in the model"
    linear: ClassVar[bool] = True
    n_extra: ClassVar[int] = 1
    settled: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        period = 2 * np.pi * np.sqrt(scales.mass / scales.stiffness)
        return [(0.01 * period,), (0.05 * period,)]

    def rates(self, p: Values, m: Motion) -> tuple[Array, ...]:
        return ((m.volts - m.extra[0]) / p[0],)

    def drive(self, p: Values, m: Motion) -> Array:
        return m.extra[0]

    def at_rest(self, p: Values, x: Array, volts: Array) -> tuple[Array, ...]:
        return (volts,)

    def relax(self, p: Values, m: Motion, time: Array, length: Array | None = None) -> tuple[Array, ...]:
        away = m.extra[0] - m.volts
        there: Array = m.volts + away * np.exp(-time / p[0])
        if length is None:
            return (there,)
        mean = m.volts - away * np.expm1(-length / p[0]) * p[0] / np.maximum(length, 1e-12)
        return (np.where(length > _SETTLED * p[0], mean, there),)

    def pieces(self, p: Values, m: Motion, acceleration: Array, length: Array) -> Array | float:
        away = np.abs(m.extra[0] - m.volts) > _THERE * np.abs(m.volts).max(initial=0.0)
        return np.where(away, np.minimum(length / p[0] / 0.3, 64.0), 1.0)


class InputDelay(Effect):
    """The drive force comes late."""

    name = "input_delay"
    parameters = (Parameter("delay", "s"),)
    law = "K_f u(t − T_d)"
    formula = r"K_f\, u(t - T_d)"
    symbols = ("T_d",)
    seen = "whole response shifted late"
    advice = "check the clocks of drive and logger; keep it in the model"
    linear: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.45 * scales.sample_time,), (1.6 * scales.sample_time,)]

    def delay(self, p: Values) -> Array | float:
        return p[0]


class ActuatorDeadZone(Effect):
    """No drive within ±level, the excess beyond."""

    name = "actuator_dead_zone"
    parameters = (Parameter("level", "V"),)
    law = "K_f (u − sign(u) level) beyond the level, 0 within"
    formula = r"K_f\,\mathrm{sign}(u)\,\max(0,\, |u| - u_0)"
    symbols = ("u_0",)
    seen = "gain depends on step size: needs runs of two sizes"
    advice = "drive with larger steps, or add the level to the command"
    linear: ClassVar[bool] = True  # a fixed change of a known input

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.05 * scales.volts_least,), (0.3 * scales.volts_least,)]

    def drive(self, p: Values, m: Motion) -> Array:
        out: Array = np.sign(m.volts) * np.maximum(np.abs(m.volts) - p[0], 0.0)
        return out


class ActuatorSaturation(Effect):
    """The drive is limited to ±level."""

    name = "actuator_saturation"
    parameters = (Parameter("level", "V", 1e-6),)
    law = "K_f clip(u, ±level)"
    formula = r"K_f\,\max(-u_0,\, \min(u,\, u_0))"
    symbols = ("u_0",)
    seen = "gain depends on step size: needs runs of two sizes"
    advice = "drive with smaller steps"
    linear: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.97 * scales.volts,), (0.75 * scales.volts,)]

    def faint(self, values: tuple[float, ...], share: float) -> tuple[float, ...]:
        return (0.95 * values[0],)  # from above the largest input there is no way down

    def drive(self, p: Values, m: Motion) -> Array:
        out: Array = np.clip(m.volts, -p[0], p[0])
        return out


class PeriodicDisturbance(Effect):
    """A sinusoidal force in time, one frequency for the campaign, a phase for each run."""

    name = "periodic_disturbance"
    parameters = (Parameter("amplitude", "N"), Parameter("frequency", "Hz", 1e-3))
    run_parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("phase", "rad", -np.inf),)
    never_rests: ClassVar[bool] = True
    law = "+A sin(2πf t + φ_run)"
    formula = r"+A\, \sin(2\pi f t + \varphi)"
    symbols = ("A", "f", r"\varphi")
    seen = "steady ripple that does not decay"
    advice = "find the shaker: fans, pumps, mains; isolate the table"

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.01 * scales.force, f) for f in scales.resonances]

    def force(self, p: Values, m: Motion) -> Array | float:
        return p[0] * np.sin(2 * np.pi * p[1] * m.time + p[2])

    def pieces(self, p: Values, m: Motion, acceleration: Array, length: Array) -> Array | float:
        return 2 * np.pi * p[1] * length / 0.3


class Cogging(Effect):
    """A force that is periodic in position (motor torque ripple)."""

    name = "cogging"
    parameters = (Parameter("amplitude", "N"), Parameter("pitch", "m", 1e-5), Parameter("phase", "rad", -np.inf))
    law = "+A sin(2πx/pitch + phase)"
    formula = r"+A\, \sin(2\pi x/p + \varphi)"
    symbols = ("A", "p", r"\varphi")
    seen = "wiggles that slow down with the cart, several rest positions"
    advice = "record at several rest positions; a slotless motor; keep it in the model"
    rests_anywhere: ClassVar[bool] = True
    repeats: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        pitches = scales.displacement * np.array([0.1, 0.14, 0.19, 0.26, 0.36, 0.5])
        return [(0.02 * scales.force, float(pitch), phase) for pitch in pitches for phase in (0.0, 2.1, 4.2)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        def at(pitch: float) -> Regressor:
            angle = 2 * np.pi * m.x / pitch
            return Regressor(
                (np.sin(angle), np.cos(angle)),
                lambda a: (float(np.hypot(a[0], a[1])), pitch, float(np.arctan2(a[1], a[0]))),
            )

        return [at(float(part) * scales.displacement) for part in np.geomspace(0.05, 0.8, 24)]

    def force(self, p: Values, m: Motion) -> Array | float:
        return p[0] * np.sin(2 * np.pi * m.x / p[1] + p[2])

    def pieces(self, p: Values, m: Motion, acceleration: Array, length: Array) -> Array | float:
        path = np.abs(m.v) * length + 0.5 * np.abs(acceleration) * length**2
        return np.maximum(2 * np.pi * path / p[1] / 0.5, np.sqrt(2 * np.pi * p[0] / (p[1] * m.mass)) * length / 0.25)
