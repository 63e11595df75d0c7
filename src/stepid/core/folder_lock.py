"""Locks on folders that end with the process that holds them."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

if sys.platform != "win32":
    import fcntl

_ABANDONED = 3600.0  # s without a change, after which a folder is nobody's where locks do not work


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder, after whoever holds it now; without effect where the file system has no locks."""
    handle = _held(folder, wait=True)
    try:
        yield
    finally:
        if handle is not None:
            os.close(handle)


def is_abandoned(folder: Path) -> bool:
    """Say whether nobody holds a folder any more: its process has ended, or was killed."""
    try:
        handle = _held(folder, wait=False)
    except BlockingIOError:
        return False
    except OSError:  # not ours to look into
        return False
    if handle is not None:
        os.close(handle)
        return True
    return time.time() - folder.stat().st_mtime > _ABANDONED


def _held(folder: Path, *, wait: bool) -> int | None:
    """Open and lock a folder; None where that cannot be done, BlockingIOError where another holds it."""
    if sys.platform == "win32":  # has no such locks
        return None
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise
    except OSError:
        os.close(handle)
        return None
    return handle
