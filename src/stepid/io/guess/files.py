"""Which files are recordings: those named, and those in the folders named."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Sequence
from pathlib import Path

from stepid.errors import InputError
from stepid.io.guess.file_names import natural
from stepid.io.guess.text import NoTableError, find_encoding
from stepid.io.guess.understand import recordings
from stepid.io.manifest import is_manifest
from stepid.io.textfile import read_bytes
from stepid.io.workbook import is_workbook

KINDS = (".csv", ".txt", ".xlsx", ".tsv", ".dat", ".m", ".lvm", ".asc")
_MANY = 500  # files
_MANIFEST = re.compile(r"""^\s*(?:\[\[\w+\]\]|\w+\s*=\s*["'])""", re.MULTILINE)  # one with a slip is no TOML


def looks_like_records(path: Path) -> bool:
    """Say whether a file's name ends as those of recordings do."""
    return path.suffix.lower() in KINDS


def holds_records(path: Path) -> bool:
    """Say whether a file holds recordings and is no manifest, by its content where its name does not tell."""
    if looks_like_records(path):
        return True
    if not path.is_file():
        return False
    raw = read_bytes(path)
    if is_workbook(raw):
        return True
    try:
        text, _ = find_encoding(raw, path)
        return _MANIFEST.search(text) is None and not is_manifest(text) and bool(recordings([path])[0])
    except NoTableError:
        return False
    except InputError:  # a table that is damaged: its reader says where
        return True


def files_of(
    paths: Sequence[Path], each: Sequence[str], *, call: Callable[[str], str]
) -> tuple[list[Path], tuple[str, ...]]:
    """Files, and those of folders, in order; and why some that hold no table are left out.

    Parameters
    ----------
    paths : sequence of pathlib.Path
        Files and folders, at least one.
    each : sequence of str
        Which answers say another value for each run: then the order must be clear.
    call : callable
        How an answer is called, for the error.
    """
    out: list[Path] = []
    for path in paths:
        inside = [file for file in path.iterdir() if looks_like_records(file)] if path.is_dir() else [path]
        out += sorted(inside, key=natural) if path.is_dir() else inside
    if not out:
        raise InputError(f"{paths[0]}: holds no recordings ({', '.join(KINDS)})", "Name the files.")
    if len(out) > _MANY:
        raise InputError(f"{len(out)} files are more than a campaign has", "Name those of one campaign.")
    if each:
        _check_order(out, [call(key) for key in each])
    files = sorted(out, key=natural) if not each and len({file.parent for file in out}) == 1 else out
    taken, refused = recordings(files) if len(files) > 1 else (files, ())
    return (taken, refused) if taken else (files, ())


def _check_order(files: Sequence[Path], names: Sequence[str]) -> None:
    """Refuse values a run for files in the order of a shell's pattern, where their numbers have another."""
    numbered = sorted(files, key=natural)
    shells = (str, lambda file: re.sub(r"[\W_]", "", str(file)).casefold())  # by bytes, or as a locale has it
    if numbered != list(files) and any(list(files) == sorted(files, key=key) for key in shells):
        given, meant = (shlex.join(file.name for file in order) for order in (files, numbered))
        raise InputError(
            f"{' and '.join(names)}: it is not clear which value is whose, as the files came in the order {given}",
            f"Name the files one by one in the order of the values, such as {meant}.",
        )
