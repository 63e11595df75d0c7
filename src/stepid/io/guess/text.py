"""Encoding, delimiter, decimal mark, header and preamble of a text of numbers, found from its lines."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stepid.core.base import Array
from stepid.errors import InputError
from stepid.io.delimited import Layout
from stepid.io.ecp import FEWEST
from stepid.io.guess.words import is_unit
from stepid.io.textfile import is_name, is_number, split_lines

_CANDIDATES = (("\t", "."), (";", "."), (",", "."), (None, "."), ("\t", ","), (";", ","), (None, ","))
_MOST = 0.9  # of a column's cells are numbers where it holds readings
_CLOCK = re.compile(r"(?:^|[ T])(\d{1,2}):(\d\d):(\d\d(?:[.,]\d+)?)$")
_PROBED = 600  # lines from which delimiter and decimal mark are told
_SOME = 0.05  # of a column's cells; beside longer records the rest is empty


class NoTableError(InputError):
    """A file holds no table of numbers."""


@dataclass(frozen=True)
class Block:
    """The rows of numbers of one table, and what stands above them.

    `skiprows` is what the table's reader leaves out, `names` and `units` have one text a column, empty where there is
    none; `by_name` tells whether the reader can take columns by their names. `values`, shape (rows, columns), are NaN
    where a cell holds no number; `unread` is the number of lines below the rows, `clock`
    the time between two rows, s, by a column of clock times (12:03:04.512) that no reader takes.
    """

    separator: str | None
    decimal: str
    skiprows: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    groups: tuple[str, ...]
    by_name: bool
    above: tuple[str, ...]
    values: Array
    unread: int
    clock: float | None


def find_encoding(raw: bytes, file: Path) -> tuple[str, str | None]:
    """Return a file's text, and the encoding to name to its reader, None for UTF-8; NoTableError where it is binary."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        candidates = ["utf-16"]
    elif b"\0" in raw[:4000]:
        even, odd = raw[:4000:2].count(0), raw[1:4000:2].count(0)
        candidates = ["utf-16-le" if odd > even else "utf-16-be"]
    else:
        candidates = ["utf-8-sig", "cp1252", "latin-1"]
    for encoding in candidates:
        try:
            text = raw.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text, None if encoding == "utf-8-sig" else encoding
    raise NoTableError(
        f"{file}: is not text but binary, as pictures and programs are", "Export the record as text, CSV or .xlsx."
    )


def find_block(lines: Sequence[str], where: str, *, workbook: bool = False) -> Block:
    """Find the rows of numbers among lines.

    Parameters
    ----------
    lines : sequence of str
    where : str
        The file, for messages.
    workbook : bool
        Whether the lines come from a workbook: tabs and points then, whatever its texts look like.

    Returns
    -------
    Block

    Raises
    ------
    stepid.errors.InputError
        If there are fewer than 8 rows of numbers.
    """
    body = [(i, line) for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith(("#", "%"))]
    best: tuple[tuple[int, int, int], str | None, str] | None = None
    for rank, (separator, decimal) in enumerate(_CANDIDATES[:1] if workbook else _CANDIDATES):
        rows = [cells(line, separator) for _, line in body[:_PROBED]]
        first, last, width, readings = _longest(rows, decimal)
        if last - first < FEWEST:
            continue
        score = (readings, min(width, 2), -rank)
        if best is None or score > best[0]:
            best = (score, separator, decimal)
    if best is None:
        raise NoTableError(
            f"{where}: holds no table of numbers that stepid finds", "Save it as CSV, a header above the rows."
        )
    _, separator, decimal = best
    rows = [cells(line, separator) for _, line in body]
    first, last, width, _ = _longest(rows, decimal)
    values = np.array([[_number(c, decimal) for c in row[:width]] for row in rows[first:last]], dtype=np.float64)
    top = body[first][0]
    names, units, groups, place = _titles(lines[:top], separator, width)
    # the reader takes a header right above the rows, one name a column
    plain = (
        place is not None
        and (not any(units) or units == names)
        and not any(groups)
        and not lines[place].lstrip().startswith(("#", "%"))
    )
    by_name = plain and _usable(cells(lines[place or 0], separator))
    skip = place if by_name and place is not None else top
    if all(not line.strip() or line.lstrip().startswith(("#", "%")) for line in lines[:skip]):
        skip = 0  # comments and blank lines are left out anyway
    above = tuple(line for i, line in enumerate(lines[:top]) if i != place)
    units = units if any(units) else _labeled_units(above, separator, width)
    return Block(
        separator,
        decimal,
        skip,
        names,
        units,
        groups,
        by_name,
        above,
        values,
        unread=len(body) - last,
        clock=_clock(rows[first:last]),
    )


def cells(line: str, separator: str | None) -> list[str]:
    """Split a line as the table's reader does."""
    return [cell.strip().strip("\"'") for cell in line.strip(" ").split(separator)]


def needs_delimiter(block: Block, line: str) -> bool:
    """Say whether the reader would split a row otherwise unless the delimiter is given."""
    return Layout(None, block.decimal, 0, ()).separator(line) != block.separator


def text_lines(raw: bytes, file: Path) -> tuple[list[str], str | None]:
    """Lines and encoding of a text file."""
    text, encoding = find_encoding(raw, file)
    return split_lines(text), encoding


