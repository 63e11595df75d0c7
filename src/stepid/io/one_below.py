"""Tables that hold several runs one below the other: refused where time shows it."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.errors import InputError
from stepid.io.ecp import FEWEST
from stepid.io.plain_table import Places

_NEAR = 0.02  # of the first run's length, by which the clocks of runs may begin apart
_FAST = 10  # times the first run's sample time


def check_one_run(time: Array, places: Places, *, start: int = 0, unit: str = " s") -> None:
    """Refuse a file whose time starts anew below a row; files that are joined may each have a clock of their own.

    Parameters
    ----------
    time : array, shape (n,)
        Finite.
    places : Places
        Of the rows.
    start : int
        Rows left out above them.
    unit : str
        Of the time, with a blank before it, for the error.

    Raises
    ------
    stepid.errors.InputError
        Naming the line at which the second run begins, and the rows of both.
    """
    first = 0
    for size in rows_of_files(places):
        if rows := [first + row for row in _starts(time[first : first + size])]:
            second, third = rows[0], rows[1] if len(rows) > 1 else None
            count = "two" if third is None else str(len(rows) + 1)
            end = "" if third is None else f", stop = {start + third}"
            raise InputError(
                f"{places[second]}: time starts anew at {time[second]:.10g}{unit} after {time[second - 1]:.10g}{unit}, "
                f"so the table seems to hold {count} runs one below the other",
                "Save each run as a file of its own. In read_table and in a manifest "
                f"stop = {start + second} keeps the first run, start = {start + second}{end} the second.",
            )
        first += size


def rows_of_files(places: Places) -> list[int]:
    """How many rows each file has: of a large one the places come in two pieces."""
    sizes: list[int] = []
    before: tuple[str, int] | None = None
    for file, lines in places.pieces:
        if before is not None and before[0] == file and before[1] < lines[0]:
            sizes[-1] += len(lines)
        else:
            sizes.append(len(lines))
        before = file, lines[-1]
    return sizes


def _starts(time: Array) -> list[int]:
    """Rows at which time, shape (n,), falls back to near its first value; none where it falls in any other way."""
    with np.errstate(all="ignore"):
        rows = np.flatnonzero(np.diff(time) < 0) + 1
        if rows.size == 0 or np.diff([0, *rows, time.size]).min() < FEWEST:
            return []
        span = time[rows[0] - 1] - time[0]
        step = span / (rows[0] - 1)
        anew = np.abs(time[rows] - time[0]) <= max(_NEAR * span, 2 * step)
        rise = time[rows + FEWEST - 1] - time[rows]  # after a single wrong stamp time jumps back to where it was
        return rows.tolist() if np.all(anew & (rise > 0) & (rise < _FAST * FEWEST * step)) else []
