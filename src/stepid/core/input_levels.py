"""Levels that an input is held at, where it was measured: readings scatter about each like white noise."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stepid.core.base import Array, Index

STEP = 0.05
"""Of the input's range: a smaller change is noise on it."""
_CLEAR = 6.0  # standard deviations of a change by noise, beyond which it is a step
_FEWEST = 8  # samples of a level whose scatter says something
_WHITE = 0.5  # von Neumann ratio over 2, below which a level drifts or sags: what the drive did, and no noise


def most_steps(samples: int) -> int:
    """Changes of an input of so many samples beyond which it is no sequence of levels that are held."""
    return max(2, samples // 8)


def level_bounds(values: Array) -> Index | None:
    """First sample of each level, and the number of samples; None where the input is exact, or no noise on levels.

    Parameters
    ----------
    values : array, shape (n,)
        V.
    """
    bounds = step_bounds(values)
    if bounds.size > most_steps(values.size):
        return None
    about = [part - part.mean() for part in (values[a:b] for a, b in pairwise(bounds)) if part.size >= _FEWEST]
    scatters = any(np.ptp(part) > 0 for part in about)
    return bounds if scatters and all(map(_is_white, about)) else None


def step_bounds(values: Array) -> Index:
    """First sample of each stretch between two steps that no noise makes, and the number of samples.

    Parameters
    ----------
    values : array, shape (n,)
        V.
    """
    change = np.abs(np.diff(values))
    clear = max(STEP * float(np.ptp(values)), _CLEAR * 1.4826 * float(np.median(change))) if change.size else 0.0
    return np.concatenate([[0], np.flatnonzero(change > clear) + 1, [values.size]]).astype(np.intp)


def _is_white(scatter: Array) -> bool:
    """Tell whether what is read of a level knows nothing of its neighbors."""
    return float(np.sum(np.diff(scatter) ** 2)) >= 2 * _WHITE * float(scatter @ scatter)
