"""How delimited text is laid out: its encoding and sheet, what separates its columns, and which row names them."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from stepid.core.takes import described
from stepid.errors import InputError
from stepid.io.textfile import common_width, decode_as, is_name, is_number, split_lines
from stepid.io.workbook import is_workbook, workbook_lines

_WITH_COMMA = re.compile(r"[+-]?\d+(,\d+)?(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)
_QUOTED = re.compile(r'"[^"]*"')
_BETWEEN_QUOTES = re.compile(r'"",|,""')
_TAIL = 9  # last lines, most of which tell the separator: one of them may be a remark


@dataclass(frozen=True)
class Layout:
    """How delimited text is laid out.

    `delimiter` None is the first found of tab, semicolon, comma and blanks; `decimal` is the decimal mark, `skiprows`
    the number of lines to leave out above the header, `used` the columns that are read, by name or index; `encoding`
    None is UTF-8, `sheet` None the first of a workbook; what stands below row `stop` is not looked at.
    """

    delimiter: str | None
    decimal: str
    skiprows: int
    used: Sequence[object]
    encoding: str | None = None
    sheet: str | None = None
    stop: int | None = None

    def lines(self, raw: bytes, where: str) -> list[str]:
        """Lines of a file's bytes; the rows of a workbook come with tabs between their cells."""
        if is_workbook(raw):
            return workbook_lines(raw, where, self.sheet)
        if self.sheet is not None:
            raise InputError(f"{where}: is no workbook, so it has no sheet {self.sheet!r}", "Leave sheet out.")
        text = decode_as(raw, where, self.encoding)
        if self.decimal == self.delimiter and '"' not in text:  # in quotes a comma may be both
            raise InputError(f"{where}: delimiter and decimal are both {self.decimal!r}", "Correct one of them.")
        return split_lines(text)

    def check(self, where: str) -> None:
        """Refuse a layout that cannot be; InputError names the argument."""
        if self.delimiter is not None and (not isinstance(self.delimiter, str) or not self.delimiter):
            raise InputError(
                f"{where}: delimiter is {described(self.delimiter)}", "Give the text that separates columns."
            )
        if not isinstance(self.decimal, str) or self.decimal not in (".", ","):
            raise InputError(f"{where}: decimal is {described(self.decimal)}", 'Give "." or ",".')
        for label, text in (("encoding", self.encoding), ("sheet", self.sheet)):
            if text is not None and (not isinstance(text, str) or not text or "\0" in text):
                raise InputError(f"{where}: {label} is {described(text)}", "Give its name as text.")
        if type(self.skiprows) is not int or not 0 <= self.skiprows < 10**9:
            raise InputError(
                f"{where}: skiprows is {described(self.skiprows)}", "Give the number of lines above the header."
            )

    def separator(self, text: str) -> str | None:
        """Return what separates the columns of a line, None for blanks."""
        if self.delimiter is not None:
            return self.delimiter
        if quoted := text.count('"') > 0:
            text = _QUOTED.sub('""', text)
        between = quoted and _BETWEEN_QUOTES.search(text)  # then a comma is no decimal one
        mark = next((mark for mark in "\t;," if mark in text and (mark != self.decimal or between)), None)
        words = text.split()
        by_blanks = mark == "," and len(words) > 1 and all(map(_WITH_COMMA.fullmatch, words))
        return None if by_blanks else mark

    def separator_of(self, lines: Sequence[str]) -> str | None:
        """Return what separates the columns of most of the last lines, None for blanks."""
        return Counter(map(self.separator, reversed(lines[-_TAIL:]))).most_common(1)[0][0]


def cells(text: str, separator: str | None) -> list[str]:
    """Split a line into cells, without quotation marks; what separates them may stand between two of these."""
    split = text.split(None if separator in (None, " ") else separator)
    if separator in ("\t", ";", ",") and text.count('"') and text.count('"') % 2 == 0:
        with suppress(csv.Error):  # a cell that is too long: it is refused as it stands
            split = next(csv.reader([text], delimiter=separator, skipinitialspace=True))
    return [_bare(cell) for cell in split]


def _bare(cell: str) -> str:
    """A cell without quotation marks; behind a name an apostrophe that none opens is a prime: X and X' are two."""
    bare = cell.strip().strip('"')
    return bare if bare[:1].isalpha() else bare.strip("\"'")


def is_header(row: Sequence[str], below: Sequence[str] = ()) -> bool:
    """Tell whether a row names columns; some may have none, as of pandas' index, where numbers stand `below`."""
    named = [cell for cell in row if cell]
    if not named or not all(map(is_name, named)):
        return False
    most = row[:-1]  # lines may end with the delimiter
    return all(most) or any(is_number(cell) or is_number(cell, decimal=",") for cell in below)


def named_columns(rows: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Names of columns from the first of the rows, without empty ones behind the last column."""
    width = common_width(rows[1:]) if len(rows) > 1 else len(rows[0])
    return tuple(rows[0] if any(rows[0][width:]) else rows[0][:width])
