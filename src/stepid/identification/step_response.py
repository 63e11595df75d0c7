"""The characteristics of one response to a step."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.noise import noise_level
from stepid.core.words import length
from stepid.errors import NoOvershootError, NoStepError, NotSettledError
from stepid.identification.characteristics_model import Characteristics, CharacteristicsUncertainty
from stepid.identification.onset import check_onset
from stepid.identification.peak import Peak, PeakReading
from stepid.identification.second_order import damped_frequency, damping_ratio, damping_ratio_slope
from stepid.identification.steady_state import (
    SteadyState,
    colored_noise,
    last_swing,
    settling_time_measured,
    steady_state,
)
from stepid.identification.step_refusals import hidden_peak, no_overshoot, no_step, not_settled, swinging
from stepid.identification.steps import HELD, Step

_MOVING = 0.05  # swing left at the end, as a fraction of the steady displacement, that is too much
_RINGING = 0.02  # and that deserves a note
_ROUNDS = 30  # of peak and level, at most
_SLOW = 0.3  # rad of the swing, the spread of an input's rise beyond which it is no step
_EXACT = 1e-9  # of the level: no reading is finer
_VAGUE = 0.25  # relative uncertainty of a peak time that is none


def overshoot(peak: float, steady: float) -> float:
    """Overshoot M_p = (y_peak − y_ss)/y_ss, as a decimal fraction.

    Parameters
    ----------
    peak, steady : float
        m, displacements from rest, of one sign.
    """
    return (peak - steady) / steady


def static_gain(steady: float, step: float) -> float:
    """Static gain K of Eqs. 3 and 4, m/V: steady displacement [m] over step of the input [V]."""
    return steady / step


class _Response(NamedTuple):
    """A step's response from rest, turned upward: s and m; `rest` is the standard uncertainty of the rest position.

    `lead` is that of the step.
    """

    who: str
    time: Array
    swing: Array
    sign: float
    noise: float
    grid: float
    rest: float
    spread: float

    @property
    def tolerance(self) -> float:
        """What stands out of noise and grid, m."""
        return max(5 * self.noise, 2 * self.grid)

    def excess(self, peak: float, level: float, frequency: float) -> float:
        """Overshoot of a step: a ramp of half length L = √3·spread leaves sin(ω_d·L)/(ω_d·L) of its swing."""
        return overshoot(peak, level) / float(np.sinc(frequency * math.sqrt(3.0) * self.spread / math.pi))


class _Reading(NamedTuple):
    """Peak, final level [m], and what they say: rad/s, 1, 1; `left` is the swing at the end, m."""

    peak: PeakReading
    tail: SteadyState
    frequency: float
    ratio: float
    excess: float
    left: float


class _Spreads(NamedTuple):
    """Standard uncertainties: of peak time and frequency, overshoot and ratio, steady state; and of the tail alone."""

    time: float
    frequency: float
    excess: float
    ratio: float
    steady: float
    tail: float
    correlation: float


def step_characteristics(experiment: Experiment, step: Step, *, peak: Peak) -> Characteristics:
    """Read the characteristics off the response to one step; see `stepid.characterize`."""
    response = _response(experiment, step)
    read = _read(response, peak)
    level = read.tail.level
    spreads = _spreads(response, read, _ringing(experiment, step, read.peak.time, response.noise) / level)
    time, swing, half = response.time, response.swing, read.peak.time
    settled = settling_time_measured(
        time, swing, level=level, half_period=half, noise=response.noise, spread=spreads.tail
    )
    still = f"the record ends while it still swings ±{100 * read.left / level:.1f} %: steady state from the fitted tail"
    return Characteristics(
        name=experiment.name if step.number == 1 else f"{experiment.name}, step {step.number}",
        peak_time=read.peak.time,
        overshoot=read.excess,
        damped_frequency=read.frequency,
        damping_ratio=read.ratio,
        natural_frequency=read.frequency / math.sqrt(1 - read.ratio**2),
        steady_state=response.sign * level,
        static_gain=static_gain(response.sign * level, step.size),
        settling_time=None if settled is None else settled[0],
        uncertainty=CharacteristicsUncertainty(
            peak_time=spreads.time,
            overshoot=spreads.excess,
            steady_state=spreads.steady,
            static_gain=spreads.steady / abs(step.size),
            settling_time=None if settled is None else settled[1],
        ),
        correlation=spreads.correlation,
        peak_time_bias=read.peak.time_bias,
        overshoot_bias=read.peak.height_bias / level,
        spring=experiment.spring,
        damper=experiment.damper,
        base=experiment.base,
        added_mass=experiment.added_mass,
        start=float(experiment.time[step.start]) - step.lead,
        step=step.size,
        notes=() if read.left <= _RINGING * level else (still,),
    )


def _response(experiment: Experiment, step: Step) -> _Response:
    """The response to a step from the rest before it; refused where there is none, or where it is cut."""
    who = _who(experiment, step)
    time = experiment.time[step.start : step.stop + 1] - experiment.time[step.start] + step.lead
    position = experiment.position[step.start : step.stop + 1]
    if time.size < HELD:
        raise NotSettledError(
            f"{who} is held for only {time.size} samples, the response is cut before its peak",
            "Hold the step until the plant rests, and record until then.",
        )
    grid = experiment.resolution or 0.0
    noise = noise_level(position[position.size // 2 :], resolution=grid)
    rest, rest_spread = _rest(experiment, step, who, noise, grid)
    swing = position - rest
    rough = float(np.mean(swing[swing.size // 2 :]))
    rounding = 1e-12 * float(np.abs(position).max())
    if np.abs(swing).max() <= max(6 * noise, 3 * grid, rounding) or rough == 0:
        raise NoStepError(
            f"{who}: the position does not answer the step of {step.size:g} V",
            "Check that the amplifier was on, and that the right encoder column was read.",
        )
    sign = math.copysign(1.0, rough)
    out = _Response(who, time, sign * swing, sign, noise, grid, rest_spread, step.spread)
    _require_peak(out)
    first_peak = float(time[np.argmax(out.swing)])
    if time[-1] < 1.9 * first_peak and last_swing(time, out.swing, 0.5 * float(time[-1])) > _MOVING * abs(rough):
        raise not_settled(who, f"ends {time[-1] / first_peak:.2f} peak times after the step")
    return out


def _read(response: _Response, peak: Peak) -> _Reading:
    """Locate the peak and fit the tail in turn, until the level stays: the tail's fit needs the damping ratio."""
    who, time, swing, *_ = response
    noise = response.noise
    first_peak = float(time[np.argmax(swing)])
    level = float(np.mean(swing[time >= time[-1] - 2 * first_peak]))
    left = last_swing(time, swing, min(first_peak, float(time[-1]) - first_peak)) - 3 * noise
    if left > 2 * _MOVING * abs(level):
        raise swinging(who, left / abs(level))
    for _ in range(_ROUNDS):
        try:
            found = peak.locate(time, swing, level=level, noise=noise)
        except NoOvershootError as error:
            raise NoOvershootError(f"{who}: {error.cause}", error.remedy) from None
        frequency = damped_frequency(found.time)
        if frequency * response.spread > _SLOW:
            raise no_step(who, response.spread, found.time)
        excess = response.excess(found.height, level, frequency)
        if not response.tolerance < excess * level < level:
            raise no_overshoot(who, excess, level, noise, response.grid)
        if found.time_uncertainty > _VAGUE * found.time:
            raise hidden_peak(who, excess, noise)
        ratio = damping_ratio(excess)
        tail = _tail(response, found, frequency, ratio, excess)
        change, level = abs(tail.level - level), tail.level
        if level <= 0 or change < 1e-12 * level:
            break
    left = max(last_swing(time, swing, found.time) - 3 * noise, 0.0)
    if level <= 0 or left > _MOVING * level:
        raise swinging(who, left / abs(level))
    check_onset(who, time, swing, level=level, peak_time=found.time, tolerance=response.tolerance)
    colored = colored_noise(tail.residual, float(time[1] - time[0]), found.time, noise)
    if colored > noise:
        found = peak.locate(time, swing, level=level, noise=colored)
        frequency = damped_frequency(found.time)
    excess = response.excess(found.height, level, frequency)
    return _Reading(found, tail, frequency, damping_ratio(excess), excess, left)


