"""Files that were dropped: kept in a folder of the session alone, under names that cannot lead out of it."""

from __future__ import annotations

import re
import shutil
import weakref
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp

from stepid.errors import InputError
from stepid.io.safe_read import LARGEST_NOTE

LARGEST_UPLOAD = 5 * LARGEST_NOTE
"""Bytes of all files of a session."""
_MANY = 500  # files
_LONGEST = 120  # characters of a name
_LARGEST_NAME = 240  # bytes of a name; systems of files take 255


class Inbox:
    """The files of one session; `close` removes them."""

    def __init__(self) -> None:
        self.folder = Path(mkdtemp(prefix="stepid-")).resolve()
        # a notebook closes nothing: then the folder goes with the object, at the latest with Python
        self._remove = weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
        self.names: tuple[str, ...] = ()

    def put(self, files: Mapping[str, bytes]) -> frozenset[str]:
        """Keep exactly these files, and say which were there already, the same to the byte.

        Parameters
        ----------
        files : mapping
            Name as dropped to content.

        Returns
        -------
        frozenset of str
            Names in the folder.

        Raises
        ------
        stepid.errors.InputError
            If they are too many or too large, two get the same name, or they cannot be written; the files before stay.
        """
        if len(files) > _MANY:
            raise InputError(f"{len(files)} files are more than a campaign has", "Drop those of one campaign.")
        if (size := sum(map(len, files.values()))) > LARGEST_UPLOAD:
            raise InputError(
                f"the files hold {size / 1e6:,.0f} MB; up to {LARGEST_UPLOAD / 1e6:,.0f} MB are read here",
                "Read them in Python, or with stepid diagnose.",
            )
        kept = _by_safe_name(files)
        try:
            same = {name for name in self.names if (self.folder / name).read_bytes() == kept.get(name)}
            self._replace(kept)
        except OSError as error:
            raise InputError(
                f"the files cannot be kept ({error.strerror or error})", "Make room on the disk, or rename them."
            ) from None
        return frozenset(same)

    def _replace(self, kept: Mapping[str, bytes]) -> None:
        """Write files, and only then remove those before: where writing fails, they stay."""
        with TemporaryDirectory(prefix="stepid-") as scratch:
            for name, content in kept.items():
                with open(Path(scratch) / name, "xb") as file:  # where a and A are one file, the second is refused
                    file.write(content)
            self.names = ()  # should the rest fail, none is looked for again
            for old in self.folder.iterdir():
                old.unlink()
            for name in kept:
                shutil.move(Path(scratch) / name, self.folder / name)
        self.names = tuple(kept)

    def hidden(self, text: str) -> str:
        """Return a text without the folder of this machine."""
        for folder in (str(self.folder), self.folder.as_posix()):
            text = text.replace(f"{folder}/", "").replace(f"{folder}\\", "").replace(folder, "the dropped files")
        return text

    def close(self) -> None:
        """Remove the files."""
        self._remove()


def safe_name(name: str) -> str:
    """The last part of a name, without what a system of files could take for something else."""
    last = re.split(r"[\\/]", name)[-1]
    plain = re.sub(r'[\x00-\x1f<>:"|?*\ud800-\udfff]', "_", last).strip(" .")
    if len(plain) > _LONGEST or len(plain.encode()) > _LARGEST_NAME:
        # in the middle: names of runs differ, and tell a mass, at their ends
        cuts = (f"{plain[:half]}…{plain[-half:]}" for half in range(_LONGEST // 2 - 1, 0, -1))
        plain = next(cut for cut in cuts if len(cut.encode()) <= _LARGEST_NAME)
    return plain or "file"


def _by_safe_name(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Give files the names that they are kept under; InputError where two would be one."""
    names: dict[str, str] = {}
    for name in files:
        if (safe := safe_name(name)) in names:
            raise InputError(f"{names[safe]!r} and {name!r} would both be kept as {safe!r}", "Rename one of them.")
        names[safe] = name
    return {safe: files[name] for safe, name in names.items()}
