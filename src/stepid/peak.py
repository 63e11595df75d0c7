"""Where the first peak is: between samples, or at a sample as the paper reads it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stepid._base import Array, Model
from stepid.errors import NoOvershootError
from stepid.second_order import damping_ratio, natural_frequency

_WINDOW = 0.25  # half width of the fitted stretch, as a fraction of the peak time
_DEGREE = 5
_POINTS = 9  # at least so many samples in the stretch
# what cutting the series at degree 5 leaves, by comparison with closed forms (damping ratio 0.1 to 0.6)
_CUT_TIME = 1e-4  # of the half width
_CUT_HEIGHT = 1e-5  # of the height


class PeakReading(NamedTuple):
    """A peak's time and height from the start of the swing, their standard uncertainties, and their covariance."""

    time: float
    height: float
    time_uncertainty: float
    height_uncertainty: float
    covariance: float


class SampledPeak(Model):
    """The largest sample, as the paper picks its peaks.

    Its time is off by up to half a sample, and noise moves it further: u² = T²/12 + ½σ/|ÿ| with the curvature
    |ÿ| = y_ss ω_n² M_p at the peak.
    """

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
        lost = 0.5 * curvature * period**2 / 12  # how much a sample next to the peak is low, on average
        return PeakReading(
            time=float(time[i]),
            height=float(swing[i]),
            time_uncertainty=math.sqrt(period**2 / 12 + 0.5 * noise / curvature),
            height_uncertainty=math.hypot(noise, lost),
            covariance=0.0,
        )


class InterpolatedPeak(Model):
    """The peak between samples: a polynomial of degree 5, by least squares over ±0.25 peak times around it."""

    def locate(self, time: Array, swing: Array, *, level: float, noise: float) -> PeakReading:
        """Read the peak of a swing; see `SampledPeak.locate`."""
        rough = SampledPeak().locate(time, swing, level=level, noise=noise)
        return fit_peak(time, swing, rough.time, _WINDOW * rough.time, noise=noise)


Peak = InterpolatedPeak | SampledPeak


def fit_peak(time: Array, swing: Array, near: float, half_width: float, *, noise: float) -> PeakReading:
    """Fit a polynomial around a maximum, iterating until the window is centered on it.

    Parameters
    ----------
    time, swing : array, shape (n,)
        s, m; the maximum is outward positive.
    near : float
        s, first guess of its time.
    half_width : float
        s, half the stretch to fit; widened to hold enough samples.
    noise : float
        m, standard deviation of a reading.

    Returns
    -------
    PeakReading
        Its uncertainties come from the least-squares covariance with the noise, or with the misfit where the
        polynomial leaves more than the noise.

    Raises
    ------
    stepid.errors.NoOvershootError
        If the maximum drifts out of the record.
    """
    period = float(time[1] - time[0])
    half = max(half_width, 0.5 * (_POINTS - 0.5) * period)
    center, seen = near, set()
    while True:
        if not time[0] <= center <= time[-1]:
            raise NoOvershootError(
                "the outward motion ends in no peak within the record",
                "Eqs. 7 and 8 need an overshoot: less damping, more mass or a stiffer spring; stepid.fit needs none.",
            )
        inside = np.flatnonzero(np.abs(time - center) <= half)
        key = (int(inside[0]), int(inside[-1]))
        offset = (time[inside] - center) / half
        basis = np.polynomial.chebyshev.chebvander(offset, _DEGREE)
        coefficients = np.asarray(np.linalg.lstsq(basis, swing[inside], rcond=None)[0], dtype=np.float64)
        place = _maximum(coefficients)
        if key in seen:
            break
        seen.add(key)
        center += half * place
    curve = np.polynomial.Chebyshev(coefficients)
    curvature = -float(curve.deriv(2)(place)) / half**2
    misfit = swing[inside] - basis @ coefficients
    spare = max(inside.size - _DEGREE - 1, 1)
    spread = max(noise, float(np.sqrt(misfit @ misfit / spare)))
    inverse = np.linalg.pinv(basis)
    unit = np.polynomial.chebyshev.chebvander(np.array([place]), _DEGREE)[0]
    slope = np.array([float(np.polynomial.Chebyshev.basis(j).deriv()(place)) for j in range(_DEGREE + 1)]) / half
    height, tilt = unit @ inverse, slope @ inverse
    curvature = max(curvature, 1e-300)
    return PeakReading(
        time=center + half * place,
        height=float(curve(place)),
        time_uncertainty=math.hypot(spread * float(np.linalg.norm(tilt)) / curvature, _CUT_TIME * half),
        height_uncertainty=math.hypot(spread * float(np.linalg.norm(height)), _CUT_HEIGHT * abs(float(curve(place)))),
        covariance=spread**2 * float(height @ tilt) / curvature,
    )


def _maximum(coefficients: Array) -> float:
    """Place of the maximum of a Chebyshev series on [−1, 1]."""
    roots = np.polynomial.chebyshev.chebroots(np.polynomial.chebyshev.chebder(coefficients))
    real = np.real(roots[np.abs(np.imag(roots)) < 1e-8])
    places = np.concatenate([[-1.0, 1.0], real[np.abs(real) <= 1]])
    return float(places[np.argmax(np.polynomial.chebyshev.chebval(places, coefficients))])
