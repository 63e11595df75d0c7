"""Write a folder all at once or not at all."""

from __future__ import annotations

import os
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from stepid.errors import InputError


@contextmanager
def staged(out: Path) -> Iterator[Path]:
    """Offer an empty folder beside `out`, and move what is in it into `out` only if nothing went wrong.

    Where moving fails halfway, what was moved is taken back and what it replaced is restored.

    Parameters
    ----------
    out : pathlib.Path
        Where the files shall be; made if it does not exist, its other files stay.

    Yields
    ------
    pathlib.Path
        To write into. Its files are moved in the order of their names.

    Raises
    ------
    stepid.errors.InputError
        If `out` is a file or cannot be written.
    """
    try:
        blocked = not stat.S_ISDIR(os.stat(out).st_mode)
    except (FileNotFoundError, NotADirectoryError):
        blocked = False
    except (OSError, ValueError) as error:  # a name that the system refuses
        raise _refused(out, error) from None
    if blocked:
        raise InputError(f"{out} is a file, not a folder", "Name a folder, on the command line with --out.")
    anchor = next(p for p in (out, *out.absolute().parents) if p.is_dir())  # on the file system of `out`
    try:
        with TemporaryDirectory(dir=anchor, prefix=".stepid-") as scratch:
            new, replaced = Path(scratch, "new"), Path(scratch, "replaced")
            new.mkdir()
            replaced.mkdir()
            yield new
            _move(new, out, replaced)
    except OSError as error:
        raise _refused(out, error) from error


def _move(new: Path, out: Path, replaced: Path) -> None:
    made = [path for path in (out, *out.parents) if not path.exists()]
    names = sorted(path.name for path in new.iterdir())
    try:
        out.mkdir(parents=True, exist_ok=True)
        for name in names:
            if (out / name).is_file():
                shutil.copy2(out / name, replaced / name)
            (new / name).replace(out / name)
    except BaseException:
        for name in reversed(names):
            if not os.path.lexists(new / name):  # so it is in `out`
                saved = os.path.lexists(replaced / name)
                with suppress(OSError):
                    os.replace(*((replaced / name, out / name) if saved else (out / name, new / name)))
        for path in made:
            with suppress(OSError):
                path.rmdir()
        raise


def _refused(out: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or error
    return InputError(f"{out}: cannot be written ({reason})", "Choose another folder, on the command line with --out.")
