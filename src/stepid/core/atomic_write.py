"""Write a folder all at once or not at all."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from stepid.core.folder_lock import locked
from stepid.core.journal import clear, make_scratch, move_all, settle, settle_locked
from stepid.errors import InputError


@contextmanager
def staged(out: Path) -> Iterator[Path]:
    """Offer an empty folder inside `out`, and move what is in it into `out` only if nothing went wrong.

    Where moving fails halfway, what was moved is taken back and what it replaced is restored. Every file is whole at
    any moment; what a killed process left in `out` is completed or taken back first, and cleared away.

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
    _check_folder(out)
    made = [path for path in (out, *out.parents) if not path.exists()]
    done = False
    try:
        out.mkdir(parents=True, exist_ok=True)
        with _scratch(out) as scratch:
            yield scratch / "new"
            with locked(out):
                move_all(scratch, out)
        done = True
    except OSError as error:
        raise _refused(out, error) from error
    finally:
        for path in () if done else made:
            with suppress(OSError):
                path.rmdir()


def check_writable(out: Path) -> None:
    """Refuse what `staged` would, as far as it can be told without writing: before long work whose result goes there.

    Parameters
    ----------
    out : pathlib.Path
        A folder, or one that can be made.

    Raises
    ------
    stepid.errors.InputError
        If `out`, or the folder that it would be made in, is a file or cannot be written.
    """
    _check_folder(out)
    there = next((path for path in (out, *out.absolute().parents) if path.exists()), out)
    if not there.is_dir():
        raise _refused(out, NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR)))
    if not os.access(there, os.W_OK | os.X_OK):
        raise _refused(out, PermissionError(errno.EACCES, os.strerror(errno.EACCES)))


def _check_folder(out: Path) -> None:
    try:
        blocked = not stat.S_ISDIR(os.stat(out).st_mode)
    except (FileNotFoundError, NotADirectoryError):
        blocked = False
    except (OSError, ValueError) as error:  # a name that the system refuses
        raise _refused(out, error) from None
    if blocked:
        raise InputError(f"{out} is a file, not a folder", "Name a folder, on the command line with --out.")


@contextmanager
def _scratch(out: Path) -> Iterator[Path]:
    """Make a scratch folder in `out` and hold it, so that no other process takes it for a leftover."""
    with locked(out):
        settle_locked(out)
        scratch = make_scratch(out)
        hold = locked(scratch)
        hold.__enter__()
    try:
        yield scratch
    finally:
        clear(scratch)
        hold.__exit__(None, None, None)


def tidied(folder: Path) -> None:
    """Complete or take back what a killed process left in a folder; before one looks what is in it."""
    try:
        settle(folder)
    except OSError as error:
        raise _refused(folder, error) from error


def _refused(out: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or error
    return InputError(f"{out}: cannot be written ({reason})", "Choose another folder, on the command line with --out.")
