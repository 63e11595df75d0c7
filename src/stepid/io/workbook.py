"""Workbooks of spreadsheets (Office Open XML, .xlsx) as lines of text: cells as they are stored, tabs between them.

ECMA-376, Part 1: the workbook names its sheets, its relationships say where they are; texts are shared or inline.
"""

from __future__ import annotations

import posixpath
import re
import zipfile
import zlib
from io import BytesIO
from xml.etree import ElementTree

from stepid.errors import InputError

_MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_LINK = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}id"
_LARGEST = 200_000_000  # bytes of one part unpacked; no record is so long
_WIDEST = 2000  # columns


def is_workbook(raw: bytes) -> bool:
    """Say whether a file's bytes are a packed archive, as workbooks are."""
    return raw.startswith(b"PK\x03\x04")


def sheet_names(raw: bytes, where: str) -> tuple[str, ...]:
    """Names of a workbook's sheets; InputError where it is none."""
    return tuple(name for name, _ in _sheets(_opened(raw, where), where))


def workbook_lines(raw: bytes, where: str, sheet: str | None = None) -> list[str]:
    """Rows of a sheet, the first by default, as lines with tabs between cells; InputError where there is none."""
    book = _opened(raw, where)
    sheets = _sheets(book, where)
    part = sheets[0][1] if sheet is None else dict(sheets).get(sheet)
    if part is None:
        listed = ", ".join(repr(name) for name, _ in sheets)
        raise InputError(f"{where}: has no sheet {sheet!r}", f"Its sheets are {listed}.")
    shared: list[str] = []
    if "xl/sharedStrings.xml" in book.namelist():
        shared = [_text(item) for item in _part(book, "xl/sharedStrings.xml", where).iter(f"{_MAIN}si")]
    lines: list[list[str]] = []
    for i, row in enumerate(_part(book, part, where).iter(f"{_MAIN}row"), 1):
        number = _whole(row.get("r"), i)
        if len(lines) < number - 1 < len(lines) + 100_000:
            lines += [[] for _ in range(number - 1 - len(lines))]
        lines.append(_cells(row, shared))
    width = max(map(len, lines), default=0)  # of empty cells at the end of a row nothing is stored
    return ["\t".join(cells + [""] * (width - len(cells))) for cells in lines]


def _cells(row: ElementTree.Element, shared: list[str]) -> list[str]:
    cells: list[str] = []
    for cell in row.iter(f"{_MAIN}c"):
        letters = re.match(r"[A-Z]{1,3}", cell.get("r", ""))
        at = _column(letters[0]) if letters else len(cells)
        if len(cells) < at < _WIDEST:
            cells += [""] * (at - len(cells))
        cells.append(re.sub(r"\s+", " ", _value(cell, shared)).strip())
    return cells


def _column(letters: str) -> int:
    number = 0
    for letter in letters:
        number = 26 * number + ord(letter) - 64
    return number - 1


def _value(cell: ElementTree.Element, shared: list[str]) -> str:
    kind = cell.get("t", "n")
    if kind == "inlineStr":
        return _text(cell)
    stored = cell.findtext(f"{_MAIN}v") or ""
    if kind == "s":
        index = _whole(stored, -1)
        return shared[index] if 0 <= index < len(shared) else ""
    return stored


def _whole(text: str | None, default: int) -> int:
    return int(text) if text is not None and text.isdecimal() and len(text) < 9 else default


def _text(item: ElementTree.Element) -> str:
    """Its pieces, but those that say how the others are read aloud (furigana)."""
    aloud = {piece for reading in item.iter(f"{_MAIN}rPh") for piece in reading.iter(f"{_MAIN}t")}
    return "".join(piece.text or "" for piece in item.iter(f"{_MAIN}t") if piece not in aloud)


def _opened(raw: bytes, where: str) -> zipfile.ZipFile:
    try:
        book = zipfile.ZipFile(BytesIO(raw))
    except zipfile.BadZipFile as error:
        raise _damaged(where, error) from None
    if "xl/workbook.xml" not in book.namelist():
        raise InputError(f"{where}: is a packed archive and no workbook (.xlsx)", "Unpack it, or save it as CSV.")
    return book


def _sheets(book: zipfile.ZipFile, where: str) -> list[tuple[str, str]]:
    """Name and part of each sheet that holds cells."""
    links = {}
    if "xl/_rels/workbook.xml.rels" in book.namelist():
        for link in _part(book, "xl/_rels/workbook.xml.rels", where):
            target = link.get("Target", "")
            links[link.get("Id")] = target.lstrip("/") if target.startswith("/") else posixpath.join("xl", target)
    found = [
        (sheet.get("name", ""), links[sheet.get(_LINK)])
        for sheet in _part(book, "xl/workbook.xml", where).iter(f"{_MAIN}sheet")
        if sheet.get(_LINK) in links
    ]
    there = [(name, part) for name, part in found if part in book.namelist() and "worksheets" in part]
    if not there:
        raise InputError(f"{where}: holds no sheet of cells", "Save the sheet as CSV.")
    return there


def _part(book: zipfile.ZipFile, name: str, where: str) -> ElementTree.Element:
    try:
        if book.getinfo(name).file_size > _LARGEST:
            raise InputError(f"{where}: is too large a workbook", "Save the sheet as CSV.")
        content = book.read(name)
        if b"<!DOCTYPE" in content[:1000]:  # workbooks have none, and entities could grow without end
            raise InputError(f"{where}: is no workbook as spreadsheets write it", "Save the sheet as CSV.")
        return ElementTree.fromstring(content)
    except InputError:
        raise
    except (
        KeyError,
        RuntimeError,
        OSError,
        ValueError,
        zlib.error,
        zipfile.BadZipFile,
        ElementTree.ParseError,
    ) as error:
        raise _damaged(where, error) from None


def _damaged(where: str, error: Exception) -> InputError:
    return InputError(f"{where}: is a damaged workbook ({error})", "Save it again, or as CSV.")
