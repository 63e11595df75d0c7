"""The characteristics of a hand-released swing: damped frequency and damping ratio from its extrema."""

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
from stepid.identification.peak import Peak, SampledPeak, fit_peak, polynomial, sampled_peak_spread

_SMALL = 0.05  # extrema below this fraction of the largest are too uncertain to help


class Extrema(NamedTuple):
    """Turning points of a swing: times [s], positions [m], and their standard uncertainties; shape (n,) each."""

    time: Array
    position: Array
    time_uncertainty: Array
    position_uncertainty: Array


def find_extrema(time: Array, position: Array, *, rest: float, noise: float, peak: Peak) -> Extrema:
    """Find the turning points of a decaying swing, one between successive crossings of the rest position.

    Parameters
    ----------
    time, position : array, shape (n,)
        s, m.
    rest : float
        m, position that the swing decays to.
    noise : float
        m, standard deviation of a reading.
    peak : InterpolatedPeak or SampledPeak
        How an extremum is read.

    Returns
    -------
    Extrema
        Without segments at the edge of the record, where the turning point may lie outside.
    """
    swing = position - rest
    threshold = max(_SMALL * float(np.abs(swing).max()), 6 * noise)
    side = np.where(swing > threshold, 1, np.where(swing < -threshold, -1, 0))
    index = np.flatnonzero(side)
    lobes = np.split(index, np.flatnonzero(np.diff(side[index])) + 1) if index.size else []
    tops = [int(lobe[np.argmax(np.abs(swing[lobe]))]) for lobe in lobes]
    half = float(np.median(np.diff(time[tops]))) if len(tops) > 1 else 0.0
    period = float(time[1] - time[0])
    bends = [abs(float(swing[top])) * (math.pi / max(half, period)) ** 2 for top in tops]  # m/s²
    # one for all, as the least clear asks: what it cuts off is then a like part of each, and none of what a swing loses
    by = polynomial(period, 0.25 * half, noise=noise, curvature=min(bends, default=0.0))
    rows = []
    for top, lobe, curvature in zip(tops, lobes, bends, strict=True):
        reach = round(0.25 * half / period) + 1
        if lobe[0] == 0:
            continue  # the hand may hold the plant there
        if not reach <= top < time.size - reach:
            continue
        sign = float(side[top])
        if isinstance(peak, SampledPeak):
            rows.append((time[top], position[top], *sampled_peak_spread(period, noise, curvature)))
        else:
            near = slice(max(top - 2 * reach - 5, 0), top + 2 * reach + 6)
            found = fit_peak(time[near] - time[top], sign * swing[near], 0.0, 0.25 * half, noise=noise, by=by)
            if found.time_uncertainty > 0.25 * half:
                if rows:
                    break  # noise hides it, and the smaller ones after it
                continue
            rows.append(
                (time[top] + found.time, rest + sign * found.height, found.time_uncertainty, found.height_uncertainty)
            )
    return Extrema(*np.array(rows).reshape(-1, 4).T)


def is_free_response(experiment: Experiment) -> bool:
    """Tell whether nothing but its start moves the cart: a release, or one said to start in motion under one force."""
    return experiment.is_release or (experiment.starts == "motion" and not np.any(np.diff(experiment.input)))


