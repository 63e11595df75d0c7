"""Paths of affine plants between events: Taylor series, whose coefficients give the state at any moment."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array

_TERMS = 48
_SMALL = 1e-13  # of the largest so far, of a term that no longer matters
_STEPS = 30
_SAME = 1e-12  # of a stretch, of a step of Newton's that is the last
_NOTHING = 1e-16  # m and m/s, the same where all are small


def series(slope: Array, rates: Array, length: Array) -> Array | None:
    """Coefficients of the paths of affine plants, z(t) − z(0) = Σ_k c_k t^(k+1).

    Parameters
    ----------
    slope : array, shape (d, d, lanes)
        A in z' = A z + b, 1/s.
    rates : array, shape (d, lanes)
        z'(0).
    length : array, shape (lanes,)
        s, up to which the series is wanted.

    Returns
    -------
    array, shape (n, d, lanes), or None
        None where so many terms do not do: the step is too long for the plant's fastest motion.
    """
    terms = [rates]
    size = np.abs(rates * length)
    largest, power = size, length
    for k in range(2, _TERMS):
        terms.append(np.einsum("ijs,js->is", slope, terms[-1]) / k)
        power = power * length
        size = np.abs(terms[-1] * power)
        largest = np.fmax(largest, size)
        if not (size > _SMALL * largest + _NOTHING).any():  # what is not finite has no series either
            return np.array(terms)
    return None


def along(coefficients: Array, time: Array) -> Array:
    """Sum Σ_k c_k t^(k+1) at one moment t [s] of each lane, shape (d, lanes) or (lanes,) like a coefficient."""
    total: Array = coefficients[-1] * time
    for c in coefficients[-2::-1]:
        total += c
        total *= time
    return total


def crossing(start: Array, coefficients: Array, length: Array, end: Array) -> Array:
    """Moment at which start + Σ_k c_k t^(k+1), positive just after 0, has become negative by the end, shape (lanes,).

    Parameters
    ----------
    start, length, end : arrays, shape (lanes,)
        Value at 0; s, length of the stretch; value there, below 0.
    coefficients : array, shape (n, lanes)
    """
    rising = coefficients[0] * length
    bend = end - start - rising
    root = np.sqrt(np.maximum(rising**2 - 4 * bend * start, 0.0))
    share = np.where(rising > 0, -(rising + root) / (2 * np.where(bend < 0, bend, -1.0)), 2 * start / (root - rising))
    at: Array = length * np.clip(np.nan_to_num(share, nan=0.5), 0.0, 1.0)  # on the parabola
    low, high = np.zeros_like(length), length
    powers = np.arange(2, len(coefficients) + 1)[:, None]
    slopes = coefficients[1:] * powers
    for _ in range(_STEPS):
        value = start + along(coefficients, at)
        slope = coefficients[0] + along(slopes, at)
        past = value < 0
        low, high = np.where(past, low, at), np.where(past, at, high)
        step = value / slope
        newton = at - step
        at = np.where((newton >= low) & (newton <= high), newton, 0.5 * (low + high))
        if not (np.abs(step) > _SAME * length).any():
            break
    return at
