"""Write a folder all at once or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from stepid.errors import InputError


@contextmanager
def staged(out: Path) -> Iterator[Path]:
    """Offer an empty folder beside `out`, and move its files into `out` only if nothing went wrong.

    Parameters
    ----------
    out : pathlib.Path
        Where the files shall be; made if it does not exist, its other files stay.

    Yields
    ------
    pathlib.Path
        To write into.

    Raises
    ------
    stepid.errors.InputError
        If `out` is a file or cannot be written.
    """
    if out.exists() and not out.is_dir():
        raise InputError(
            f"{out} is a file, not a folder", "Name a folder for the results, on the command line with --out."
        )
    anchor = next(p for p in (out, *out.absolute().parents) if p.is_dir())  # on the file system of `out`
    try:
        with TemporaryDirectory(dir=anchor, prefix=".stepid-") as scratch:
            yield Path(scratch)
            out.mkdir(parents=True, exist_ok=True)
            for path in sorted(Path(scratch).iterdir()):
                os.replace(path, out / path.name)
    except OSError as error:
        raise InputError(
            f"cannot write to {out} ({error.strerror or error})",
            "Choose another folder, on the command line with --out.",
        ) from error
