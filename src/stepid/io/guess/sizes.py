"""Units by size: what readings can be, seen from how a teaching plant moves."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.io.guess.draft import TURNS, Draft

_FASTEST, _SLOWEST = 1e-4, 0.1  # s between samples
_SHORTEST, _LONGEST = 0.3, 300.0  # s of a record
_SLACK = 10.0  # by which records in a unit that is told may be slower and longer; 1 s already is a count of ms
_LARGEST_IN_METERS = 0.05  # of readings in cm, it would be half a millimeter
_VOLTS = 15.0  # more than such an amplifier gives
_FAR, _NEAR = 1.0, 2e-5  # m; a teaching plant travels less, and more
_COUNTS = 50.0  # fewer whole readings may be millimeters


def time_unit(time: Array) -> str | None:
    """Return the unit of times, shape (n,), None where two are possible."""
    possible = [unit for unit, scale in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)) if _may_be_seconds(time * scale)]
    return possible[0] if len(possible) == 1 else None


def _may_be_seconds(time: Array, *, slack: float = 1.0) -> bool:
    """Say whether times are those of a record in seconds by their step and span."""
    step, span = float(np.median(np.diff(time))), float(time[-1] - time[0])
    slow = step <= _SLOWEST or step < _SLOWEST * slack * (1 - 1e-9)
    return step >= _FASTEST and slow and _SHORTEST <= span <= _LONGEST * slack


def position_unit(position: Array) -> str | None:
    """Return the unit of readings, shape (n,): "counts" where all are whole, "m" where small; else None."""
    span = float(np.ptp(position))
    if span > _COUNTS and np.all(position == np.rint(position)):
        return "counts"
    return "m" if 0 < span <= _LARGEST_IN_METERS else None


def input_unit(values: Array) -> str | None:
    """Return "V" for what an amplifier can give; None for what may be counts or millivolts."""
    largest = float(np.abs(values).max())
    return "V" if 0 < largest <= _VOLTS else None


def odd_units(draft: Draft) -> tuple[str, ...]:
    """Say where a unit that a file tells does not fit the size of its readings."""
    out = []
    time, unit = draft.si("time"), draft.units.get("time")
    if time is not None and unit is not None and time.size > 1:
        by_size = time_unit(draft.readings["time"])
        if by_size not in (None, unit.value) and not _may_be_seconds(time, slack=_SLACK):
            out.append(f"the time is in {unit.value} by {unit.why}, by its size in {by_size}; check it")
    meters, unit = draft.si("position"), draft.units.get("position")
    if meters is not None and meters.size and unit is not None and unit.value not in TURNS:
        travel = float(np.ptp(meters))
        if travel > _FAR or 0 < travel < _NEAR:
            out.append(f"the position spans {travel:.3g} m in {unit.value} by {unit.why}; check its unit")
    return tuple(out)
