"""Time stamps of a table's rows: taken as they are, or checked against a sample time that is given."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.errors import InputError
from stepid.io.one_below import rows_of_files
from stepid.io.plain_table import Places

COARSE = 0.05
"""Of the time stamps: where more repeat they are printed too coarsely; fewer are single wrong ones."""


def stamped(time: Array, places: Places) -> Array:
    """Return time stamps that increase.

    Parameters
    ----------
    time : array, shape (n,)
        s.
    places : Places
        Where each row stands, for errors.

    Raises
    ------
    stepid.errors.InputError
        If they do not.
    """
    with np.errstate(all="ignore"):
        increasing = np.diff(time) > 0
        if np.all(increasing):
            return time
        row, mean = int(np.argmax(~increasing)) + 1, _mean_step(time)
        digit = _resolution(time)
        cause = f"{places[row]}: {time[row]:.10g} s after {time[row - 1]:.10g} s: time does not increase"
        if _is_coarse(time, digit):
            raise InputError(
                f"{cause}, as it is printed to {digit:.3g} s only, and rows are about {mean:.6g} s apart",
                "Give sample_time=… (s). Times that are printed rounded may stay: they are checked against it.",
            )
    own = " if each file starts a clock of its own" * (len(rows_of_files(places)) > 1)
    remedy = f"Correct it, or give sample_time=… (s) and leave time out{own}."
    if digit:
        remedy += " Times that are printed rounded may stay: they are checked against it."
    raise InputError(cause, remedy)


def clocked(time: Array, sample_time: float, places: Places, where: str) -> Array:
    """Return the times of an even clock that time stamps are within half a sample of, or rounded from.

    Parameters
    ----------
    time : array, shape (n,)
        s.
    sample_time : float
        s, as it is given.
    places : Places
        Where each row stands, for errors.
    where : str
        The record, for errors.

    Raises
    ------
    stepid.errors.InputError
        If they are neither.
    """
    index = np.arange(time.size, dtype=np.float64)
    with np.errstate(all="ignore"):
        mean, digit = _mean_step(time), _resolution(time)
        rounded = digit > 0 and float(np.ptp(time - index * sample_time)) <= digit + 0.5 * sample_time
        if rounded or (mean > 0 and _follows(time, sample_time, 0.5)):
            even: Array = time[0] + index * sample_time
            return even
        if _follows(time, mean, 0.01):
            raise InputError(
                f"{where}: sample_time is given as {sample_time:g} s, but rows are {mean:.8g} s apart",
                "Leave sample_time out, or correct it.",
            )
        raise _uneven(time, sample_time, places)


def _uneven(time: Array, sample_time: float, places: Places) -> InputError:
    """Name the row that is farthest from an even clock, or the first after a step of another length."""
    mean, digit = _mean_step(time), _resolution(time)
    if _is_coarse(time, digit):
        off = time - np.arange(time.size) * sample_time
        row = int(np.argmax(np.abs(off - np.median(off))))
        return InputError(
            f"{places[row]}: {time[row]:.10g} s, printed to {digit:.3g} s only, is more than half a sample off "
            f"{sample_time:g} s, where rows are about {mean:.6g} s apart",
            "Correct sample_time, or leave time out if samples were dropped or each file starts a clock of its own.",
        )
    steps = np.diff(time)
    usual = float(np.median(steps)) or mean  # where most printed times repeat
    row = int(np.argmax(np.abs(steps - usual) > 0.02 * abs(usual))) + 1
    return InputError(
        f"{places[row]}: {time[row]:.10g} s after {time[row - 1]:.10g} s, where rows are about {usual:.6g} s "
        f"apart: more than half a sample off {sample_time:g} s",
        "Leave sample_time out if the samples are uneven; leave time out if each file starts a clock of its own.",
    )


def _mean_step(time: Array) -> float:
    return float((time[-1] - time[0]) / (time.size - 1))


def _is_coarse(time: Array, digit: float) -> bool:
    """Tell whether stamps are printed too coarsely to tell rows apart."""
    return 0 < digit < np.inf and float(np.mean(np.diff(time) == 0)) > COARSE


def _resolution(time: Array) -> float:
    """Resolution of rounded time stamps, shape (n,), by the steps beside those that repeat; 0 if none does.

    It is 0 where a stamp falls, too, and infinite where all are one.
    """
    steps = np.diff(time)
    same = steps == 0
    if not same.any() or np.any(steps < 0):
        return 0.0
    beside = np.concatenate([steps[1:][same[:-1]], steps[:-1][same[1:]]])
    return float(np.median(beside[beside > 0])) if np.any(beside > 0) else np.inf


def _follows(time: Array, step: float, tolerance: float) -> bool:
    """Tell whether stamps are as near to an even clock, in steps."""
    return bool(np.all(np.abs(time - time[0] - step * np.arange(time.size)) / step <= tolerance))