def _tail(response: _Response, found: PeakReading, frequency: float, ratio: float, excess: float) -> SteadyState:
    return steady_state(
        response.time,
        response.swing,
        peak_time=found.time,
        damped_frequency=frequency,
        damping_ratio=ratio,
        overshoot=excess,
        noise=response.noise,
    )


def _spreads(response: _Response, read: _Reading, ring: float) -> _Spreads:
    """Standard uncertainties; `ring` is the swing left from the step before, over the level."""
    found, tail, frequency, ratio, excess, _ = read
    level = tail.level

    def level_at(frequency_shift: float, ratio_shift: float) -> float:
        shifted = min(max(ratio + ratio_shift, 1e-6), 0.999)
        return _tail(response, found, frequency + frequency_shift, shifted, excess).level

    time_spread = math.hypot(found.time_uncertainty, found.time * ring / math.pi / math.sqrt(2))
    slope = abs(damping_ratio_slope(excess, ratio))
    frequency_spread = frequency**2 / math.pi * time_spread
    first = math.hypot(found.height_uncertainty, tail.uncertainty) / level * slope
    tail_spread = math.hypot(
        tail.uncertainty,
        level_at(frequency_spread, 0) - level,
        level_at(0, first) - level,
        response.grid / math.sqrt(12),
    )
    height = math.hypot(found.height_uncertainty, (1 + excess) * tail_spread, excess * response.rest) / level
    excess_spread = math.hypot(height, excess * ring / math.sqrt(2))
    ratio_spread = slope * excess_spread
    cross = frequency**2 / math.pi * slope * found.covariance / level  # of ω_d and ζ
    correlation = float(np.clip(cross / (frequency_spread * ratio_spread), -1, 1)) if cross else 0.0
    steady_spread = math.hypot(tail_spread, response.rest)
    return _Spreads(time_spread, frequency_spread, excess_spread, ratio_spread, steady_spread, tail_spread, correlation)


