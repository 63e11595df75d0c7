"""Whole records solved at once: Newton over all samples of all runs, with the exact discrete sensitivities.

Every sample's state is an unknown and every step an equation, z[n+1] = Ψ(z[n]). All steps are evaluated side by side;
the Newton system is block bidiagonal, so one banded triangular solve gives the update, and the same matrix gives the
sensitivities. Causality makes it converge: each iteration settles at least one more step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import lapack

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.simulation.exact import FullStep, Index
from stepid.simulation.flow import advance, linearize
from stepid.simulation.law import LENGTH
from stepid.simulation.records import Records
from stepid.simulation.tables import Point, Tables

Mask = npt.NDArray[np.bool_]

_ITERATIONS = 14
_TOLERANCE = 1e-9  # m and m/s·s: far below a count
_FAR = 1e3  # states this many times larger than the data are a runaway


class Solved(NamedTuple):
    """A solved trajectory.

    States (d, S), reading (S,), its sensitivities to the shared (P, S) and local (Q, S) parameters, and the tangents of
    the states to all of them (P + Q, d, S); None where not wanted, zero by parameters that are not.
    """

    states: Array
    reading: Array
    shared: Array | None = None
    local: Array | None = None
    tangent: Array | None = None


class _Stage(NamedTuple):
    lanes: Array
    group: Index
    full: FullStep | None


class Simulator(Tables):
    """Solves all records of a campaign for one plant model, with sensitivities."""

    def __init__(self, records: Records, effects: tuple[Effect, ...], fineness: float = 1.0) -> None:
        super().__init__(records, effects, fineness)
        self._linked = np.ones(records.size, dtype=bool)
        self._linked[records.bounds[1:] - 1] = False
        w = np.median(records.sample_time)
        self._eps = np.array([1e-7, 1e-7 / w * 0.1] + [1e-7] * (self.law.n_states - 2)) * self._scale
        self._eps[2 : self.law.n_rates] = 1e-6 * max(self._scale, 1e-3)

    def _stages(self, point: Point) -> list[_Stage]:
        """Lane tables and exact steps of each part of a sample."""
        table = self.run_table(point)
        stages = []
        for part in self._parts(table):
            group, full = np.zeros(part[2].size, dtype=np.intp), None
            if self.law.affine:
                plants, group = self.plants(table, part[2])
                full = FullStep(self.law, plants)
            stages.append(_Stage(self._lanes(table, part), group, full))
        return stages

    def plants(self, table: Array, length: Array) -> tuple[Array, Index]:
        """Lane table of every different plant and step length, and which of them each copy and sample has."""
        copies, runs = table.shape[1:]
        owner = (np.arange(copies)[:, None] * runs + self.records.run).ravel()
        each = length[:, self.records.first]
        if np.array_equal(each[:, self.records.run], length):
            plants = table.copy()
            plants[LENGTH] = each
            return plants.reshape(self.law.n_rows, -1), owner
        flat = length.ravel()
        order = np.lexsort((flat, owner))
        fresh = np.ones(flat.size, dtype=bool)
        fresh[1:] = (np.diff(owner[order]) != 0) | (np.diff(flat[order]) != 0)
        group = np.empty(flat.size, dtype=np.intp)
        group[order] = np.cumsum(fresh) - 1
        of = order[fresh]
        plants = table.reshape(self.law.n_rows, -1)[:, owner[of]]
        plants[LENGTH] = flat[of]
        return plants, group

    def _step(self, stages: list[_Stage], z: Array, index: Index | None = None) -> Array:
        """Ψ of lanes (all, or those of `index`); z and the result have shape (d, lanes)."""
        for lanes, group, full in stages:
            if index is not None:
                lanes, group = lanes[:, index], group[index]
            if full is not None and self.law.linear:
                z = full(group, lanes, z, np.ones(z.shape[1]), np.ones((0, z.shape[1])))
            else:
                z = advance(self.law, lanes, z, full, group)
        return z

    def _linearize(self, stages: list[_Stage], z: Array, index: Index) -> tuple[Array, Array]:
        """Ψ (d, n) of samples `index` and its derivative by the state (d, d, n): [i, j] = ∂Ψ_i/∂z_j."""
        total: Array | None = None
        for lanes, group, full in stages:
            z, slope = linearize(self.law, lanes[:, index], z, self._eps, full, group[index])
            total = slope if total is None else np.einsum("ijs,jks->iks", slope, total)
        assert total is not None
        return z, total

    def band(self, slope: Array) -> Array:
        """Banded matrix of the chained steps for slopes (d, d, S), as LAPACK's dtbtrs takes it."""
        d, size = self.law.n_states, self.records.size
        band = np.zeros((2 * d, size * d))
        band[0] = 1.0
        view = band.reshape(2 * d, size, d)
        linked = np.where(self._linked, 1.0, 0.0)
        for i in range(d):
            for j in range(d):
                view[d + i - j, :, j] = -slope[i, j] * linked
        return band

    def triangular(self, band: Array, rhs: Array) -> Array:
        """Solve for stacked right-hand sides, shape (n, d, S) in and out."""
        n, d, size = rhs.shape
        if not n:
            return rhs
        b = np.asfortranarray(rhs.transpose(2, 1, 0).reshape(size * d, n))
        x, info = lapack.dtbtrs(band, b, uplo="L", diag="U", overwrite_b=1)
        if info:
            raise FloatingPointError
        out: Array = x.reshape(size, d, n).transpose(2, 1, 0)
        return out

    def _chain(self, psi: Array, initial: Array) -> Array:
        """What each sample's state should be: the step from the sample before, or the run's initial state."""
        target = np.empty_like(psi)
        target[..., 1:] = psi[..., :-1]
        target[..., self.records.first] = initial
        return target

    def guess(self) -> Array:
        """States read off the measured record, shape (d, S): a start for Newton."""
        r = self.records
        z = np.zeros((self.law.n_states, r.size))
        for piece in r.pieces():
            y = r.position[piece]
            z[0, piece] = y - y[0]
            z[1, piece] = np.gradient(y, r.time[piece])
        return z

    def along(self, shared: Array, local: Array, path: Array) -> Array:
        """States along a path, shape (d, S): its positions and velocities, and the memories that they leave behind."""
        z = np.zeros((self.law.n_states, self.records.size))
        z[:2] = path[:2]
        if self.law.n_rates == self.law.n_states:
            return z
        point = Point(shared[None], local[None])
        table = self.run_table(point).reshape(self.law.n_rows, -1)
        out, bounds = z.copy(), self.records.bounds
        out[self.law.n_rates :, self.records.first] = self.initial(point)[self.law.n_rates :, 0]
        lengths = np.diff(bounds)
        for k in range(int(lengths.max()) - 1):
            runs = np.flatnonzero(lengths > k + 1)
            at = bounds[runs] + k
            after = out[:, at + 1]
            after[self.law.n_rates :] = out[self.law.n_rates :, at]
            self.law.remember(table[:, runs], out[:, at], after, np.where(after[0] < out[0, at], -1.0, 1.0))
            out[:, at + 1] = after
        return out

    def solve(
        self, shared: Array, local: Array, *, start: Array | None = None, wanted: Mask | None = None
    ) -> Solved | None:
        """Solve all records for parameter values.

        Parameters
        ----------
        shared : array, shape (P,)
        local : array, shape (Q, R)
        start : array, shape (d, S), optional
            A nearby trajectory.
        wanted : array of bool, shape (P + Q,), optional
            Parameters to which sensitivities are wanted; none at all by default.

        Returns
        -------
        Solved or None
            None where the trajectory runs away or Newton does not settle: a rejected step.
        """
        point = Point(shared[None], local[None])
        with np.errstate(all="ignore"):
            try:
                return self._newton(point, self.guess() if start is None else start, wanted)
            except (FloatingPointError, np.linalg.LinAlgError):
                return None

    def _newton(self, point: Point, z: Array, wanted: Mask | None) -> Solved | None:
        initial = self.initial(point)[:, 0]
        limit = _FAR * self._scale
        weight = np.array([1.0, 0.01] + [1.0] * (self.law.n_states - 2))[:, None]
        stages = self._stages(point)
        psi, slope = self._linearize(stages, z, np.arange(self.records.size))
        worst = np.inf
        for iteration in range(_ITERATIONS):
            miss = self._chain(psi, initial) - z
            if not (np.isfinite(miss).all() and np.isfinite(slope).all()):
                return None
            band = self.band(slope)
            change = self.triangular(band, miss[None])[0]
            z = z + change
            largest = (np.abs(change) * weight).max(axis=0)
            if largest.max() < _TOLERANCE or self.law.linear:
                break
            if iteration >= 5 and largest.max() > 0.5 * worst:
                return None  # it wanders; a shorter step will do better
            worst = float(largest.max())
            if not np.abs(z[0]).max() < limit:
                return None
            psi = psi + np.einsum("ijs,js->is", slope, change)
            stale = np.flatnonzero(largest > 0.01 * _TOLERANCE)
            psi[:, stale], slope[:, :, stale] = self._linearize(stages, z[:, stale], stale)
        else:
            return None
        reading = z[0] + self._reading(point)[0]
        return Solved(z, reading) if wanted is None else self._sensitivities(point, z, band, reading, wanted)

    def march(self, shared: Array, local: Array) -> Array:
        """Solve sample by sample from each record's start: slower, but it needs no start and cannot fail to settle.

        Parameters
        ----------
        shared : array, shape (C, P)
        local : array, shape (C, Q, R)

        Returns
        -------
        array, shape (C, d, S)
            States; not finite where a plant runs away.
        """
        point = Point(shared, local)
        copies, size, bounds = shared.shape[0], self.records.size, self.records.bounds
        z = np.empty((self.law.n_states, copies, size))
        with np.errstate(all="ignore"):
            stages = self._stages(point)
            z[..., self.records.first] = self.initial(point)
            lengths = np.diff(bounds)
            for k in range(int(lengths.max()) - 1):
                at = bounds[:-1][lengths > k + 1] + k
                index = (np.arange(copies)[:, None] * size + at).ravel()
                after = self._step(stages, z[..., at].reshape(self.law.n_states, -1), index)
                z[..., at + 1] = after.reshape(self.law.n_states, copies, -1)
        return z.transpose(1, 0, 2)

    def _reading(self, point: Point) -> Array:
        total = np.zeros((point.shared.shape[0], self.records.size))
        table = self.run_table(point)
        for place in self.law.places:
            if type(place.effect).reading is not Effect.reading:
                values = tuple(row[:, self.records.run] for row in table[place.values])
                total = total + place.effect.reading(values, self.records.time)
        return total

    def reading(self, shared: Array, local: Array) -> Array:
        """What the effects add to the reading, m, shape (S,)."""
        out: Array = self._reading(Point(shared[None], local[None]))[0]
        return out

    def _sensitivities(self, point: Point, z: Array, band: Array, reading: Array, wanted: Mask) -> Solved:
        p, columns = self.n_shared, np.flatnonzero(wanted)
        n = columns.size
        steps = self.steps(point.shared[0])[columns]
        shared, local = np.repeat(point.shared, 1 + n, 0), np.repeat(point.local, 1 + n, 0)
        first = int(np.sum(columns < p))
        shared[np.arange(first) + 1, columns[:first]] += steps[:first]
        local[np.arange(first, n) + 1, columns[first:] - p] += steps[first:, None]
        many = Point(shared, local)
        start = self.initial(many)
        rhs = np.zeros((n, z.shape[0], self.records.size))
        begin = (columns == p) | (columns == p + 1) | (columns >= p + self.own_states.start)
        own = np.flatnonzero(~begin)  # the starting state acts at the start only
        some = np.append(0, own + 1)
        copies = np.repeat(z[:, None], some.size, axis=1).reshape(z.shape[0], -1)
        psi = self._step(self._stages(Point(shared[some], local[some])), copies).reshape(z.shape[0], some.size, -1)
        moved = (psi[:, 1:] - psi[:, :1]).transpose(1, 0, 2) / steps[own, None, None]
        rhs[own, :, 1:] = moved[..., :-1]
        rhs[..., self.records.first] = (start[:, 1:] - start[:, :1]).transpose(1, 0, 2) / steps[:, None, None]
        shown = self._reading(many)
        tangent = np.zeros((wanted.size, *z.shape))
        tangent[columns] = self.triangular(band, rhs)
        seen = tangent[:, 0].copy()
        seen[columns] += (shown[1:] - shown[:1]) / steps[:, None]
        return Solved(z, reading, seen[:p], seen[p:], tangent)
