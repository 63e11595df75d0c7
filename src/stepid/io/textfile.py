"""Text files of numbers: read, decoded and parsed whole; gone through row by row only to locate a mistake."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stepid.core.base import Array
from stepid.core.recorded import note_read
from stepid.core.takes import described
from stepid.core.words import counted
from stepid.errors import InputError
from stepid.io.safe_read import LARGEST, read_regular

_FOREIGN = re.compile(r"[^0-9eE+\-.]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?\d{1,3}([, \u00a0\u202f'’]\d{3})+(\.\d*)?", re.ASCII)
_NO_MARKS = "Export the numbers without marks between thousands, in all lines and columns."
_SWAPPED = str.maketrans(".,", ",.")
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)|-?1\.#\w+", re.IGNORECASE)

_SHEET_ERROR = re.compile(  # in the first cell of a row, as a spreadsheet writes it; ##### is a number too wide for it
    r"#(?:(?:N/A|N/D|NV|DIV/0!|GETTING_DATA|[A-ZÄÖÜ]+[!?])(?= *(?:[\t;,]|$)| +[+\-.\d])|##+(?= *[\t;,] *[\"+\-.\d]))"
)


def as_path(path: object) -> Path:
    """Return `path` as a `Path`; InputError where it is neither text nor path-like."""
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"{described(path)} is not a path", "Give the file's path as text or pathlib.Path.")
    spelled = os.fspath(path)
    if not isinstance(spelled, str) or not spelled:
        raise InputError(f"{path!r} is not a path", "Give the file's path as text or pathlib.Path.")
    if "\0" in spelled:
        raise InputError(f"{path!r} cannot be read or written: it holds a zero byte", "Correct the path.")
    return Path(spelled)


def read_lines(path: Path) -> list[str]:
    """Read a UTF-8 text file and split it at CR LF, LF or CR alone; line i of the file is element i − 1.

    Raises
    ------
    stepid.errors.InputError
        If the file is missing, unreadable, empty, binary or not UTF-8.
    """
    return split_lines(decode(read_bytes(path), str(path)))


def decode_as(raw: bytes, where: str, encoding: str | None) -> str:
    """Decode text of a table in an encoding that Python knows, UTF-8 where it is None; errors name the key."""
    if encoding is None:
        try:
            return decode(raw, where)
        except InputError as error:
            if "UTF" not in error.cause:
                raise
            likely = "utf-16" if "UTF-16" in error.cause else "cp1252"
            raise InputError(
                error.cause, f'Give encoding = "{likely}" if that is how it was written, or save it as UTF-8.'
            ) from None
    try:
        text = raw.decode(encoding)
    except LookupError:
        raise InputError(
            f"{where}: encoding is {encoding!r}", 'Give one that Python knows: "utf-8", "utf-16", "cp1252".'
        ) from None
    except UnicodeError as error:
        raise InputError(f"{where}: is not {encoding} text ({error})", "Correct encoding.") from None
    if not text.strip():
        raise InputError(f"{where}: is empty", "Export the record again.")
    return text.removeprefix("\ufeff")


def split_lines(text: str) -> list[str]:
    """Split text at CR LF, LF or CR alone."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def read_bytes(path: Path, *, largest: int = LARGEST) -> bytes:
    """Read a regular file whole; whatever the operating system objects to becomes an InputError."""
    try:
        raw = read_regular(path, largest=largest)
        note_read(path, raw)
        return raw
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file", "Check the path, and the folder it starts from.") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, not a file", "Give the path of the file in it.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path}: cannot be read ({reason})", "Check the path and its permissions.") from None


