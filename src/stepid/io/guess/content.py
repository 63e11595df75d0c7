"""What the readings of a column look like: a clock, an input, a position."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.io.guess.words import Role

_FEWEST = 8  # readings
_LEVELS = 12  # an input steps through no more
_EVEN = 0.3  # of the usual step, by which stamps of samples may differ; but for
_MOST = 0.9  # of them: beside dropped samples
_ZERO = 0.02  # of its span, from which an uneven clock starts
_HALVES = 0.1  # of its span, by which its middle row is off the middle at most: a cart that comes to rest slows down


def kind(values: Array, index: int) -> Role:
    """What a column looks like: time rises evenly, or stands first; an input has few levels, a position many."""
    kept = values[np.isfinite(values)]
    if kept.size < _FEWEST:
        return "other"
    if rises_evenly(kept) or (index == 0 and _runs_on(kept)):
        return "time"
    levels = np.unique(kept).size
    if levels == 1:  # a setting or an uncertainty: an input that never changes is no step
        return "other"
    if levels <= _LEVELS and np.count_nonzero(np.diff(kept)) <= _LEVELS:
        return "input"
    return "position"


def counts_rows(values: Array) -> bool:
    """Tell the numbers of rows, from 0 or 1 on, as a table's index that nobody named: no clock."""
    kept = values[np.isfinite(values)]
    return bool(kept.size >= _FEWEST and kept[0] in (0.0, 1.0) and np.all(np.diff(kept) == 1.0))


def rises_evenly(values: Array) -> bool:
    """Tell readings, NaN where there is none, that rise by one step from row to row, as a time or an index does.

    Samples may be dropped; or the digits that are printed may hide the step: then each is on one line to its last.
    """
    kept = values[np.isfinite(values)]
    if kept.size < _FEWEST:
        return False
    steps = np.diff(kept)
    usual = float(np.median(steps))
    if np.all(steps > 0) and np.mean(np.abs(steps - usual) <= _EVEN * usual / 2) > _MOST:
        return True
    levels, at = np.unique(kept, return_inverse=True)
    if np.any(steps < 0) or levels.size <= _LEVELS:  # few levels may be those of an input
        return False
    gaps = np.diff(levels)
    digit = np.maximum(np.append(gaps, gaps[-1]), np.append(gaps[0], gaps))[at]  # of three, it grows with the time
    row = np.arange(kept.size)
    line = np.polynomial.Polynomial.fit(row, kept, 1, w=1 / digit)
    return bool(np.all(np.abs(kept - line(row)) <= digit))


def _runs_on(kept: Array) -> bool:
    """Tell a clock that ticks unevenly, from zero on: as many rows take as long later as at first."""
    first, middle, last = kept[0], kept[kept.size // 2], kept[-1]
    goes = bool(np.all(np.diff(kept) > 0)) and abs(first) <= _ZERO * (last - first)
    return bool(goes and abs(middle - 0.5 * (first + last)) <= _HALVES * (last - first))