def _who(experiment: Experiment, step: Step) -> str:
    which = f", step {step.number} of {step.total}" if step.total > 1 else ""
    return f"run {experiment.name!r}{which} (at {experiment.time[step.start]:.3f} s)"


def _rest(experiment: Experiment, step: Step, who: str, noise: float, grid: float) -> tuple[float, float]:
    """Rest position before a step and its standard uncertainty, m."""
    before = experiment.position[step.before]
    if step.number > 1 and before.size < HELD:
        raise NotSettledError(
            f"{who}: the step before it is held for only {before.size} samples, the plant cannot rest by then",
            "Hold each step until the plant rests.",
        )
    if step.number > 1:
        before = before[-20:]  # the one before may ring further back
    after = experiment.position[step.start : step.stop + 1]
    moved, drift = float(np.ptp(after)), float(np.ptp(before))
    if drift > max(9 * noise, 3 * grid, 0.04 * moved):
        raise NotSettledError(
            f"{who}: the plant was not at rest before the step, it moved by {length(drift)}",
            "Wait until the plant rests before each step.",
        )
    wander = drift / math.sqrt(12) if drift > 9 * noise else 0.0
    return float(np.mean(before)), math.hypot(noise / math.sqrt(before.size), wander, grid / math.sqrt(12))


def _ringing(experiment: Experiment, step: Step, half_period: float, noise: float) -> float:
    """Swing left from the step before, m: it adds to the new one with any phase, up to ring/level radians."""
    time = experiment.time[step.before]
    if time.size < 8:
        return 0.0
    return max(last_swing(time, experiment.position[step.before], half_period) - 4 * noise, 0.0)


def _require_peak(response: _Response) -> None:
    """Refuse a record that still moves outward at its end, or whose highest reading does not stand out of the rest."""
    who, time, swing, *_ = response
    quarter = swing[-max(swing.size // 4, 3) :]
    wide, still = float(np.ptp(quarter)), max(0.02 * float(swing.max()), response.tolerance)
    if int(np.argmax(swing)) >= swing.size - 2 and wide > still:
        raise NotSettledError(
            f"{who}: the response still moves outward at the last sample, {time[-1]:.3f} s after the step; "
            "it is cut before its peak, or does not overshoot",
            "Record until the plant rests; less damping or more mass gives an overshoot.",
        )
    level = float(np.mean(quarter))
    if wide <= still and float(swing.max()) - level <= max(response.tolerance, wide, _EXACT * level):
        raise no_overshoot(who, float(swing.max()) / level - 1, level, response.noise, response.grid)