def decode(raw: bytes, where: str) -> str:
    """Decode UTF-8 with or without byte-order mark; `where` names the file in errors."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError(f"{where}: is UTF-16 text", "Save it again as plain text (UTF-8 or ASCII).")
    if b"\0" in raw:
        line = 1 + raw.count(b"\n", 0, raw.index(b"\0"))
        raise InputError(f"{where}, line {line}: holds a zero byte, so it is not text", "Export the record as text.")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        start = error.start + (3 if raw.startswith(b"\xef\xbb\xbf") else 0)
        line = 1 + raw.count(b"\n", 0, start)
        raise InputError(
            f"{where}, line {line}: byte 0x{raw[start]:02x} is not UTF-8 text",
            "Save the file as UTF-8 or ASCII (it may be Latin-1), or remove the accented letters.",
        ) from None
    if not text or text.isspace():
        raise InputError(f"{where}: is empty", "Export the record again.")
    return text


def is_comment(line: str) -> bool:
    """Tell whether a line is a comment; a row whose first cell is the error of a spreadsheet is none."""
    text = line.lstrip()
    return text.startswith(("#", "%")) and _SHEET_ERROR.match(text) is None


def is_number(token: str, *, decimal: str = ".") -> bool:
    """Say whether `token` is a plain decimal number (no NaN, no infinity, no underscores)."""
    return _NUMBER.fullmatch(_pointed(token, decimal)) is not None


def is_name(token: str) -> bool:
    """Say whether `token` can name a column: it starts with a letter and is no spelling of NaN or infinity."""
    return token[:1].isalpha() and not _NOT_FINITE.fullmatch(token)


def parse_numbers(
    rows: Sequence[Sequence[str]],
    *,
    lines: Sequence[int],
    columns: Sequence[str],
    where: str,
    remedy: str,
    decimal: str = ".",
    other_mark: str | None = None,
) -> Array:
    """Parse rows of tokens into an array.

    Parameters
    ----------
    rows : sequence of token lists
    lines : sequence of int
        Line number of each row in the file.
    columns : sequence of str
        Names, one a column.
    where : str
        The file, for errors.
    remedy : str
        What to do about a row that is damaged.
    decimal : str
        The decimal mark, ``"."`` or ``","``.
    other_mark : str, optional
        What to do about numbers with the other mark; `remedy` by default.

    Returns
    -------
    array, shape (len(rows), len(columns))

    Raises
    ------
    stepid.errors.InputError
        Naming file, line and column.
    """
    width = len(columns)
    flat = [token for row in rows for token in row]
    if decimal != ".":
        flat = [_pointed(token, decimal) for token in flat]
    if all(len(row) == width for row in rows) and not _FOREIGN.search("".join(flat)):
        try:
            table = np.array(list(map(float, flat)), dtype=np.float64).reshape(len(rows), width)
        except ValueError:
            pass
        else:
            if np.isfinite(table).all():
                return table
    raise _locate(rows, lines, columns, where, remedy, decimal, remedy if other_mark is None else other_mark)


def count_filled(rows: Sequence[Sequence[str]]) -> int:
    """Count the rows up to the last with a cell that is not empty: spreadsheets write marks of empty ones below."""
    return next((i for i in range(len(rows), 0, -1) if any(rows[i - 1])), 0)


def common_width(rows: Sequence[Sequence[str]]) -> int:
    """Return the number of tokens that most rows have."""
    return Counter(map(len, rows)).most_common(1)[0][0]


def _pointed(token: str, decimal: str) -> str:
    # swapped and not replaced, so that 1.234,5 is no number
    return token if decimal == "." else token.translate(_SWAPPED)


def _locate(
    rows: Sequence[Sequence[str]],
    lines: Sequence[int],
    columns: Sequence[str],
    where: str,
    remedy: str,
    decimal: str,
    other_mark: str,
) -> InputError:
    for row, line in zip(rows, lines, strict=True):
        for token, column in zip(row, columns, strict=False):
            plain = _pointed(token, decimal)
            if is_number(plain):
                if np.isfinite(float(plain)):
                    continue
                trouble = f"{_short(token)} is too large a number"
            elif _NOT_FINITE.fullmatch(plain):
                trouble = f"{token} is not a measurement"
            elif _DECIMAL_COMMA.fullmatch(plain):
                trouble = f"{_short(token)} has a decimal {'comma' if decimal == '.' else 'point'}"
                return InputError(f"{where}, line {line}, column {column!r}: {trouble}", other_mark)
            elif _THOUSANDS.fullmatch(plain):
                trouble = f"{_short(token)} has marks between its thousands"
                return InputError(f"{where}, line {line}, column {column!r}: {trouble}", _NO_MARKS)
            elif token:
                trouble = f"{_short(token)} is not a number"
            else:
                trouble = "is empty"
            return InputError(f"{where}, line {line}, column {column!r}: {trouble}", remedy)
        if len(row) != len(columns):
            return InputError(
                f"{where}, line {line}: the row holds {counted(len(row), 'value')} for {len(columns)} columns "
                f"({', '.join(columns)})",
                remedy,
            )
    return InputError(f"{where}: cannot be parsed", remedy)


def _short(token: str) -> str:
    return repr(token if len(token) <= 24 else token[:21] + "...")
