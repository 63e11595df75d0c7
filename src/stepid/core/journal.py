"""Moving files into a folder so that, after a kill at any moment, the next run completes it or takes it back.

A scratch folder holds the new files in ``new``. Once all are on the disk and what they replace is kept in ``replaced``,
the file ``commit`` appears, which lists them; from then on the move is completed, by whoever comes next. Where a file
cannot be moved, ``commit`` is renamed to ``undo``, and the move is taken back. Each step can be done again.
"""

from __future__ import annotations

import json
import os
import shutil
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp

from stepid.core.folder_lock import is_abandoned, locked

PREFIX = ".stepid-writing-"
_PARTS = {"new", "replaced", "commit", "undo", "commit.part"}
_Listed = list[tuple[str, bool]]  # name, and whether it replaces a file


def make_scratch(out: Path) -> Path:
    """Make a scratch folder in `out`; its ``new`` is to be written into."""
    scratch = Path(mkdtemp(dir=out, prefix=PREFIX))
    for part in ("new", "replaced"):
        (scratch / part).mkdir()
    return scratch


def settle(out: Path) -> None:
    """Complete or take back what a killed process left in a folder, and clear it away.

    Parameters
    ----------
    out : pathlib.Path
        Nothing is done where it is no folder.
    """
    if not os.path.isdir(out) or not any(out.glob(PREFIX + "*")):
        return
    with locked(out):
        settle_locked(out)


def settle_locked(out: Path) -> None:
    """As `settle`, where `out` is locked already."""
    for scratch in sorted(out.glob(PREFIX + "*")):
        with suppress(FileNotFoundError):  # its owner has just cleared it away
            ours = scratch.is_dir() and not scratch.is_symlink() and is_abandoned(scratch)
            if ours and {path.name for path in scratch.iterdir()} <= _PARTS:
                if (scratch / "commit").exists():
                    _complete(scratch, out)
                elif (scratch / "undo").exists():
                    _take_back(scratch, out)
                clear(scratch)


def clear(scratch: Path) -> None:
    """Remove a scratch folder, unless what it keeps could not be put back."""
    if not any((scratch / marker).exists() for marker in ("commit", "undo")):
        shutil.rmtree(scratch, ignore_errors=True)


def move_all(scratch: Path, out: Path) -> None:
    """Move what is in ``new`` into `out`: all files or, where one cannot be moved, none."""
    new, replaced = scratch / "new", scratch / "replaced"
    listed: _Listed = []
    for name in sorted(path.name for path in new.iterdir()):
        old = out / name
        replaces = os.path.lexists(old) and (old.is_symlink() or not old.is_dir())
        if replaces:
            _keep(old, replaced / name)
        listed.append((name, replaces))
    for path in (*new.rglob("*"), new, replaced):
        if not path.is_symlink():
            _sync(path)
    part = scratch / "commit.part"
    part.write_text(json.dumps(listed), encoding="utf-8")
    _sync(part)
    os.replace(part, scratch / "commit")
    _sync(scratch)
    _complete(scratch, out)


def _complete(scratch: Path, out: Path) -> None:
    try:
        for name, _ in _listed(scratch / "commit"):
            if os.path.lexists(scratch / "new" / name):  # else it has been moved before
                (scratch / "new" / name).replace(out / name)
        _sync(out)
    except BaseException:
        with suppress(OSError):
            os.replace(scratch / "commit", scratch / "undo")
            _take_back(scratch, out)
        raise
    (scratch / "commit").unlink()


def _take_back(scratch: Path, out: Path) -> None:
    new, replaced = scratch / "new", scratch / "replaced"
    for name, replaces in reversed(_listed(scratch / "undo")):
        if replaces:
            if os.path.lexists(replaced / name):
                os.replace(replaced / name, out / name)
        elif os.path.lexists(out / name) and not os.path.lexists(new / name):
            os.replace(out / name, new / name)
    _sync(out)
    (scratch / "undo").unlink()


def _listed(journal: Path) -> _Listed:
    return [(str(name), bool(replaces)) for name, replaces in json.loads(journal.read_text(encoding="utf-8"))]


def _keep(old: Path, copy: Path) -> None:
    """Keep a file as it is under another name, by a second link where the file system has links."""
    try:
        os.link(old, copy, follow_symlinks=False)
    except (OSError, NotImplementedError):
        shutil.copy2(old, copy, follow_symlinks=False)
        if not copy.is_symlink():
            _sync(copy)


def _sync(path: Path) -> None:
    """Have a file's content, or a folder's list of names, written to the disk."""
    if path.is_dir():
        with suppress(OSError):  # folders cannot be opened everywhere
            handle = os.open(path, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)
        return
    with path.open("rb+") as file:
        os.fsync(file.fileno())
