"""The table of a text: encoding, delimiter, decimal mark, header and preamble, found from its lines."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stepid.core.base import Array
from stepid.core.takes import described
from stepid.errors import InputError
from stepid.io.guess.rows import broken_row, cells, find_marks, longest_rows, numbers
from stepid.io.guess.titles import find_titles, labeled_units
from stepid.io.table_layout import Layout
from stepid.io.textfile import count_filled, is_comment, split_lines

_CLOCK = re.compile(r"(?:^|[ T])(\d{1,2}):(\d\d):(\d\d(?:[.,]\d+)?)$")


class NoTableError(InputError):
    """A file holds no table of numbers."""


@dataclass(frozen=True)
class Block:
    """The rows of numbers of one table, and what stands above them.

    `skiprows` is what the table's reader leaves out, `names` and `units` have one text a column, empty where there is
    none; `by_name` tells whether the reader can take columns by their names. `values`, shape (rows, columns), are NaN
    where a cell holds no number, `lines` the lines of the rows, counted from 1; `unread` is the number of lines below
    them, `clock` the time between two rows, s, by a column of clock times (12:03:04.512) that no reader takes,
    `unmatched` the names of a header that are more or fewer than there are columns.
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
    lines: tuple[int, ...]
    unread: int
    clock: float | None
    unmatched: tuple[str, ...] = ()


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
        If there are fewer than 8 rows of numbers, or readings stand beyond a line that is none of them.
    """
    body = [(i, line) for i, line in enumerate(lines) if line.strip() and not is_comment(line)]
    marks = find_marks([line for _, line in body], workbook=workbook)
    if marks is None:
        raise NoTableError(
            f"{where}: holds no table of numbers that stepid finds", "Save it as CSV, a header above the rows."
        )
    separator, decimal = marks
    rows = [cells(line, separator) for _, line in body]
    filled = count_filled(rows)
    body, rows = body[:filled], rows[:filled]
    found = longest_rows(rows, decimal)
    if (broken := broken_row(rows, found, decimal)) is not None:
        number, text = body[broken][0] + 1, body[broken][1].strip()
        raise InputError(
            f"{where}, line {number}: is no row like the others ({described(text)}), and the table breaks off there",
            "Restore the line, or remove it if it holds no readings; keep one table a file, # before other numbers.",
        )
    first, last, width = found.first, found.last, found.width
    top = body[first][0]
    titles = find_titles(lines[:top], separator, width, max(found.columns, default=-1) + 1)
    header = titles.header(lines, separator)
    above = tuple(line for i, line in enumerate(lines[:top]) if i != titles.place)
    return Block(
        separator,
        decimal,
        _skipped(lines, top if header is None else header),
        titles.names,
        titles.units if any(titles.units) else labeled_units(above, separator, width),
        titles.groups,
        header is not None,
        above,
        numbers([row[:width] for row in rows[first:last]], decimal),
        lines=tuple(i + 1 for i, _ in body[first:last]),
        unread=len(body) - last,
        clock=_clock(rows[first:last]),
        unmatched=titles.unmatched,
    )


def _skipped(lines: Sequence[str], top: int) -> int:
    """Lines that the reader has to skip: comments and blank lines are left out anyway."""
    return 0 if all(not line.strip() or is_comment(line) for line in lines[:top]) else top


def needs_delimiter(block: Block, lines: Sequence[str]) -> bool:
    """Say whether the reader may split rows otherwise unless the delimiter is given."""
    layout = Layout(None, block.decimal, 0, ())
    body = [line.strip(" ") for line in lines if line.strip() and not is_comment(line)]
    return {layout.separator(body[-1]), layout.separator_of(body)} != {block.separator}


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
