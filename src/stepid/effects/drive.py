"""What happens between the commanded voltage and the force on the cart, and forces that come from outside."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stepid.core.base import Array
from stepid.core.samples import multiples
from stepid.effects.base import Effect, Moment, Motion, Parameter, Regressor, Scales, Values
from stepid.effects.swing import OWN, Swing


def acts_on_input(effect: Effect) -> bool:
    """Tell whether an effect changes the input on its way to the motor: without an input it changes nothing."""
    own = type(effect)
    return own.drive is not Effect.drive or own.delay is not Effect.delay


class ActuatorLag(Effect):
    """The drive force follows the voltage through a first-order lag."""

    name = "actuator_lag"
    parameters = (Parameter("time_constant", "s", 1e-5),)
    law = "K_f w, τ w′ = u − w"
    formula = r"K_f\, w, \quad \tau\, \dot w = u - w"
    symbols = (r"\tau",)
    seen = "rounded start, later peak"
    advice = "faster amplifier, or keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ("V",)
    linear: ClassVar[bool] = True
    n_extra: ClassVar[int] = 1
    settled: ClassVar[bool] = True
    drive_order: ClassVar[int] = 4

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        period = 2 * np.pi * np.sqrt(scales.mass / scales.stiffness)
        return [(0.01 * period,), (0.05 * period,)]

    @staticmethod
    def rates(p: Values, m: Moment) -> tuple[float, ...]:
        return ((m.volts - m.extra[0]) / p[0],)

    @staticmethod
    def drive(p: Values, m: Moment) -> float:
        return m.extra[0]

    @staticmethod
    def at_rest(p: Values, x: float, volts: float) -> tuple[float, ...]:
        return (volts,)

    @staticmethod
    def relax(p: Values, m: Moment, time: float) -> tuple[float, ...]:
        lag = p[0]  # long after the start it follows the cubic u as u − τ u′ + τ² u″ − τ³ u‴
        value = m.volts - lag * (m.slope - lag * (m.bend - lag * m.jerk))
        slope, bend = m.slope - lag * (m.bend - lag * m.jerk), m.bend - lag * m.jerk
        later = value + time * (slope + time * (bend / 2.0 + time * m.jerk / 6.0))
        return (later + (m.extra[0] - value) * math.exp(-time / lag),)


class InputDelay(Effect):
    """The drive force comes late."""

    name = "input_delay"
    parameters = (Parameter("delay", "s"),)
    law = "K_f u(t − T_d)"
    formula = r"K_f\, u(t - T_d)"
    symbols = ("T_d",)
    seen = "whole response shifted late"
    advice = "check the clocks of drive and logger; keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    linear: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.45 * scales.sample_time,), (1.6 * scales.sample_time,)]

    @staticmethod
    def delay(p: Values) -> float:
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
    own_units: ClassVar[tuple[str, ...] | None] = ()
    linear: ClassVar[bool] = True  # a fixed change of a known input
    drive_order: ClassVar[int] = 1

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.05 * scales.volts_least,), (0.3 * scales.volts_least,)]

    @staticmethod
    def drive(p: Values, m: Moment) -> float:
        return math.copysign(max(abs(m.volts) - p[0], 0.0), m.volts)


class ActuatorSaturation(Effect):
    """The drive is limited to ±level."""

    name = "actuator_saturation"
    parameters = (Parameter("level", "V", 1e-6),)
    law = "K_f clip(u, ±level)"
    formula = r"K_f\,\max(-u_0,\, \min(u,\, u_0))"
    symbols = ("u_0",)
    seen = "gain depends on step size: needs runs of two sizes"
    advice = "drive with smaller steps"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    linear: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.97 * scales.volts,), (0.75 * scales.volts,)]

    def faint(self, values: tuple[float, ...], share: float) -> tuple[float, ...]:
        return (0.95 * values[0] if share else 1e3 * values[0],)  # from above the largest input there is no way down

    @staticmethod
    def drive(p: Values, m: Moment) -> float:
        return max(-p[0], min(m.volts, p[0]))


class ActuatorRateLimit(Effect):
    """The drive's voltage follows the command no faster than a rate."""

    name = "actuator_rate_limit"
    parameters = (Parameter("rate", "V/s", 1e-6),)
    law = "K_f w, |w′| ≤ rate"
    formula = r"K_f\, w, \quad |\dot w| \leq r"
    symbols = ("r",)
    seen = "large steps start late, small ones do not: needs two sizes"
    advice = "raise the amplifier's slew rate, or drive with smaller steps"
    own_units: ClassVar[tuple[str, ...] | None] = ("V",)
    n_extra: ClassVar[int] = 1
    settled: ClassVar[bool] = True
    drive_order: ClassVar[int] = 3

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        period = 2 * math.pi * math.sqrt(scales.mass / scales.stiffness)
        return [(scales.volts / (part * period),) for part in (0.02, 0.08, 0.3)]

    def faint(self, values: tuple[float, ...], share: float) -> tuple[float, ...]:
        return (values[0] / max(share, 1e-3),)  # the faster, the less of it is left

    @staticmethod
    def drive(p: Values, m: Moment) -> float:
        return m.extra[0]

    @staticmethod
    def at_rest(p: Values, x: float, volts: float) -> tuple[float, ...]:
        return (volts,)

    @staticmethod
    def relax(p: Values, m: Moment, time: float) -> tuple[float, ...]:
        rate, now = p[0], m.extra[0]
        slope = m.slope + time * (m.bend / 2.0 + time * m.jerk / 6.0)  # of the chord
        last = m.slope + time * (m.bend + time * m.jerk / 2.0)
        behind, target = m.volts - now, m.volts + slope * time
        if abs(behind) > 1e-12 * (abs(m.volts) + rate * time):
            closing = math.copysign(rate, behind) - slope
            if behind * closing <= 0.0 or time * abs(closing) < abs(behind):
                return (now + math.copysign(rate, behind) * time,)
            if abs(slope) > rate:  # met, and left behind the other way
                since = behind / closing
                return (m.volts + slope * since + math.copysign(rate, slope) * (time - since),)
        elif abs(m.slope) > rate and abs(slope) > rate:
            return (now + math.copysign(rate, m.slope) * time,)
        if abs(m.slope) <= rate < abs(last):  # the command has become too fast on the way
            return (target - math.copysign(0.5 * (abs(last) - rate) ** 2 * time / abs(last - m.slope), last),)
        return (target,)

    @staticmethod
    def kink(p: Values, m: Moment) -> float:
        behind = m.volts - m.extra[0]  # until it meets the command
        closing = math.copysign(p[0], behind) - m.slope
        met = abs(behind) <= 1e-12 * abs(m.volts) or behind * closing <= 0.0
        return math.inf if met or m.bend != 0.0 or m.jerk != 0.0 else behind / closing


