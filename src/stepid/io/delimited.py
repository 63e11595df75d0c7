"""Delimited text: what separates its columns, their names, and the numbers below."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stepid.core.base import Array
from stepid.core.takes import described
from stepid.core.units import NO_COLUMN
from stepid.errors import InputError
from stepid.io.plain_table import Places, parse_plain
from stepid.io.record_end import own_rows
from stepid.io.table_layout import Layout, cells, is_header, named_columns
from stepid.io.textfile import (
    common_width,
    count_filled,
    decode,
    is_comment,
    is_number,
    parse_numbers,
    read_bytes,
    split_lines,
)
from stepid.io.workbook import is_workbook

_REPAIR = (
    "Restore the line, or remove it if it holds no readings: one line of names may come first, skiprows = … leaves out "
    "the lines above it; comments start with #."
)
_OTHER_MARK = {
    ".": 'Give decimal = "," if its numbers have decimal commas.',
    ",": 'Leave out decimal = "," if its numbers have decimal points.',
}
_HEAD = 64  # lines above which a file is large: from there on it may be read as plain numbers


@dataclass(frozen=True)
class Table:
    """Numbers in named or numbered columns, with the place of each row."""

    names: tuple[str, ...]  # empty without a header
    values: Array
    places: Places

    @property
    def listed(self) -> str:
        """The columns in words."""
        width = self.values.shape[1]
        return (
            ", ".join(name or "(no name)" for name in self.names)
            if self.names
            else f"no header; columns count from 0 to {width - 1}"
        )

    def column(self, which: object, role: str, where: str) -> Array:
        """Return a column by name or index; InputError lists those there are."""
        width = self.values.shape[1]
        if isinstance(which, str) and which and which in self.names:
            index = self.names.index(which)
        elif isinstance(which, int) and not isinstance(which, bool) and 0 <= which < width:
            index = which
        else:
            remedy = f"Correct {role}=…{', or give ' + NO_COLUMN if role == 'input' else ''}."
            raise InputError(f"{where}: has no column {described(which)} for {role} ({self.listed})", remedy)
        values: Array = self.values[:, index]
        return values


def parse_table(file: Path, layout: Layout) -> Table:
    """Parse a file.

    Raises
    ------
    stepid.errors.InputError
        Naming file, line and column.
    """
    where = str(file)
    raw = read_bytes(file)
    plain = _plain(raw, layout, where)
    return _parse(layout.lines(raw, where), layout, where) if plain is None else plain


def _plain(raw: bytes, layout: Layout, where: str) -> Table | None:
    """Parse a file of which all but the first lines are rows of plain numbers, fast; None where it is another."""
    end = 0
    if layout.encoding is not None or layout.sheet is not None or layout.stop is not None or is_workbook(raw):
        return None
    for _ in range(layout.skiprows + _HEAD):
        end = raw.find(b"\n", end) + 1
        if end == 0:
            return None
    try:
        lines = split_lines(decode(raw[:end], where))
        head = _parse(lines, layout, where)
    except InputError:  # of the whole file it says more
        return None
    first = layout.skiprows + _HEAD + 1
    body = _body(lines, layout)
    if len(lines) != first or head.places[-1] != f"{where}, line {body[-1][0]}":
        return None
    last = len(raw)
    while raw[last - 1] in b" \r\n":
        last -= 1
    width = head.values.shape[1]
    separator = layout.separator_of([text for _, text in body])
    values = parse_plain(memoryview(raw)[end:last], width=width, separator=separator, decimal=layout.decimal)
    if values is None:
        return None
    rest = Places([(where, range(first, first + len(values)))])
    return Table(head.names, np.concatenate([head.values, values]), Places([*head.places.pieces, *rest.pieces]))


def _body(lines: Sequence[str], layout: Layout) -> list[tuple[int, str]]:
    """Lines that are neither blank nor comments, each with its number."""
    kept = list(enumerate(lines, 1))[layout.skiprows :]
    texts = [(i, text) for i, line in kept if (text := line.strip(" ")) and text.strip()]
    return [(i, text) for i, text in texts if not is_comment(text)]


def _parse(lines: Sequence[str], layout: Layout, where: str) -> Table:
    body = _body(lines, layout)
    if not body:
        below = f" below line {layout.skiprows}" if layout.skiprows else ""
        raise InputError(f"{where}: holds no rows of numbers{below}", "Export the record again.")
    separator = layout.separator_of([text for _, text in body])
    rows, numbers = [cells(text, separator) for _, text in body], [i for i, _ in body]
    _check_above(rows, numbers, layout, where)
    names: tuple[str, ...] = ()
    top = numbers[0]
    if is_header(*rows[:2]):
        names, rows, numbers = named_columns(rows), rows[1:], numbers[1:]
    if not rows:
        raise InputError(f"{where}: holds a header and no rows", "Export the record again.")
    rows = rows[: _last_row(rows, layout)]
    _check_names(names, lines[: numbers[0] - 1], layout, separator, where)
    mistaken = separator == "," and layout.delimiter is None
    labels = _labels(names, rows, f"{where}, line {numbers[0]}", top=top, decimal_commas=mistaken)
    clock, own = _indices(layout.used[:1], labels), _indices(layout.used[1:], labels)
    rows = rows[: own_rows(rows, labels, own=own, clock=clock, lines=numbers, where=where, stop=layout.stop)]
    numbers = numbers[: len(rows)]
    values = parse_numbers(
        _zeros_beside(rows, {*clock, *own}, layout.decimal),
        lines=numbers,
        columns=labels,
        where=where,
        remedy=_REPAIR,
        decimal=layout.decimal,
        other_mark=_OTHER_MARK[layout.decimal],
    )
    return Table(names, values, Places([(where, numbers)]))


def _labels(
    names: tuple[str, ...], rows: Sequence[Sequence[str]], where: str, *, top: int, decimal_commas: bool
) -> tuple[str, ...]:
    """What messages call the columns: their names, or numbers where there are none.

    Where delimiters may be decimal commas, rows of twice as many values as names say that they are.
    """
    if names and any(len(row) == len(names) for row in rows):
        return tuple(name or str(i) for i, name in enumerate(names))
    width = common_width(rows)
    if not names:
        return tuple(str(i) for i in range(width))
    cause = f"{where}: rows hold {width} values under a header of {len(names)} names"
    if decimal_commas and width == 2 * len(names):
        raise InputError(cause, _OTHER_MARK["."])
    raise InputError(
        f"{cause} ({', '.join(names)}): which is whose is not clear",
        f"Correct the header, or leave it out with skiprows = {top} and give the columns by index from 0. {_REPAIR}",
    )


def header(file: Path, layout: Layout) -> tuple[str, ...]:
    """Names of a file's columns, () where it has no header; InputError where it has no line."""
    lines = [line for line in layout.lines(read_bytes(file), str(file))[layout.skiprows :] if line.strip()]
    body = [line.strip(" ") for line in lines if not is_comment(line)]
    if not body:
        raise InputError(f"{file}: holds no rows of numbers", "Export the record again.")
    separator = layout.separator_of(body)
    rows = [cells(line, separator) for line in (*body[:2], *body[-1:])]
    return named_columns(rows) if is_header(*rows[:2]) else ()


