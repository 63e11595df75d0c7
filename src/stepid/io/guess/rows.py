"""Rows of numbers among lines: the delimiter and decimal mark that make most of them, and where they begin and end."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.io.ecp import FEWEST
from stepid.io.guess.words import RUN_WORDS, read_title, role_of, tokens
from stepid.io.table_layout import cells as split_cells
from stepid.io.textfile import is_name, is_number

_CANDIDATES = (("\t", "."), (";", "."), (",", "."), (None, "."), ("\t", ","), (";", ","), (None, ","))
_QUOTED = (*_CANDIDATES, (",", ","))  # in quotation marks a comma may be both
_MOST = 0.9  # of a column's cells are numbers where it holds readings
_PROBED = 600  # lines from which delimiter and decimal mark are told
_SOME = 0.05  # of a column's cells; beside longer records the rest is empty
_PAIR = re.compile(r"([+-]?\d+),(\d+)")
_LOST = re.compile(r"|-+|[+-]?(nan|inf|infinity)|-?1\.#\w+|#.+|n/?a|null", re.IGNORECASE)  # in place of a reading


class Rows(NamedTuple):
    """Rows of numbers: the first and the one after the last, their width, readings, and which columns hold those."""

    first: int
    last: int
    width: int
    readings: int
    columns: tuple[int, ...] = ()


def find_marks(lines: Sequence[str], *, workbook: bool = False) -> tuple[str | None, str] | None:
    """Delimiter, None for blanks, and decimal mark by which lines hold most readings; None where they hold no table.

    Parameters
    ----------
    lines : sequence of str
        Without comments and empty ones.
    workbook : bool
        Whether the lines come from a workbook: tabs and points then, whatever its texts look like.
    """
    best: tuple[tuple[int, int, int, int], str | None, str] | None = None
    quoted = any('"' in line for line in lines[:_PROBED])
    alone = _is_one_column(lines[:_PROBED])
    for rank, (separator, decimal) in enumerate(_CANDIDATES[:1] if workbook else _QUOTED if quoted else _CANDIDATES):
        if alone and separator == ",":
            continue
        found = longest_rows([cells(line, separator) for line in lines[:_PROBED]], decimal)
        if found.last - found.first < FEWEST:
            continue
        texts = found.width - len(found.columns)  # 0,1;1,97 is no row of three
        score = (found.readings, min(found.width, 2), -texts, -rank)
        if best is None or score > best[0]:
            best = (score, separator, decimal)
    return None if best is None else best[1:]


def _is_one_column(lines: Sequence[str]) -> bool:
    """Say whether rows of two whole numbers about a comma are one column of decimals.

    They are where one name alone stands above them, or one of the two is none that is printed: -0, 05.
    """
    pairs = [found.groups() for line in lines if (found := _PAIR.fullmatch(line.strip()))]
    top = next((i for i, line in enumerate(lines) if _PAIR.fullmatch(line.strip())), 0)
    if len(pairs) < FEWEST or len(pairs) + top < len(lines):
        return False
    name = lines[top - 1] if top else ""
    if "," in name:
        return False
    return _is_one_name(name) or any(whole == "-0" or (part[0] == "0" and len(part) > 1) for whole, part in pairs)


def _is_one_name(line: str) -> bool:
    """Tell the name of one column from a title above several: "Position record 3", "time and position"."""
    words = tokens(line)
    title = RUN_WORDS.intersection(words) or re.search(r"\s\d", line) or len({*map(role_of, words)} - {None}) > 1
    return not title and read_title(line).role is not None


def cells(line: str, separator: str | None) -> list[str]:
    """Split a line as the table's reader does."""
    return split_cells(line.strip(" "), separator)


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
    return Rows(first, last, width, readings, tuple(columns))


def broken_row(rows: Sequence[Sequence[str]], found: Rows, decimal: str) -> int | None:
    """Find the row at which a table breaks off, though readings stand beyond it; None where all of them are `found`."""
    if found.first == found.last:
        return None
    labeled = _is_label(rows[found.first][0])
    outside = [i for i in (*range(found.first), *range(found.last, len(rows))) if labeled or not _is_label(rows[i][0])]
    beyond = [i for i in outside if _holds_readings(rows[i], found, decimal, short=i >= found.last)]
    if not beyond:
        return None
    at = found.first - 1 if beyond[0] < found.first else found.last
    return next((i for i in beyond if not _is_whole(rows[i], found, decimal)), at)


def _is_label(cell: str) -> bool:
    return is_name(cell) and _LOST.fullmatch(cell) is None


def _is_whole(row: Sequence[str], found: Rows, decimal: str) -> bool:
    return len(row) == found.width and _is_row([row[j] for j in found.columns], decimal)


def _holds_readings(row: Sequence[str], found: Rows, decimal: str, *, short: bool) -> bool:
    """Tell a row of readings, damaged or whole, from titles and remarks.

    A `short` one, of which nothing but readings is left, is one below the rows; above them it may be a count.
    """
    cut = [row[j] if j < len(row) else "" for j in found.columns]
    read = [is_number(cell, decimal=decimal) for cell in cut]
    if read[0] and 2 * sum(read) > len(read):
        return True
    no_words = all(ok or _LOST.fullmatch(cell) for ok, cell in zip(read, cut, strict=True))
    return any(read) and no_words and (short or len(row) == found.width)


def _columns_of_numbers(rows: Sequence[Sequence[str]], width: int, decimal: str) -> list[int]:
    """Columns whose cells are numbers, but for few or empty ones."""
    filled = [sum(bool(row[j]) for row in rows) for j in range(width)]
    numeric = [sum(is_number(row[j], decimal=decimal) for row in rows) for j in range(width)]
    return [j for j in range(width) if numeric[j] >= max(_MOST * filled[j] - 4, _SOME * len(rows), 1)]


def _is_row(row: Sequence[str], decimal: str) -> bool:
    """Tell whether a row's cells are numbers, or empty, and not all of them empty."""
    read = [is_number(cell, decimal=decimal) for cell in row]
    return any(read) and all(ok or cell in ("", "-") for ok, cell in zip(read, row, strict=True))