def _overtones(angle: Array) -> list[Array]:
    return [wave(times * angle) for times in (2, 3) for wave in (np.sin, np.cos)]


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
    own_units: ClassVar[tuple[str, ...] | None] = ()

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.01 * scales.force, f) for f in scales.resonances]

    def imitates(self, values: tuple[float, ...], swing: Swing) -> str:
        return OWN if swing.near(2 * math.pi * values[1]) else ""

    def unseen(self, values: tuple[float, ...], swing: Swing) -> str:
        return swing.unseen(values[1]) or swing.unbeaten(values[1]) or swing.overtone(values[1])

    def overtones(self, values: tuple[float, ...], m: Motion) -> Sequence[Array]:
        return _overtones(2 * np.pi * values[1] * m.time + values[2])

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return p[0] * math.sin(2 * math.pi * p[1] * m.time + p[2])


class Cogging(Effect):
    """A force that is periodic in position (motor torque ripple)."""

    name = "cogging"
    parameters = (Parameter("amplitude", "N"), Parameter("pitch", "m", 1e-5), Parameter("phase", "rad", -np.inf))
    law = "+A sin(2πx/pitch + phase)"
    formula = r"+A\, \sin(2\pi x/p + \varphi)"
    symbols = ("A", "p", r"\varphi")
    seen = "wiggles that slow down with the cart, several rest positions"
    advice = "record at several rest positions; a slotless motor; keep it in the model"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    rests_anywhere: ClassVar[bool] = True
    repeats: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        pitches = scales.displacement * np.array([0.1, 0.14, 0.19, 0.26, 0.36, 0.5])
        return [(0.02 * scales.force, float(pitch), phase) for pitch in pitches for phase in (0.0, 2.1, 4.2)]

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        def at(pitch: float, wave: Array) -> Regressor:
            return Regressor(
                (wave.imag.copy(), wave.real.copy()),
                lambda a: (float(np.hypot(a[0], a[1])), pitch, float(np.arctan2(a[1], a[0]))),
            )

        # over a travel of twice the displacement, waves that are half a turn apart at its ends
        longest, quarters = 4.0 * scales.displacement, range(5, 81)
        waves = multiples(2 * np.pi * m.x / longest, quarters.start, quarters.stop)
        return [at(longest / quarter, wave) for quarter, wave in zip(quarters, waves, strict=True)]

    def unseen(self, values: tuple[float, ...], swing: Swing) -> str:
        return "a spring that bends" if values[1] > swing.pitch * swing.displacement else ""

    def overtones(self, values: tuple[float, ...], m: Motion) -> Sequence[Array]:
        return _overtones(2 * np.pi * m.x / values[1])

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return p[0] * math.sin(2 * math.pi * m.x / p[1] + p[2])