def join_tables(tables: Sequence[Table]) -> Table:
    """Join tables of one layout; InputError where they differ."""
    first = tables[0]
    for table in tables[1:]:
        if table.names != first.names or table.values.shape[1] != first.values.shape[1]:
            raise InputError(
                f"{table.places[0]}: has other columns than {first.places[0]}", "Join files of one layout only."
            )
    if len(tables) == 1:
        return first
    places = Places([piece for table in tables for piece in table.places.pieces])
    return Table(first.names, np.concatenate([t.values for t in tables]), places)


def _indices(columns: Sequence[object], labels: Sequence[str]) -> list[int]:
    """Indices of columns that are given by name or index."""
    told = [column for column in columns if isinstance(column, str | int)]
    return [i for i, label in enumerate(labels) if i in told or label in told]


def _zeros_beside(rows: Sequence[Sequence[str]], used: Collection[int], decimal: str) -> list[list[str]]:
    """Put zeros for what is no reading in columns that are not used: there may be anything, and nothing."""
    return [[cell if i in used or _is_reading(cell, decimal) else "0" for i, cell in enumerate(row)] for row in rows]


def _last_row(rows: Sequence[Sequence[str]], layout: Layout) -> int:
    """Rows up to the first below `stop` that is none of the table, such as a mean; empty last ones are none."""
    last = count_filled(rows) or len(rows)
    if layout.stop is None or layout.stop <= 0:
        return last
    width = common_width(rows)
    below = range(layout.stop, last)
    return next((i for i in below if len(rows[i]) != width or not _is_reading(rows[i][0], layout.decimal)), last)


def _is_reading(cell: str, decimal: str) -> bool:
    return is_number(cell, decimal=decimal) and math.isfinite(float(cell.replace(decimal, ".")))


def _check_above(rows: Sequence[Sequence[str]], lines: Sequence[int], layout: Layout, where: str) -> None:
    """Refuse lines above the header, which is told by the names of the columns that are read."""
    names = {name for name in layout.used if isinstance(name, str)}
    found = next((line for row, line in zip(rows, lines, strict=True) if names.issubset(row)), lines[0])
    if names and found != lines[0]:
        raise InputError(
            f"{where}, line {lines[0]}: is not the header, which comes in line {found}",
            f"Give skiprows = {found - 1} to leave out the lines above it.",
        )


def _check_names(
    names: tuple[str, ...], above: Sequence[str], layout: Layout, separator: str | None, where: str
) -> None:
    """Refuse a header that names a column twice, and names of columns that stand in a comment."""
    filled = [name for name in names if name]
    if len(set(filled)) < len(filled):
        raise InputError(f"{where}: its header names a column twice ({', '.join(names)})", "Rename one of them.")
    lost = {name for name in layout.used if isinstance(name, str)}.difference(names)
    for number, line in enumerate(above, 1):
        if lost and is_comment(line) and (there := lost.intersection(cells(line.lstrip(" #%"), separator))):
            name = next(name for name in layout.used if name in there)
            raise InputError(
                f"{where}, line {number}: names the column {name!r} in a comment, so that it is no header",
                "Remove the mark of the comment, or give the columns by index from 0.",
            )
