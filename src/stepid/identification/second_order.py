"""Closed-form relations of the standard second-order step response (Eqs. 3, 4, 7, 8), one pure function a quantity."""

from __future__ import annotations

import math

from stepid.errors import InputError, NoOvershootError


def damped_frequency(peak_time: float) -> float:
    """Damped natural frequency from the peak time (Eq. 7).

    Parameters
    ----------
    peak_time : float
        s, from the step to the first peak.

    Returns
    -------
    float
        ω_d = π/t_p, rad/s.

    Raises
    ------
    stepid.errors.InputError
        If the peak time is not positive.
    """
    if not peak_time > 0:
        raise InputError(f"a peak time of {peak_time} s is not positive", "Count it from the step to the first peak.")
    return math.pi / peak_time


def damping_ratio(overshoot: float) -> float:
    """Damping ratio from the overshoot (Eq. 8).

    Parameters
    ----------
    overshoot : float
        Decimal fraction M_p = (y_peak − y_ss)/y_ss, above 0 and below 1.

    Returns
    -------
    float
        ζ = −ln M_p/√(ln² M_p + π²).

    Raises
    ------
    stepid.errors.NoOvershootError
        If the overshoot is not between 0 and 1.
    """
    if not 0 < overshoot < 1:
        raise NoOvershootError(
            f"an overshoot of {overshoot:.3g} is not between 0 and 1",
            "Eq. 8 needs an underdamped response: less damping, more mass or a stiffer spring.",
        )
    decrement = -math.log(overshoot)
    return decrement / math.hypot(decrement, math.pi)


def damping_ratio_slope(overshoot: float, damping_ratio: float) -> float:
    """Derivative of the damping ratio by the overshoot, by which errors of the one pass to the other (Eq. 8).

    Parameters
    ----------
    overshoot : float
        Decimal fraction M_p, above 0.
    damping_ratio : float
        At least 0 and below 1.

    Returns
    -------
    float
        dζ/dM_p = −(1 − ζ²)^(3/2)/(π M_p), below zero.
    """
    return -(damped_fraction(damping_ratio) ** 3) / (math.pi * overshoot)


def overshoot_of(damping_ratio: float) -> float:
    """Overshoot M_p = exp(−ζπ/√(1 − ζ²)) of a damping ratio, the inverse of Eq. 8.

    Parameters
    ----------
    damping_ratio : float
        At least 0 and below 1.

    Returns
    -------
    float
        Decimal fraction.
    """
    return math.exp(-damping_ratio * math.pi / damped_fraction(damping_ratio))


def overshoot_of_plant(mass: float, stiffness: float, damping: float) -> float:
    """Overshoot M_p of a plant's step response, 0 where it does not swing.

    Parameters
    ----------
    mass, stiffness, damping : float
        kg, N/m, N·s/m.
    """
    ratio = damping / 2 / math.sqrt(stiffness * mass)
    return overshoot_of(ratio) if ratio < 1 else 0.0


def damped_fraction(damping_ratio: float) -> float:
    """Ratio of damped to undamped natural frequency, √(1 − ζ²).

    Raises
    ------
    stepid.errors.NoOvershootError
        If the damping ratio is not at least 0 and below 1.
    """
    if not 0 <= damping_ratio < 1:
        raise NoOvershootError(
            f"a damping ratio of {damping_ratio:.4g} is not at least 0 and below 1",
            "Only an underdamped response oscillates: less damping, more mass or a stiffer spring.",
        )
    return math.sqrt(1.0 - damping_ratio**2)


def natural_frequency(damped_frequency: float, damping_ratio: float) -> float:
    """Undamped natural frequency ω_n = ω_d/√(1 − ζ²), rad/s (with Eq. 5, ω_n² = k/m)."""
    return damped_frequency / damped_fraction(damping_ratio)


def settling_time(natural_frequency: float, damping_ratio: float, *, band: float = 0.02) -> float:
    """Settling time of the ideal response: last entry of its exact oscillation into the band.

    Parameters
    ----------
    natural_frequency : float
        rad/s.
    damping_ratio : float
        Above 0 and below 1.
    band : float
        Fraction of the steady state.

    Returns
    -------
    float
        s, from the step.

    Notes
    -----
    The response leaves the band for the last time near the last extremum that is larger than the band; extrema
    follow each other every π/ω_d and shrink by M_p each.
    """
    fraction = damped_fraction(damping_ratio)
    decay, frequency = damping_ratio * natural_frequency, natural_frequency * fraction
    if decay <= 0:
        raise NoOvershootError("an undamped response never settles", "Its settling time does not exist.")
    extremum = math.floor(math.log(band) / (-decay * math.pi / frequency))  # number of the last one beyond the band
    low, high = extremum * math.pi / frequency, (extremum + 1) * math.pi / frequency
    sign = 1.0 if extremum % 2 else -1.0

    def error(t: float) -> float:
        return -math.exp(-decay * t) * (math.cos(frequency * t) + decay / frequency * math.sin(frequency * t))

    for _ in range(80):  # bisection: the error is monotone between two extrema
        middle = 0.5 * (low + high)
        low, high = (middle, high) if sign * error(middle) > band else (low, middle)
    return 0.5 * (low + high)
