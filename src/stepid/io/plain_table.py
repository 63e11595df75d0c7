"""Large tables of nothing but numbers: parsed a piece at a time, without a Python object for each."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np

from stepid.core.base import Array

_PIECE = 1 << 22  # bytes parsed at once
_BLANKS = {mark: re.compile(rb" +(?=[\n%b])|(?<=[\n%b]) +" % (mark, mark)) for mark in (b" ", b",", b";", b"\t")}
_SEVERAL = re.compile(rb" {2,}")


class Places(Sequence[str]):
    """Where rows come from, "file, line n" of each, made when one is asked for.

    Parameters
    ----------
    pieces : sequence of (file, line numbers)
        Of files that are joined, in order.
    """

    def __init__(self, pieces: Sequence[tuple[str, Sequence[int]]]) -> None:
        self._pieces = tuple(pieces)

    @property
    def pieces(self) -> tuple[tuple[str, Sequence[int]], ...]:
        """Files and their line numbers."""
        return self._pieces

    def __len__(self) -> int:
        return sum(len(lines) for _, lines in self._pieces)

    @overload
    def __getitem__(self, index: int) -> str: ...
    @overload
    def __getitem__(self, index: slice) -> Places: ...
    def __getitem__(self, index: int | slice) -> str | Places:
        """Return the place of a row, or those of a segment of rows."""
        if isinstance(index, slice):
            first, last, step = index.indices(len(self))
            if step != 1:
                raise ValueError("rows are kept in one segment")
            return Places(tuple(self._between(first, last)))
        i = range(len(self))[index]
        file, lines = next(self._between(i, i + 1))
        return f"{file}, line {lines[0]}"

    def _between(self, first: int, last: int) -> Iterator[tuple[str, Sequence[int]]]:
        for file, lines in self._pieces:
            own = lines[max(first, 0) : max(last, 0)]
            if len(own):
                yield file, own
            first, last = first - len(lines), last - len(lines)


def parse_plain(body: bytes | memoryview, *, width: int, separator: str | None, decimal: str) -> Array | None:
    """Parse rows of plain decimal numbers, nothing else.

    Parameters
    ----------
    body : bytes
        Lines, without header.
    width : int
        Numbers in a row.
    separator : str or None
        What stands between them; None for blanks.
    decimal : str
        ``"."`` or ``","``.

    Returns
    -------
    array, shape (n, width), or None
        None where anything is not plain, for a parser that says what: empty lines or cells, names, quotes, comments,
        infinities, rows of another length.
    """
    mark = b" " if separator is None else separator.encode()
    if mark not in _BLANKS or (mark == b"," and decimal == ","):
        return None
    parts = []
    begin = 0
    while begin < len(body):
        end = min(begin + _PIECE, len(body))
        if end < len(body):
            cut = bytes(body[begin:end]).rfind(b"\n")
            if cut < 0:
                return None
            end = begin + cut + 1
        part = _parse(bytes(body[begin:end]), width, mark, decimal)
        if part is None:
            return None
        parts.append(part)
        begin = end
    if not parts:
        return None
    out = np.empty((sum(len(part) for part in parts), width))
    row = 0
    for i, part in enumerate(parts):
        out[row : row + len(part)] = part
        row += len(part)
        parts[i] = part[:0]  # so that not all is held twice
    return out


def _parse(text: bytes, width: int, mark: bytes, decimal: str) -> Array | None:
    text = text.replace(b"\r\n", b"\n").removesuffix(b"\n")
    point = decimal.encode()
    if text.translate(None, b"0123456789+-eE \n" + mark + point):
        return None
    text = _without_blanks(text, mark)
    marks = text.translate(None, (b"0123456789+-eE " + point).replace(mark, b"")) + b"\n"
    if marks != (mark * (width - 1) + b"\n") * marks.count(b"\n"):  # rows of another length
        return None
    values = _numbers(text.translate(bytes.maketrans(point + mark + b"\n", b".,,")))
    return None if values is None else values.reshape(-1, width)


def _without_blanks(text: bytes, mark: bytes) -> bytes:
    """Remove the blanks that part no numbers, and all but one of those that do."""
    if b" " not in text:
        return text
    if mark == b" ":
        text = _SEVERAL.sub(b" ", text)
    return _BLANKS[mark].sub(b"", text).strip(b" ")


def _numbers(text: bytes) -> Array | None:
    """Parse finite numbers between commas; None where a cell is none."""
    if b",," in text or b"," in (text[:1], text[-1:]):
        return None
    try:
        with warnings.catch_warnings():  # how it says that it did not come to the end
            warnings.simplefilter("error", DeprecationWarning)
            values = np.fromstring(text, dtype=np.float64, sep=",")
    except (ValueError, DeprecationWarning):
        return None
    return values if values.size == text.count(b",") + 1 and np.isfinite(values).all() else None
