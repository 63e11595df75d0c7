"""The first simulation after an installation compiles the kernel: who waits for it is told."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable
from pathlib import Path

import numpy as np


def warm_up(tell: Callable[[str], object]) -> None:
    """Load the kernel; where it has to be compiled, tell so first.

    Parameters
    ----------
    tell : callable
        Called with a few words.
    """
    if _loaded:
        return
    from stepid.simulation.compiled import numba

    mark = None if numba is None else _mark(numba.__version__)
    if numba is not None and (mark is None or not mark.exists()):
        tell("compiling once (some seconds)")
    _simulate()
    _loaded.append(True)
    if mark is not None:
        mark.touch()


_loaded: list[bool] = []  # in this process


def _mark(version: str) -> Path | None:
    """File that says that this kernel has been compiled on this machine; None where no cache can be written."""
    from stepid.simulation import kernel, slopes, triangles
    from stepid.simulation.laws import cache_folder

    folder = cache_folder()
    sources = [Path(str(module.__file__)).read_bytes() for module in (kernel, slopes, triangles)]
    what = [*sources, version.encode(), platform.platform().encode()]
    digest = hashlib.sha256(b"\0".join(what)).hexdigest()[:24]
    return None if folder is None else folder / f"compiled_{digest}"


def _simulate() -> None:
    """Simulate two samples of a linear plant, and take one step of a fit to them."""
    from stepid.simulation import kernel, slopes, triangles
    from stepid.simulation.work import structure

    time = np.array([0.0, 0.01])
    kernel.simulate(
        structure(()), np.array([[1.0, 200.0, 4.0, 8.0]]), np.zeros((1, 2)), np.zeros(1, dtype=np.intp),
        np.array([0, 2]), time, np.zeros((2, 1)), np.zeros(1), np.zeros(1, dtype=bool), 1e-9, 0.02, 2, 100,
        np.zeros(1, dtype=np.intp), np.empty(2), np.empty((2, 2)),
    )  # fmt: skip
    bounds, one, by_one = np.array([0, 2]), np.ones(1), np.eye(2)
    residual, none, first = np.empty(2), np.zeros(1, dtype=np.intp), np.zeros((1, 1), dtype=np.intp)
    slopes.slopes(np.ones(2), time, one, none, none, bounds)
    slopes.follow_units(
        np.zeros((3, 2)), one, np.zeros((1, 1)), none.astype(bool)[None], np.zeros((2, 1), dtype=bool), one, 0, none,
        none, one, 0.02, True, True, np.zeros((2, 1), dtype=bool), np.zeros((3, 1), dtype=np.intp), np.zeros((3, 1, 2)),
    )  # fmt: skip
    slopes.follow(by_one, time, time, time, bounds, np.full((3, 1), -1, dtype=np.intp), np.zeros((3, 1, 2)))
    triangles.weigh(time, np.zeros(2), np.ones(2), bounds, residual)
    found, size, no_own = np.zeros((1, 2, 2)), np.zeros(1), np.zeros((1, 0))
    triangles.reduce_runs(
        by_one, by_one, residual, np.ones(2), bounds, first, none, none, found, size, no_own, np.zeros(1)
    )
    triangles.damped_step(found, none, 1.0, size, no_own, np.zeros(1), no_own)
