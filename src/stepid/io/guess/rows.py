"""Rows of numbers among lines: the delimiter and decimal mark that make most of them, and where they begin and end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.io.ecp import FEWEST
from stepid.io.textfile import is_number

_CANDIDATES = (("\t", "."), (";", "."), (",", "."), (None, "."), ("\t", ","), (";", ","), (None, ","))
_MOST = 0.9  # of a column's cells are numbers where it holds readings
_PROBED = 600  # lines from which delimiter and decimal mark are told
_SOME = 0.05  # of a column's cells; beside longer records the rest is empty


class Rows(NamedTuple):
    """Rows of numbers: the first and the one after the last, how wide they are, and how many readings they hold."""

    first: int
    last: int
    width: int
    readings: int


def find_marks(lines: Sequence[str], *, workbook: bool = False) -> tuple[str | None, str] | None:
    """Delimiter, None for blanks, and decimal mark by which lines hold most readings; None where they hold no table.

    Parameters
    ----------
    lines : sequence of str
        Without comments and empty ones.
    workbook : bool
        Whether the lines come from a workbook: tabs and points then, whatever its texts look like.
    """
    best: tuple[tuple[int, int, int], str | None, str] | None = None
    for rank, (separator, decimal) in enumerate(_CANDIDATES[:1] if workbook else _CANDIDATES):
        found = longest_rows([cells(line, separator) for line in lines[:_PROBED]], decimal)
        if found.last - found.first < FEWEST:
            continue
        score = (found.readings, min(found.width, 2), -rank)
        if best is None or score > best[0]:
            best = (score, separator, decimal)
    return None if best is None else best[1:]


def cells(line: str, separator: str | None) -> list[str]:
    """Split a line as the table's reader does."""
    return [cell.strip().strip("\"'") for cell in line.strip(" ").split(separator)]


def numbers(rows: Sequence[Sequence[str]], decimal: str) -> Array:
    """Values of rows of cells, NaN where a cell holds no number."""
    return np.array([[_number(cell, decimal) for cell in row] for row in rows], dtype=np.float64)


def _number(cell: str, decimal: str) -> float:
    return float(cell.replace(decimal, ".")) if is_number(cell, decimal=decimal) else np.nan


def longest_rows(rows: Sequence[Sequence[str]], decimal: str) -> Rows:
    """Find the longest stretch of rows of numbers among rows of cells."""
    width = Counter(map(len, rows)).most_common(1)[0][0] if rows else 0
    columns = _columns_of_numbers([row for row in rows if len(row) == width], width, decimal)
    runs: list[tuple[int, int]] = []
    start = None
    for i, row in enumerate([*rows, []]):
        if len(row) == width and _is_row([row[j] for j in columns], decimal):
            start = i if start is None else start
        elif start is not None:
            runs.append((start, i))
            start = None
    if not runs:
        return Rows(0, 0, width, 0)
    first, last = max(runs, key=lambda run: run[1] - run[0])
    readings = sum(is_number(row[j], decimal=decimal) for row in rows[first:last] for j in columns)
    # a column of texts may be what a wrong decimal mark makes of numbers: rather all columns of numbers
    return Rows(first, last, width, readings)


def _columns_of_numbers(rows: Sequence[Sequence[str]], width: int, decimal: str) -> list[int]:
    """Columns whose cells are numbers, but for few or empty ones."""
    filled = [sum(bool(row[j]) for row in rows) for j in range(width)]
    numeric = [sum(is_number(row[j], decimal=decimal) for row in rows) for j in range(width)]
    return [j for j in range(width) if numeric[j] >= max(_MOST * filled[j] - 4, _SOME * len(rows), 1)]


def _is_row(row: Sequence[str], decimal: str) -> bool:
    """Tell whether a row's cells are numbers, or empty, and not all of them empty."""
    read = [is_number(cell, decimal=decimal) for cell in row]
    return any(read) and all(ok or cell in ("", "-") for ok, cell in zip(read, row, strict=True))