def release_characteristics(experiment: Experiment, *, peak: Peak) -> Characteristics:
    """Read damped frequency and damping ratio off a swing without input; see `stepid.characterize`."""
    who = f"run {experiment.name!r}"
    time, position = experiment.time, experiment.position
    grid = experiment.resolution or 0.0
    noise = noise_level(position[position.size // 2 :], resolution=grid)
    rest = float(np.median(position[-max(position.size // 20, 5) :]))
    if np.abs(position - rest).max() <= max(6 * noise, 3 * grid):
        raise NoStepError(
            f"{who}: there is no step in the input and the position does not move",
            "Check the input column (or give a StepInput) and the encoder that was read.",
        )
    extrema = find_extrema(time, position, rest=rest, noise=noise, peak=peak)
    extrema, started = _free_part(extrema, position, rest)
    if extrema.time.size < 3:
        raise NoOvershootError(
            f"{who}: the released plant shows {extrema.time.size} clear turning point(s); three are needed",
            "Less damping, a larger release or a longer record; check that the input column was read.",
        )
    half_period, half_spread = _half_period(extrema)
    decrement, decrement_spread = logarithmic_decrement(extrema)
    if not decrement > 0:
        raise NotSettledError(
            f"{who}: the swing does not decay (logarithmic decrement {decrement:.3g} a half period)",
            "Cut the record to the free swing: nothing may drive or hold the plant.",
        )
    frequency = math.pi / half_period
    fraction = math.pi / math.hypot(math.pi, decrement)  # √(1 − ζ²)
    friction = constant_loss(extrema)
    notes = (
        ()
        if friction is None
        else (
            f"each swing loses about {length(friction)} beside a fixed fraction: dry friction, and the damping "
            "ratio holds its share",
        )
    )
    return Characteristics(
        name=experiment.name,
        damped_frequency=frequency,
        damping_ratio=decrement / math.hypot(math.pi, decrement),
        natural_frequency=frequency / fraction,
        uncertainty=CharacteristicsUncertainty(
            damped_frequency=frequency * half_spread / half_period,
            damping_ratio=fraction**3 / math.pi * decrement_spread,
        ),
        spring=experiment.spring,
        damper=experiment.damper,
        base=experiment.base,
        added_mass=experiment.added_mass,
        start=started,
        notes=notes,
    )


def _free_part(extrema: Extrema, position: Array, rest: float) -> tuple[Extrema, float | None]:
    """Drop the extrema that the hand may still have shaped."""
    if extrema.time.size == 0:
        return extrema, None
    size = np.abs(extrema.position - rest)
    largest = int(np.argmax(size))
    held = abs(position[0] - rest) > 0.5 * size[largest]  # let go from a displaced position, or already moving
    skip = largest if held else largest + 1  # pushed from rest: the first full swing may be the hand's
    kept = Extrema(*(column[skip:] for column in extrema))
    return kept, float(kept.time[0]) if kept.time.size else None


def _half_period(extrema: Extrema) -> tuple[float, float]:
    """Weighted slope of extremum time over its number, s, and its standard uncertainty.

    Dry friction and viscous damping leave the time between turning points at π/ω_d. Small swings weigh less: their
    times are less certain, and what is nonlinear near rest shows in them.
    """
    number = np.arange(extrema.time.size, dtype=float)
    height = _half_ranges(extrema)
    return _weighted_line(number, extrema.time, height, extrema.time_uncertainty)


def _half_ranges(extrema: Extrema) -> Array:
    """Amplitude at each turning point, m: from the ranges next to it, so that no rest position is needed."""
    ranges = np.abs(np.diff(extrema.position))
    return 0.5 * np.concatenate([ranges[:1], np.sqrt(ranges[1:] * ranges[:-1]), ranges[-1:]])


def logarithmic_decrement(extrema: Extrema) -> tuple[float, float]:
    """Logarithmic decrement a half period, and its standard uncertainty.

    Parameters
    ----------
    extrema : Extrema
        At least three turning points.

    Returns
    -------
    tuple of float
        Weighted slope of −ln of the range between successive turning points, δ = πζ/√(1 − ζ²). Ranges need no rest
        position, which dry friction shifts from half period to half period.
    """
    ranges = np.abs(np.diff(extrema.position))
    u = extrema.position_uncertainty
    relative = np.sqrt(u[1:] ** 2 + u[:-1] ** 2) / ranges
    slope, spread = _weighted_line(np.arange(ranges.size, dtype=float), np.log(ranges), ranges, relative)
    return -slope, spread


def constant_loss(extrema: Extrema) -> float | None:
    """Loss of range a half period, m, that does not shrink with the range, where it is clear; else None.

    Under viscous damping and Coulomb friction together ranges follow D' = ρD − 2(1 + ρ)F_c/k; this is the constant.
    """
    ranges = np.abs(np.diff(extrema.position))
    if ranges.size < 5:
        return None
    basis = np.column_stack([ranges[:-1], -np.ones(ranges.size - 1)])
    solution, *_ = np.linalg.lstsq(basis, ranges[1:], rcond=None)
    misfit = ranges[1:] - basis @ solution
    variance = float(misfit @ misfit) / (ranges.size - 3)
    u = extrema.position_uncertainty
    variance = max(variance, float(np.mean(u[1:] ** 2 + u[:-1] ** 2)))
    spread = math.sqrt(variance) * float(np.linalg.norm(np.linalg.pinv(basis)[1]))
    return float(solution[1]) if solution[1] > 5 * spread else None


def _weighted_line(x: Array, y: Array, weight: Array, spread: Array) -> tuple[float, float]:
    """Slope of a weighted line, and its standard uncertainty from `spread` or, where larger, from the scatter."""
    basis = np.column_stack([x, np.ones_like(x)])
    functional = np.linalg.pinv(basis * weight[:, None])[0] * weight  # of y
    solution = np.linalg.lstsq(basis * weight[:, None], y * weight, rcond=None)[0]
    expected = float(np.linalg.norm(functional * spread))
    if x.size < 4:
        return float(solution[0]), expected
    misfit = (y - basis @ solution) * weight
    unit = math.sqrt(float(misfit @ misfit) / (x.size - 2))  # spread of y at weight one
    return float(solution[0]), max(expected, unit * float(np.linalg.norm(functional / weight)))
