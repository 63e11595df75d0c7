"""Titles of columns in the lines above them: names, units, groups."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from stepid.io.guess.rows import cells
from stepid.io.guess.words import is_unit, read_title
from stepid.io.textfile import is_comment, is_name, is_number

_REMARKS = ("comment", "comments")
_ROLES = ("time", "position", "input")
_WITH_UNIT = re.compile(r"\S+(?:\s*[\[({<][^\])}>]*[\])}>])?")  # a name, and its unit in brackets
_SYMBOL = re.compile(r"[dΔσ]?[^\W\d_]\d?")  # t, x, dx, y2


class Titles(NamedTuple):
    """Names, units and groups of columns, one text a column, empty where there is none, and the line of the names."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    groups: tuple[str, ...]
    place: int | None
    unmatched: tuple[str, ...] = ()  # of a header that has more or fewer than there are columns

    def header(self, lines: Sequence[str], separator: str | None) -> int | None:
        """Line of the header if the table's reader takes it: right above the rows, one usable name a column."""
        place = self.place
        if place is None or any(self.groups) or (any(self.units) and self.units != self.names):
            return None
        row = cells(lines[place], separator)
        beyond = any(row[len(self.names) :])
        usable = not is_comment(lines[place]) and _usable(row) and len(row) >= len(self.names) and not beyond
        return place if usable else None


def find_titles(above: Sequence[str], separator: str | None, width: int, last: int) -> Titles:
    """Find the titles of columns in the lines above them; behind the `last` column with readings they may be empty."""
    none = ("",) * width
    filled = [i for i, line in enumerate(above) if line.strip(" \t;,")]
    if filled and (unmatched := _unmatched(above[filled[-1]], separator, width, last)):
        return Titles(none, none, none, None, unmatched)
    found = [(i, row) for i in filled[-3:] if (row := _row(above[i], separator, width)) is not None]
    found = found[::-1]
    units: tuple[str, ...] = none
    if found and _are_units(found[0][1]):
        if len(found) == 1 or not _is_header(found[1][1]):  # columns that are called by their units
            return Titles(found[0][1], found[0][1], none, found[0][0])
        units, found = found[0][1], found[1:]
    if not found or not _is_header(found[0][1]) or found[0][0] != filled[-1 - any(units)]:
        return Titles(none, units, none, None)
    place, names = found[0]
    groups = none
    if len(set(filter(None, names))) < len([n for n in names if n]) and len(found) > 1:
        groups = _spread(found[1][1])
    return Titles(names, units, groups, place)


def labeled_units(above: Sequence[str], separator: str | None, width: int) -> tuple[str, ...]:
    """Units of columns from a line that begins with the word, wherever it stands above the rows."""
    for line in above:
        label, *units = _row(line, separator, width) or ("",)
        if re.search(r"(?i)unit(?!ed)|einheit", label) and _are_units(units):
            return ("", *units)
    return ("",) * width


def _usable(row: Sequence[str]) -> bool:
    """Tell whether a reader can take columns by these names."""
    named = [cell for cell in row if cell]
    return all(map(is_name, named)) and len(named) == len(set(named)) and all(row[:-1]) and bool(named)


def _bare(line: str) -> str:
    return line.strip(" ").lstrip("#%").strip(" ") if is_comment(line) else line


def _row(line: str, separator: str | None, width: int) -> tuple[str, ...] | None:
    bare = _bare(line)
    split = cells(bare, separator)
    if len(split) != width:
        wide = [cell for cell in bare.replace("\t", "  ").split("  ") if cell.strip()]
        split = [cell.strip() for cell in wide] if len(wide) == width else split
    if len(split) == width + 1 and split[-1].lower() in _REMARKS:  # LabVIEW writes no cell below it
        split = split[:-1]
    by_blanks = len(split) != width or not any(split[1:])  # delimiters may stand behind names that blanks part
    if by_blanks and len(words := bare.split()) == width > 1 and _are_names(words):
        split = words
    if len(split) < width and separator is not None:  # titles of groups may end early
        split += [""] * (width - len(split))
    return tuple(split) if len(split) == width else None


def _unmatched(line: str, separator: str | None, width: int, last: int) -> tuple[str, ...]:
    """Names of a header that are more or fewer than there are columns, so that none can be told whose it is."""
    row, split = _row(line, separator, width), cells(_bare(line), separator)
    named = [cell for cell in split if cell]
    if (row is not None and all(row)) or (len(split) == width and len(named) > 1):
        return ()
    by_blanks = _WITH_UNIT.findall(_bare(line))
    for names in (named if separator else by_blanks, by_blanks):
        if len(names) > 1 and len(names) not in (width, last) and _are_names(names):
            return tuple(names)
    return ()


def _are_names(words: Sequence[str]) -> bool:
    """Tell names of columns from words of a title, one of which may say what the other is of, or its unit."""
    titles = list(map(read_title, words))
    one = len(words) == 2 and (read_title(" ".join(words)).unit is not None or titles[0].role == titles[1].role)
    named = zip(words, titles, strict=True)
    return not one and all(_SYMBOL.fullmatch(word) or title.role in _ROLES for word, title in named)


def _are_units(row: Sequence[str]) -> bool:
    filled = [cell for cell in row if cell and cell != "-"]
    return bool(filled) and all(is_unit(cell) for cell in filled)


def _is_header(row: Sequence[str]) -> bool:
    filled = [cell for cell in row if cell]
    return bool(filled) and not any(is_number(cell) or is_number(cell, decimal=",") for cell in filled)


def _spread(row: Sequence[str]) -> tuple[str, ...]:
    """Titles of groups, each up to the next one."""
    out, last = [], ""
    for cell in row:
        last = cell or last
        out.append(last)
    return tuple(out)
