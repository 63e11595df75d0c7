"""Files from strangers: only regular ones are read, of a size that can be a record, and none outside of a folder."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from stepid.errors import InputError
from stepid.io.program_files import check_no_program_file

LARGEST = 500_000_000
"""Bytes of a file. Ten million rows of three short numbers; 20 GB would fill the memory before anything is said."""
LARGEST_NOTE = 20_000_000
"""Bytes of a file that holds no record."""
LONGEST_LINE = 1_000_000
"""Bytes of a line. A table of 1,000 runs side by side has lines of 50,000."""
_PIECE = 1 << 20  # bytes read at once
_KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def read_regular(path: Path, *, largest: int = LARGEST) -> bytes:
    """Read a regular file whole, if its size and its lines can be a record's.

    Parameters
    ----------
    path : pathlib.Path
    largest : int
        Bytes that it may have.

    Returns
    -------
    bytes

    Raises
    ------
    stepid.errors.InputError
        If it is a pipe, a device or a socket, larger than `largest`, or one of its lines than `LONGEST_LINE`; if it
        is in a binary format of a program such as MATLAB.
    OSError, ValueError
        What the operating system says.
    """
    _check(path, os.stat(path), largest)  # before it is opened: opening a pipe waits, opening a device may act
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with open(descriptor, "rb", buffering=0) as file:
        _check(path, os.fstat(descriptor), largest)  # it may be another one by now
        return _pieces(path, file, largest)


def _check(path: Path, found: os.stat_result, largest: int) -> None:
    mode = found.st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError
    if not stat.S_ISREG(mode):
        kind = next((words for test, words in _KINDS if test(mode)), "something else")
        raise InputError(f"{path}: is {kind}, not a file", "Copy the record into a file.")
    if found.st_size > largest:
        raise _too_large(path, largest, f"{found.st_size / 1e6:,.0f} MB")


def _pieces(path: Path, file: object, largest: int) -> bytes:
    pieces: list[bytes] = []
    size = line = 0  # bytes in all, and since the last line began
    while piece := file.read(_PIECE):  # type: ignore[attr-defined]
        if not size:
            check_no_program_file(path, piece)
        size += len(piece)
        if size > largest:  # some files of the system say that they hold nothing
            raise _too_large(path, largest, f"more than {largest / 1e6:,.0f} MB")
        cut = max(piece.rfind(b"\n"), piece.rfind(b"\r"))
        # within a piece no line is longer than the limit, so only the one that goes on from piece to piece counts
        line = line + len(piece) if cut < 0 else len(piece) - cut - 1
        if line > LONGEST_LINE:
            raise InputError(
                f"{path}: a line is longer than {LONGEST_LINE:,} characters, so it is no record's",
                "Export the record as text with one row a sample.",
            )
        pieces.append(piece)
    return b"".join(pieces)


def _too_large(path: Path, largest: int, size: str) -> InputError:
    split = "Split a table into several files, which a run may join; leave out columns, or export fewer samples."
    return InputError(
        f"{path}: holds {size}; files of up to {largest / 1e6:,.0f} MB are read here",
        split if largest >= LARGEST else "Check that it is the file that you mean.",
    )


def inside(folder: Path, name: str, who: str, *, allow_outside: bool) -> Path:
    """Return the path of a file that a manifest in `folder` names; InputError where it leads out of the folder.

    Parameters
    ----------
    folder : pathlib.Path
    name : str
        As in the manifest.
    who : str
        Names manifest and run in errors.
    allow_outside : bool
        Take it wherever it leads.
    """
    path = folder / name
    if allow_outside:
        return path
    remedy = (
        "Put the file beside the manifest, or allow it: --allow-outside on the command line, "
        "read_campaign(…, allow_outside=True) in Python."
    )
    if os.path.isabs(name) or Path(name).anchor:
        raise InputError(f"{who}: the file {name!r} is an absolute path", remedy)
    if ".." in Path(name).parts:
        raise InputError(f"{who}: the file {name!r} leads out of the manifest's folder", remedy)
    try:
        root, real = os.path.realpath(folder), os.path.realpath(path)
        within = os.path.commonpath((root, real)) == root
    except ValueError:  # a zero byte, or another drive
        within = "\0" in name  # the system refuses the name
    if not within:
        raise InputError(f"{who}: the file {name!r} is a link out of the manifest's folder", remedy)
    return path
