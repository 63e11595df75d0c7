"""Files that were dropped: kept in a folder of the session alone, under names that cannot lead out of it."""

from __future__ import annotations

import re
import shutil
import weakref
from collections.abc import Mapping
from pathlib import Path
from tempfile import mkdtemp

from stepid.errors import InputError
from stepid.io.safe_read import LARGEST_NOTE

LARGEST_UPLOAD = 5 * LARGEST_NOTE
"""Bytes of all files of a session."""
_MANY = 500  # files
_LONGEST = 120  # characters of a name


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
            If they are too many or too large.
        """
        if len(files) > _MANY:
            raise InputError(f"{len(files)} files are more than a campaign has", "Drop those of one campaign.")
        if (size := sum(map(len, files.values()))) > LARGEST_UPLOAD:
            raise InputError(
                f"the files hold {size / 1e6:,.0f} MB; up to {LARGEST_UPLOAD / 1e6:,.0f} MB are read here",
                "Read them in Python, or with stepid diagnose.",
            )
        kept = {safe_name(name): content for name, content in files.items()}
        same = {name for name in self.names if (self.folder / name).read_bytes() == kept.get(name)}
        for name in self.names:
            (self.folder / name).unlink()
        for name, content in kept.items():
            (self.folder / name).write_bytes(content)
        self.names = tuple(kept)
        return frozenset(same)

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
    plain = re.sub(r'[\x00-\x1f<>:"|?*]', "_", last).strip(" .")
    if len(plain) > _LONGEST:
        stem, point, ending = plain.rpartition(".")
        plain = f"{stem[: _LONGEST - len(ending) - 1]}.{ending}" if point and len(ending) < 10 else plain[:_LONGEST]
    return plain or "file"
