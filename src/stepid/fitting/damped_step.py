"""A step of Levenberg–Marquardt: the derivatives of each run are reduced to a triangle, all are solved together."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array

if TYPE_CHECKING:
    from stepid.fitting.levenberg_marquardt import Problem

_ROUNDING = 1e-13  # of the typical displacement: no larger difference of all readings is more than rounding


class Step(NamedTuple):
    """A damped step of the global and of the per-run parameters, and the decrease of the cost that it promises."""

    inner: Array
    local: Array
    promised: float


class Columns:
    """Which parameters enter which run: those of a run enter that run only; runs without any are one block."""

    def __init__(self, problem: Problem) -> None:
        self.active = active = problem.active
        free = np.flatnonzero(problem.free)
        own = active.sum(axis=0)
        self.n_shared, most = free.size, int(own.max(initial=0))
        self.columns = np.zeros((own.size, most + free.size), dtype=np.intp)
        for r, count in enumerate(own):
            self.columns[r, :count] = problem.layout.n_global + np.flatnonzero(active[:, r])
            self.columns[r, count : count + free.size] = free
        self.own, (self.owners,) = own, np.nonzero(own)
        self.block = np.where(own > 0, np.cumsum(own > 0) - 1, self.owners.size)
        self.sizes = np.append(own[self.owners], 0)  # of each block, that of runs without own parameters last


class Linearized:
    """The fit to first order about a point, each run reduced to a triangle."""

    def __init__(
        self, problem: Problem, columns: Columns, slopes: tuple[Array, Array], residual: Array, steps: Array
    ) -> None:
        from stepid.simulation.triangles import reduce_runs

        r, self._columns = problem.records, columns
        n, blocks, width = columns.n_shared, columns.sizes.size, columns.columns.shape[1] + 1
        self._triangles = np.zeros((blocks, width, width))
        size, own_size, self.pull = np.zeros(n), np.zeros((blocks, width - 1 - n)), np.zeros(n)
        with np.errstate(all="ignore"):  # plain Python would warn of a runaway
            self.finite = reduce_runs(
                *slopes, residual, r.weight, r.bounds, columns.columns, columns.own, columns.block,
                self._triangles, size, own_size, self.pull,
            )  # fmt: skip
        size, own_size = np.sqrt(size), np.sqrt(own_size)
        seen = size * steps[problem.free] > _ROUNDING * problem.simulator.scale
        self._size = np.where(seen, size, np.inf)
        self._own_size = np.where(own_size > 1e-14 * own_size.max(initial=1e-300), own_size, np.inf)

    def step(self, damping: float, blocked: npt.NDArray[np.bool_], held: npt.NDArray[np.bool_]) -> Step:
        """Damped step; global parameters that are blocked and per-run ones that are held, shape (Q, R), stay."""
        from stepid.simulation.triangles import damped_step

        c = self._columns
        size, own_size = np.where(blocked, np.inf, self._size), self._own_size.copy()
        for run, sizes in zip(c.owners, own_size, strict=False):
            still = held[c.active[:, run], run]
            sizes[: still.size][still] = np.inf
        shared, own = np.zeros(c.n_shared), np.zeros_like(own_size)
        gain = damped_step(self._triangles, c.sizes, damping, size, own_size, shared, own)
        local = np.zeros(c.active.shape)
        for run, steps, count in zip(c.owners, own, c.sizes, strict=False):
            local[c.active[:, run], run] = steps[:count]
        return Step(shared, local, gain)
