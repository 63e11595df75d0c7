"""Where the first peak is: between samples, or at a sample as the paper reads it."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from stepid.core.base import Array, Model
from stepid.core.takes import able, optional
from stepid.identification.second_order import damping_ratio, natural_frequency

_WINDOW = 0.25  # half width of the fitted segment, as a fraction of the peak time
_CLEAR = 2.0  # times what degree 3 cuts off, within which degree 5 tells the time
_POINTS = 9  # at least so many samples in the segment


class Polynomial(NamedTuple):
    """Degree of a polynomial, and what cutting the series there leaves in closed forms of damping ratio 0.1 to 0.6.

    Of the time as a fraction of the half width, and of the height as a fraction of it.
    """

    degree: int
    cut_time: float
    cut_height: float


FINE, COARSE = Polynomial(5, 1e-4, 1e-5), Polynomial(3, 5e-3, 1e-3)


class PeakReading(NamedTuple):
    """A peak's time and height from the start of the swing, their standard uncertainties, and their covariance.

    The biases are the expected errors of time and height, which `ErrorsInVariables` takes off.
    """

    time: float
    height: float
    time_uncertainty: float
    height_uncertainty: float
    covariance: float
    time_bias: float = 0.0
    height_bias: float = 0.0


class SampledPeak(Model):
    """The largest sample, as the paper picks its peaks: `sampled_peak_spread` tells how far off it is."""

    def locate(self, time: Array, swing: Array, *, level: float, noise: float) -> PeakReading:
        """Read the peak of a swing.

        Parameters
        ----------
        time : array, shape (n,)
            s, uniform, from the step.
        swing : array, shape (n,)
            m, displacement from rest, outward positive.
        level : float
            m, steady displacement.
        noise : float
            m, standard deviation of a reading.

        Returns
        -------
        PeakReading
        """
        i = int(np.argmax(swing))
        period = float(time[1] - time[0])
        overshoot = min(max(float(swing[i]) / level - 1, 1e-6), 0.999)
        frequency = natural_frequency(math.pi / float(time[i]), damping_ratio(overshoot))
        curvature = level * frequency**2 * overshoot
        time_spread, height_spread = sampled_peak_spread(period, noise, curvature)
        rate = damping_ratio(overshoot) * frequency  # ζω_n: beyond the peak the response falls more slowly
        return PeakReading(
            time=float(time[i]),
            height=float(swing[i]),
            time_uncertainty=time_spread,
            height_uncertainty=height_spread,
            covariance=0.0,
            time_bias=rate * time_spread**2,
            height_bias=sampled_height_bias(period, noise, curvature),
        )


def sampled_peak_spread(period: float, noise: float, curvature: float) -> tuple[float, float]:
    """Standard uncertainties of time and height of the largest of noisy samples of a parabola.

    Parameters
    ----------
    period : float
        s, sample time T.
    noise : float
        m, standard deviation σ of a reading.
    curvature : float
        m/s², |ÿ| at the peak: y_ss ω_n² M_p for a step response.

    Returns
    -------
    tuple of float
        s, m. The time is uniform within half a sample, T²/12, and noise moves it: by about ½σ/|ÿ| in variance where
        κ = σ/(|ÿ|T²) exceeds 0.3, by less where the next sample is too low to win. The height is low by ½|ÿ|δ²,
        root mean square |ÿ|T²/(8√5), and carries the noise.

    Notes
    -----
    The weight of the second term is a fit to simulated maxima of parabolas: the standard deviation is within 3 % for κ
    up to 3, 7 % at κ = 10.
    """
    if curvature <= 0:
        return float("inf"), float("inf")
    moved = noise / (curvature * period**2)  # κ
    variance = 1 / 12 + 0.57 * moved * moved**1.5 / (moved**1.5 + 0.05)
    return period * math.sqrt(variance), math.hypot(noise, curvature * period**2 / (8 * math.sqrt(5)))


def sampled_height_bias(period: float, noise: float, curvature: float) -> float:
    """Expected error of the height of the largest of noisy samples of a parabola, m; see `sampled_peak_spread`.

    Notes
    -----
    Between samples the height is low by |ÿ|T²/24. That the largest is picked lifts it by κσ while κ is small, where two
    samples compete, and by σ times the logarithm of their number beyond; the closed form is within 4 % of simulated
    maxima for κ from 0.1 to 20.
    """
    if curvature <= 0:
        return 0.0
    moved = noise / (curvature * period**2)  # κ
    rivals = 7.0 - (7.0 - 1 / 0.29) / (1 + moved**2 / 0.048)
    return noise * 0.29 * math.log1p(rivals * moved) - curvature * period**2 / 24


class InterpolatedPeak(Model):
    """The peak between samples: a polynomial of degree 5, or 3 in noise, over ±0.25 peak times around it."""

    def locate(self, time: Array, swing: Array, *, level: float, noise: float) -> PeakReading:
        """Read the peak of a swing; see `SampledPeak.locate`."""
        rough = SampledPeak().locate(time, swing, level=level, noise=noise)
        half, curvature = _WINDOW * rough.time, max(rough.height - level, 0.0) * (math.pi / rough.time) ** 2
        chosen = polynomial(float(time[1] - time[0]), half, noise=noise, curvature=curvature)
        return fit_peak(time, swing, rough.time, half, noise=noise, by=chosen)


class Peak(Protocol):
    """How the first peak of a step is read: `InterpolatedPeak`, `SampledPeak`, or one of your own.

    The turning points of a hand release are read between samples, but with `SampledPeak`.
    """

    def locate(self, time: Array, swing: Array, *, level: float, noise: float) -> PeakReading:
        """Read the peak of a swing; see `SampledPeak.locate`."""


a_peak = optional(able("locate", "a way to read peaks with its brackets, as InterpolatedPeak()"))
"""Check of an argument `peak`."""


def polynomial(period: float, half_width: float, *, noise: float, curvature: float) -> Polynomial:
    """Choose how a maximum is read, before it is: by what tells its time the better, as far as is expected.

    Degree 5 follows the shape of the peak closely; where noise makes its maximum vaguer than what degree 3 cuts off,
    degree 3 is used. By its own reading the fifth is too sure of itself: what follows the noise looks sharp.

    Parameters
    ----------
    period, half_width : float
        s, of the samples; of the segment to fit.
    noise : float
        m, standard deviation of a reading.
    curvature : float
        m/s², expected at the maximum.
    """
    half = _half(half_width, period)
    count = int(half / period)
    basis_at = period * np.arange(-count, count + 1) / half

    def spread(by: Polynomial) -> float:
        inverse: Array = np.linalg.pinv(np.polynomial.chebyshev.chebvander(basis_at, by.degree))
        tilt = float(np.linalg.norm(_tilt(inverse, 0.0, half)))
        return math.hypot(noise * tilt / curvature if curvature > 0 else math.inf, by.cut_time * half)

    return FINE if spread(FINE) <= max(_CLEAR * COARSE.cut_time * half, spread(COARSE)) else COARSE


def fit_peak(
    time: Array, swing: Array, near: float, half_width: float, *, noise: float, by: Polynomial = FINE
) -> PeakReading:
    """Fit a polynomial around a maximum, iterating until the window is centered on it.

    Parameters
    ----------
    time, swing : array, shape (n,)
        s, m; the maximum is outward positive.
    near : float
        s, first guess of its time.
    half_width : float
        s, half the segment to fit; widened to hold enough samples.
    noise : float
        m, standard deviation of a reading.
    by : Polynomial
        See `polynomial`.

    Returns
    -------
    PeakReading
        Its uncertainties come from the least-squares covariance with the noise, or with the misfit where the
        polynomial leaves more than the noise; infinite where noise hides the maximum.
    """
    degree, cut_time, cut_height = by
    half = _half(half_width, float(time[1] - time[0]))
    center, seen = near, set()
    reach = half + 1e-6 * float(time[1] - time[0])  # a sample at the very edge is inside, whatever its rounding
    while True:
        inside = np.flatnonzero(np.abs(time - center) <= reach)
        if inside.size <= degree + 1 or abs(center - near) > 2 * half:
            return PeakReading(near, float(np.max(swing)), math.inf, math.inf, 0.0)
        key = (int(inside[0]), int(inside[-1]))
        basis = np.polynomial.chebyshev.chebvander((time[inside] - center) / half, degree)
        coefficients = np.asarray(np.linalg.lstsq(basis, swing[inside], rcond=None)[0], dtype=np.float64)
        place = _maximum(coefficients)
        if key in seen:
            break
        seen.add(key)
        center += half * place
    curve = np.polynomial.Chebyshev(coefficients)
    curvature = -float(curve.deriv(2)(place)) / half**2
    misfit = swing[inside] - basis @ coefficients
    spread = max(noise, float(np.sqrt(misfit @ misfit / (inside.size - degree - 1))))
    inverse: Array = np.asarray(np.linalg.pinv(basis), dtype=np.float64)
    height = np.polynomial.chebyshev.chebvander(np.array([place]), degree)[0] @ inverse
    tilt = _tilt(inverse, place, half)
    top = float(curve(place))
    if abs(place) >= 1 or curvature <= 0:
        return PeakReading(center + half * place, top, math.inf, math.inf, 0.0)
    return PeakReading(
        time=center + half * place,
        height=top,
        time_uncertainty=math.hypot(spread * float(np.linalg.norm(tilt)) / curvature, cut_time * half),
        height_uncertainty=math.hypot(spread * float(np.linalg.norm(height)), cut_height * abs(top)),
        covariance=spread**2 * float(height @ tilt) / curvature,
    )


def _half(half_width: float, period: float) -> float:
    """Half the segment to fit, s, widened to hold enough samples."""
    return max(half_width, 0.5 * (_POINTS - 0.5) * period)


def _tilt(inverse: Array, place: float, half: float) -> Array:
    """What each reading adds to the slope of the polynomial at a place within ±1, 1/s; `inverse` solves for it."""
    slopes = [float(np.polynomial.Chebyshev(row).deriv()(place)) for row in np.eye(inverse.shape[0])]
    out: Array = np.array(slopes) / half @ inverse
    return out


def _maximum(coefficients: Array) -> float:
    """Place of the highest maximum of a Chebyshev series within [−1, 1], or the higher end where there is none."""
    roots = np.polynomial.chebyshev.chebroots(np.polynomial.chebyshev.chebder(coefficients))
    real = np.real(roots[np.abs(np.imag(roots)) < 1e-8])
    places = np.concatenate([real[np.abs(real) < 1], [-1.0, 1.0]])
    return float(places[np.argmax(np.polynomial.chebyshev.chebval(places, coefficients))])