def _clock(rows: Sequence[Sequence[str]]) -> float | None:
    """Sample time by a column of clock times, where they are even and fine enough to tell it to a thousandth."""
    for j in range(len(rows[0])):
        stamps = [m for row in rows if (m := _CLOCK.search(row[j]))]
        if len(stamps) < len(rows):
            continue
        times = np.array([3600 * int(m[1]) + 60 * int(m[2]) + float(m[3].replace(",", ".")) for m in stamps])
        span = float(times[-1] - times[0])
        step = span / (times.size - 1)
        digit = 10.0 ** -max(len(re.split("[.,]", f"{m[3]}.")[1]) for m in stamps)
        if step > 0 and np.all(np.abs(np.diff(times) - step) < 0.5 * step) and digit < 1e-3 * span:
            return step
    return None


def _number(cell: str, decimal: str) -> float:
    return float(cell.replace(decimal, ".")) if is_number(cell, decimal=decimal) else np.nan


def _longest(rows: Sequence[Sequence[str]], decimal: str) -> tuple[int, int, int, int]:
    """First and last row (not included) of the table, its width, and how many readings it has."""
    if not rows:
        return 0, 0, 0, 0
    width = Counter(map(len, rows)).most_common(1)[0][0]
    wide = [row for row in rows if len(row) == width]
    good = [[is_number(cell, decimal=decimal) for cell in row] for row in wide]
    filled = [sum(bool(row[j]) for row in wide) for j in range(width)]
    numeric = [sum(g[j] for g in good) for j in range(width)]
    columns = [j for j in range(width) if numeric[j] >= max(_MOST * filled[j] - 4, _SOME * len(wide), 1)]
    if not columns:
        return 0, 0, width, 0

    def is_row(row: Sequence[str]) -> bool:
        read = [is_number(row[j], decimal=decimal) for j in columns] if len(row) == width else []
        return any(read) and all(ok or row[j] in ("", "-") for ok, j in zip(read, columns, strict=True))

    runs, start = [], None
    for i, row in enumerate([*rows, []]):
        if is_row(row):
            start = i if start is None else start
        elif start is not None:
            runs.append((start, i))
            start = None
    if not runs:
        return 0, 0, width, 0
    first, last = max(runs, key=lambda run: run[1] - run[0])
    inside = rows[first:last]
    readings = sum(is_number(row[j], decimal=decimal) for row in inside for j in columns)
    # a column of texts may be what a wrong decimal mark makes of numbers: rather all columns of numbers
    return first, last, width, readings


def _titles(
    above: Sequence[str], separator: str | None, width: int
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...], int | None]:
    """Names, units and groups of columns from the lines above them, and the line of the names."""
    none = ("",) * width
    filled = [i for i, line in enumerate(above) if line.strip(" \t;,")]
    found = [(i, row) for i in filled[-3:] if (row := _row(above[i], separator, width)) is not None]
    found = found[::-1]
    units: tuple[str, ...] = none
    if found and _are_units(found[0][1]):
        if len(found) == 1 or not _is_header(found[1][1]):  # columns that are called by their units
            return found[0][1], found[0][1], none, found[0][0]
        units, found = found[0][1], found[1:]
    if not found or not _is_header(found[0][1]) or found[0][0] != filled[-1 - any(units)]:
        return none, units, none, None
    place, names = found[0]
    groups = none
    if len(set(filter(None, names))) < len([n for n in names if n]) and len(found) > 1:
        groups = _spread(found[1][1])
    return names, units, groups, place


def _labeled_units(above: Sequence[str], separator: str | None, width: int) -> tuple[str, ...]:
    """Units of columns from a line that begins with the word, wherever it stands above the rows."""
    for line in above:
        label, *units = _row(line, separator, width) or ("",)
        if re.search(r"(?i)unit(?!ed)|einheit", label) and _are_units(units):
            return ("", *units)
    return ("",) * width


def _row(line: str, separator: str | None, width: int) -> tuple[str, ...] | None:
    bare = line.strip(" ").lstrip("#%").strip(" ") if line.lstrip().startswith(("#", "%")) else line
    split = cells(bare, separator)
    if len(split) != width:
        wide = [cell for cell in bare.replace("\t", "  ").split("  ") if cell.strip()]
        split = [cell.strip() for cell in wide] if len(wide) == width else split
    if len(split) < width and separator is not None:  # titles of groups may end early
        split += [""] * (width - len(split))
    return tuple(split) if len(split) == width else None


def _are_units(row: Sequence[str]) -> bool:
    filled = [cell for cell in row if cell and cell != "-"]
    return bool(filled) and all(is_unit(cell) for cell in filled)


def _is_header(row: Sequence[str]) -> bool:
    filled = [cell for cell in row if cell]
    return bool(filled) and not any(is_number(cell) or is_number(cell, decimal=",") for cell in filled)


def _usable(row: Sequence[str]) -> bool:
    named = [cell for cell in row if cell]
    return all(map(is_name, named)) and len(named) == len(set(named)) and all(row[:-1]) and bool(named)


def _spread(row: Sequence[str]) -> tuple[str, ...]:
    """Titles of groups, each up to the next one."""
    out, last = [], ""
    for cell in row:
        last = cell or last
        out.append(last)
    return tuple(out)
