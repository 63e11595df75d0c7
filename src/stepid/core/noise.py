"""How large residuals are, and how noisy a record is, read off the record itself."""

from __future__ import annotations

import math

import numpy as np

from stepid.core.base import Array

_ORDER = 6  # a settled ring-down of 11 samples a half period leaves 5e-4 of its swing in sixth differences


def rms(values: Array) -> float:
    """Root mean square, in the unit of the values, shape (n,)."""
    return float(np.sqrt(np.mean(values**2)))


def noise_level(position: Array, *, resolution: float | None = None) -> float:
    """Standard deviation of the noise on the readings, from a robust spread of high-order differences.

    Parameters
    ----------
    position : array, shape (n,)
        m; best of a stretch where little moves.
    resolution : float or None
        m per count; the result is not below resolution/√12, the spread of rounding.

    Returns
    -------
    float
        m.

    Notes
    -----
    Differences of order p of white noise have the variance σ²·C(2p, p), while anything smooth cancels. The spread is
    the median absolute value times 1.4826, so that single jumps do not count.
    """
    order = min(_ORDER, max(position.size - 2, 0))
    floor = 0.0 if resolution is None else resolution / math.sqrt(12)
    if order < 1:
        return floor
    differences = np.diff(position, order)
    spread = 1.4826 * float(np.median(np.abs(differences))) / math.sqrt(math.comb(2 * order, order))
    return max(spread, floor)


def apparent_resolution(position: Array) -> float | None:
    """Step of the grid that all readings lie on, m, or None where they lie on none.

    Parameters
    ----------
    position : array, shape (n,)
        m.
    """
    gaps = np.diff(np.unique(position))
    gaps = gaps[gaps > 1e-9 * np.abs(position).max()] if gaps.size else gaps
    if gaps.size < 2:
        return None
    step = float(gaps.min())
    counts = gaps / step
    return step if np.all(np.abs(counts - np.round(counts)) < 0.02) and counts.max() < 1e4 else None
