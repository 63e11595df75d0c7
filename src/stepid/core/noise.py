"""How large residuals are, and how noisy a record is, read off the record itself."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stepid.core.base import Array
from stepid.core.once import once

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

STILL = 2.5  # counts, less is no motion
_CLIP = 3.5  # standard deviations, beyond which kinks, jumps and outliers do not count
_CLIPPED = 1.0023  # what the standard deviation of white noise loses by that, undone
_WINDOW = 9  # samples that are taken together where noise is told from what is predicted
_LEAST = 4  # patterns of a window, the quietest, that no swing fills
_LAPS = 3  # of the swing without noise and of what its squares and cubes explain
_BLOCK = 4 * _WINDOW  # samples in a row that are kept for the test
_ENOUGH = 6  # windows for each number that is fitted to them
_COUNTS, _DEVIATIONS = 3.0, 8.0  # counts, and standard deviations of the noise, that a cart at rest may span
_SAME = 1e-9  # of the farthest reading, below which two differ by the arithmetic only
_ORDER = 6  # a settled ring-down of 11 samples a half period leaves 5e-4 of its swing in sixth differences


def rms(values: Array) -> float:
    """Root mean square, in the unit of the values, shape (n,)."""
    return float(np.sqrt(np.mean(values**2)))


def noise_level(position: Array, *, resolution: float | None = None) -> float:
    """Standard deviation of the noise on the readings, from a robust spread of high-order differences.

    Parameters
    ----------
    position : array, shape (n,)
        m; best of a segment where little moves.
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


@once
def record_noise(experiment: Experiment) -> float:
    """`noise_level` of all readings of a record, m."""
    return noise_level(experiment.position, resolution=experiment.resolution)


def span_at_rest(experiment: Experiment) -> float:
    """Largest travel that noise and rounding make of a cart at rest, m."""
    return max(_COUNTS * (experiment.resolution or 0.0), _DEVIATIONS * record_noise(experiment))


def clipped_spread(values: Array) -> float:
    """Standard deviation of values, shape (n,), of which kinks and outliers do not count."""
    spread = 1.4826 * float(np.median(np.abs(values)))
    if spread <= 0:
        spread = float(np.std(values))
    for _ in range(4):
        kept = values[np.abs(values) <= _CLIP * spread]
        spread = rms(kept) * _CLIPPED if kept.size else spread
    return spread


def floor_from_residual(residual: Array, *, parameters: int = 0) -> float:
    """Noise floor by the residual of a good fit, for where that lies below the floor read off the records.

    Parameters
    ----------
    residual : array, shape (n,)
        m, measured minus simulated.
    parameters : int
        How many were fitted; each takes one degree of freedom.

    Returns
    -------
    float
        m.

    Notes
    -----
    A fit that leaves less than the floor shows that the floor was too high: what it leaves is noise and misfit.
    """
    free = max(residual.size - parameters, 1)
    return clipped_spread(residual) * math.sqrt(residual.size / free)


def predicted_noise(position: Array, volts: Array, *, resolution: float | None = None) -> float | None:
    """Noise that neither the readings around nor the input predict, m: right where the plant swings fast.

    Parameters
    ----------
    position : array, shape (n,)
        m.
    volts : array, shape (n,)
        V, of whatever course, at the same samples.
    resolution : float or None
        m per count; windows that span no more than `STILL` of it are at rest, and left out.

    Returns
    -------
    float or None
        None where the record is too short.

    Notes
    -----
    Windows of nine readings, less what the input in them explains, hold the swing in few patterns (principal axes) and
    nothing but noise in the others: white noise has the same variance in each. Of a linear plant these are seven; of
    others the swing fills more, so that the loudest of the four quietest is taken. Where it helps, squares and cubes
    of the swing are taken out of them, beside its loud patterns and the input: a spring that bends is no noise, and
    the noise in loud patterns is not that in quiet ones. Patterns come from one half of the record, in blocks, their
    variance from the other.
    """
    y = position - position.mean()
    size = float(np.std(y))
    if size <= 0 or y.size < _WINDOW:
        return None
    windows = _windows(y)
    moves = np.ptp(windows, axis=1) > STILL * (resolution or 0.0)
    predictors = np.concatenate([np.ones((len(windows), 1)), _windows(volts)], axis=1)[moves]
    if np.count_nonzero(moves) < 2 * _ENOUGH * (predictors.shape[1] + _WINDOW):
        return None
    half = (np.arange(len(windows)) // _BLOCK % 2)[moves]
    squares = np.zeros((2, _LEAST))
    for test in (0, 1):
        there, here = half != test, half == test
        if np.count_nonzero(there) < _WINDOW:
            return None
        factors = np.linalg.lstsq(predictors[there], windows[moves][there], rcond=1e-9)[0]
        rest = windows[moves] - predictors @ factors
        _, _, axes = np.linalg.svd(rest[there], full_matrices=False)
        loud, quiet = rest @ axes[: _WINDOW - _LEAST].T, axes[_WINDOW - _LEAST :]
        small = unbent = rest @ quiet.T
        for _ in range(_LAPS):
            swing = (windows[moves] - unbent @ quiet) / size
            bent = np.concatenate([predictors, loud, swing**2, swing**3], axis=1)
            unbent = small - bent @ np.linalg.lstsq(bent[there], small[there], rcond=1e-9)[0]
        squares += [np.sum(small[here] ** 2, axis=0), np.sum(unbent[here] ** 2, axis=0)]
    return math.sqrt(float(squares.max(axis=1).min()) / half.size)


def _windows(values: Array) -> Array:
    out: Array = np.lib.stride_tricks.sliding_window_view(values, _WINDOW)
    return out


@once
def record_grid(experiment: Experiment) -> float | None:
    """`apparent_resolution` of a record's readings."""
    return apparent_resolution(experiment.position)


def apparent_resolution(position: Array) -> float | None:
    """Step of the grid that all readings lie on, m, or None where they lie on none.

    Parameters
    ----------
    position : array, shape (n,)
        m.
    """
    gaps = _gaps(position)
    if gaps.size < 2:
        return None
    step = float(gaps.min())
    counts = gaps / step
    return step if np.all(np.abs(counts - np.round(counts)) < 0.02) and counts.max() < 1e4 else None


@once
def reading_step(experiment: Experiment) -> float:
    """Step of a record's readings, m: that of its encoder where it is stated, else the least two readings differ by.

    Of readings finer than the motion the latter is next to nothing. A grid need not be even: degrees that are rounded
    lie on none.

    Parameters
    ----------
    experiment : Experiment
    """
    if experiment.resolution is not None:
        return experiment.resolution
    gaps = _gaps(experiment.position)
    return float(gaps.min()) if gaps.size else 0.0


def _gaps(position: Array) -> Array:
    """What readings that follow one another in size differ by, m."""
    gaps = np.diff(np.unique(position))
    out: Array = gaps[gaps > _SAME * np.abs(position).max()] if gaps.size else gaps
    return out
