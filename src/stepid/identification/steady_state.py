"""Where a response comes to rest, and when."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array

_SETTLED = 0.01  # envelope, as a fraction of the steady displacement, from where on the tail counts
_MANY = 100_000  # samples of a tail, beyond which it is fitted the quicker way
_WELL = 1e8  # condition of the normal equations that loses half of the digits
_SLOW, _FAST = 1.5, 8.0  # times the frequency of the swing
_BINS = 3  # frequencies that tell a level
_CHANCE = 3.0  # standard errors
_LONG = 1001  # samples of a window, beyond which fast convolution smooths


class SteadyState(NamedTuple):
    """The level a tail decays to, its standard uncertainty, the first sample used, and what is left; m, m, index, m."""

    level: float
    uncertainty: float
    first: int
    residual: Array


def steady_state(
    time: Array,
    position: Array,
    *,
    peak_time: float,
    damped_frequency: float,
    damping_ratio: float,
    overshoot: float,
    noise: float,
) -> SteadyState:
    """Find the level that the tail of a response decays to.

    Parameters
    ----------
    time : array, shape (n,)
        s, from the step.
    position : array, shape (n,)
        m.
    peak_time, damped_frequency, damping_ratio, overshoot : float
        s, rad/s, –, –; of the response.
    noise : float
        m, standard deviation of a reading.

    Returns
    -------
    SteadyState

    Notes
    -----
    The tail begins where the envelope is below 1 %, or one period before the end of a shorter record. A constant and
    the decaying oscillation of the given frequency and damping ratio are fitted to it, so that what still rings
    does not bias the level as it would bias a mean.
    """
    half_period = math.pi / damped_frequency
    decay = damped_frequency * damping_ratio / math.sqrt(1 - damping_ratio**2)
    quiet = peak_time + max(math.log(overshoot / _SETTLED), 0.0) / max(decay, 1e-12)
    begin = max(min(quiet, float(time[-1]) - 2 * half_period), peak_time)
    first = min(int(np.searchsorted(time, begin)), time.size - 4)
    since = time[first:] - time[first]
    envelope = np.exp(-decay * since)
    basis = np.column_stack(
        [np.ones_like(since), envelope * np.cos(damped_frequency * since), envelope * np.sin(damped_frequency * since)]
    )
    reference = float(position[-1])  # keeps an added constant out of the rounding
    coefficients, spread = _solved(basis, position[first:] - reference)
    misfit = position[first:] - reference - basis @ coefficients
    rms = float(np.sqrt(misfit @ misfit / max(since.size - 3, 1)))
    spread *= noise
    if rms > 1.5 * noise:  # what is left is no white noise: count half periods, not samples
        spread = math.hypot(spread, rms / math.sqrt(max(float(since[-1]) / half_period, 1.0)))
    return SteadyState(reference + float(coefficients[0]), spread, first, misfit)


def colored_noise(residual: Array, sample_time: float, peak_time: float, noise: float) -> float:
    """Noise as a curve through a peak sees it, m: that of white noise with as much power among its frequencies.

    Parameters
    ----------
    residual : array, shape (n,)
        m, what is left of a settled tail.
    sample_time, peak_time : float
        s.
    noise : float
        m, of a reading by its successive differences, which miss what is slow.

    Returns
    -------
    float
        m; `noise` where that is exceeded by chance only, or the tail is too short to tell.

    Notes
    -----
    The mean of the periodogram from 1.5 to 8 times the frequency of the swing: below lies what is left of the swing,
    above what the curve, fitted over a quarter of the peak time to either side, does not follow.
    """
    frequency = np.fft.rfftfreq(residual.size, sample_time) * 2 * peak_time  # of the swing's
    seen = (frequency > _SLOW) & (frequency < _FAST)
    if np.count_nonzero(seen) < _BINS:
        return noise
    power = np.abs(np.fft.rfft(residual - residual.mean()))[seen] ** 2 / residual.size
    mean = float(np.mean(power))
    return math.sqrt(mean) if mean > noise**2 * (1 + _CHANCE / math.sqrt(power.size)) else noise


def _solved(basis: Array, values: Array) -> tuple[Array, float]:
    """Coefficients by least squares, and the standard uncertainty of the first for white noise of 1."""
    if len(basis) > _MANY:  # normal equations are quick, and exact enough where nothing nearly cancels
        normal = basis.T @ basis
        if np.linalg.cond(normal) < _WELL:
            covariance = np.linalg.inv(normal)
            return covariance @ (values @ basis), math.sqrt(covariance[0, 0])
    inverse = np.linalg.pinv(basis)
    return inverse @ values, float(np.linalg.norm(inverse[0]))


def last_swing(time: Array, position: Array, half_period: float) -> float:
    """Half the range of the position over the last half period, m."""
    last = position[time >= time[-1] - half_period]
    return 0.5 * float(np.ptp(last))


def settling_time_measured(
    time: Array, swing: Array, *, level: float, half_period: float, noise: float, spread: float, band: float = 0.02
) -> tuple[float, float] | None:
    """Time from the step after which a record stays within a band around its steady state.

    Parameters
    ----------
    time, swing : array, shape (n,)
        s, from the step; m, displacement from rest, outward positive.
    level : float
        m, steady displacement.
    half_period : float
        s; the record must stay within the band at least that long for the answer to count.
    noise, spread : float
        m, standard deviation of a reading and standard uncertainty of `level`.
    band : float
        Fraction of the steady displacement.

    Returns
    -------
    tuple of float or None
        s: the time, between samples, and its standard uncertainty: a quarter of the time between leaving a band wider
        and one narrower by two standard deviations, so that an extremum that grazes the band counts. None where the
        record ends too early or noise fills the band.
    """
    error = np.abs(swing - level)
    window = 2 * round(0.15 * half_period / float(time[1] - time[0])) + 1
    if noise > 0 and 5 <= window < time.size:  # a cubic over ±0.15 half periods bends the response by less than 1e-3
        from scipy.signal import savgol_coeffs

        error = np.abs(_smoothed(swing - level, window))
        noise *= float(np.linalg.norm(savgol_coeffs(window, 3)))
    margin, width = 2 * math.hypot(noise, spread), band * abs(level)
    if margin >= width:
        return None
    late, usual, early = (_last_exit(time, error, limit) for limit in (width - margin, width, width + margin))
    if late is None or usual is None or time[-1] - late < half_period:
        return None
    return usual, (late - (early or 0.0)) / 4


def _smoothed(values: Array, window: int) -> Array:
    """Values, shape (n,), smoothed by a cubic over each window, an odd number of samples; n is larger."""
    from scipy.signal import oaconvolve, savgol_coeffs, savgol_filter

    if window <= _LONG:
        return np.asarray(savgol_filter(values, window, 3))
    half = window // 2  # the same by fast convolution: the filter takes samples times window
    place = np.linspace(-1.0, 1.0, window)
    first, last = (np.polynomial.Polynomial.fit(place, part, 3) for part in (values[:window], values[-window:]))
    middle = oaconvolve(values, savgol_coeffs(window, 3), mode="valid")
    return np.concatenate([first(place[:half]), middle, last(place[-half:])])


def _last_exit(time: Array, error: Array, limit: float) -> float | None:
    """Time after which `error` stays below a limit, by linear interpolation; None where it never does."""
    outside = np.flatnonzero(error > limit)
    if not outside.size or outside[-1] + 1 >= time.size:
        return None
    i = int(outside[-1])
    fraction = float((error[i] - limit) / (error[i] - error[i + 1]))
    return float(time[i]) + fraction * float(time[i + 1] - time[i])
