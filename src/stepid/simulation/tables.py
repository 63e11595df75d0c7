"""Lane tables of all runs and samples, and the states in which records begin."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.simulation.law import DAMPING, FIRST, GAIN, LENGTH, MASS, STIFFNESS, TIME, VOLTS, Law
from stepid.simulation.magnitudes import exponents, magnitudes
from stepid.simulation.records import Records


class Point(NamedTuple):
    """Parameter values of C plants ("copies"): `shared` (C, P), `local` (C, Q, R)."""

    shared: Array
    local: Array


class Tables:
    """Writes parameter values as lane tables, one lane a copy and run, or a copy and sample."""

    def __init__(self, records: Records, effects: tuple[Effect, ...], fineness: float = 1.0) -> None:
        self.records = records
        self.law = Law(effects, fineness)
        self.n_labels = (len(records.bases), len(records.springs), len(records.dampers))
        self.n_linear = sum(self.n_labels) + 1
        self.n_shared = self.n_linear + sum(len(e.parameters) for e in effects)
        # displacement and velocity at the start, the effects' run parameters, their own states at the start
        self.own_states = slice(2 + sum(len(e.run_parameters) for e in effects), None)
        self.n_local = self.own_states.start + self.law.n_states - 2
        self._powers = exponents(tuple(q for e in effects for q in e.parameters))
        self._scale = max(float(np.abs(records.centered(records.position)).max(initial=0.0)), 1e-9)

    # ---- magnitudes -----------------------------------------------------------------------------------------------

    def steps(self, shared: Array) -> Array:
        """Finite-difference steps of the shared and the local parameters, shape (P + Q,)."""
        local = np.full(self.n_local, 1e-6)
        local[:2] = 1e-6 * self._scale, 1e-5 * self._scale
        local[self.own_states] = 1e-6 * self._scale
        return np.concatenate([1e-6 * np.maximum(np.abs(shared), 1e-2 * self.typical(shared)), local])

    def typical(self, shared: Array) -> Array:
        """Magnitudes by which the shared parameters are judged."""
        a, b, c = self.n_labels
        mass, stiffness = np.abs(shared[:a]).max(), np.abs(shared[a : a + b]).max()
        out = np.maximum(np.abs(shared), 1e-12)
        own = magnitudes(self._powers, mass=mass, stiffness=stiffness, gain=shared[a + b + c], travel=self._scale)
        out[self.n_linear :] = np.maximum(out[self.n_linear :], own)  # at zero, too, there is a slope to find
        out[:a] = max(mass, 0.1)
        out[a + b : self.n_linear - 1] = np.sqrt(mass * stiffness)
        return out

    # ---- lane tables ------------------------------------------------------------------------------------------

    def run_table(self, point: Point) -> Array:
        """Lane table of every copy and run, shape (n_rows, C, R); times, volts and lengths are filled in later."""
        r = self.records
        copies, runs = point.shared.shape[0], len(r.runs)
        a, b, c = self.n_labels
        table = np.zeros((self.law.n_rows, copies, runs))
        table[MASS] = point.shared[:, :a][:, r.base] + r.added_mass
        table[STIFFNESS] = point.shared[:, a : a + b][:, r.spring]
        table[DAMPING] = point.shared[:, a + b : a + b + c][:, r.damper]
        table[GAIN] = point.shared[:, a + b + c, None]
        row, shared, local = FIRST, self.n_linear, 2
        for e in self.law.effects:
            for _ in e.parameters:
                table[row] = point.shared[:, shared, None]
                row, shared = row + 1, shared + 1
            for _ in e.run_parameters:
                table[row] = point.local[:, local]
                row, local = row + 1, local + 1
        table[LENGTH] = r.sample_time
        table[VOLTS] = r.before
        return table

    def _delay(self, table: Array) -> Array | None:
        total = None
        for place in self.law.places:
            if type(place.effect).delay is not Effect.delay:
                extra = place.effect.delay(self.law.values(table, place)) * np.ones(table.shape[1:])
                total = extra if total is None else total + extra
        return total

    def _parts(self, table: Array) -> list[tuple[Array, Array, Array]]:
        """Split each step where a delayed input changes: (volts, start, length), each (C, S)."""
        r = self.records
        delay = self._delay(table)
        copies = table.shape[1]
        length = np.broadcast_to(r.length, (copies, r.size))
        if delay is None:
            return [(np.broadcast_to(r.volts, length.shape), np.zeros(length.shape), length)]
        full = r.source or r
        now = np.arange(r.size) if r.at is None else r.at
        first, before = full.first[r.run], r.before[r.run]
        h, late = r.sample_time[r.run], np.maximum(delay, 0.0)[:, r.run]
        # the fine sample whose input arrives at the step's start, -1 before the record, and the next that differs
        at = np.maximum(now - np.ceil(late / h).astype(int), first - 1)
        change = self._next_change[at + 1]
        volts = np.where(at >= first, full.volts[np.maximum(at, 0)], before)
        after = full.volts[np.minimum(change, full.size - 1)]
        split = np.clip((change - now) * h + late, 0.0, length)
        return [(volts, np.zeros(length.shape), split), (after, split, length - split)]

    @cached_property
    def _next_change(self) -> Array:
        """For each fine sample, the first from there on in its run whose input differs from the one before it."""
        full = self.records.source or self.records
        previous = np.concatenate([[0.0], full.volts[:-1]])
        previous[full.first] = full.before
        out = np.where(full.volts != previous, np.arange(full.size), 2 * full.size)
        for piece in full.pieces():
            out[piece] = np.minimum.accumulate(out[piece][::-1])[::-1]
        return np.concatenate([out, [2 * full.size]])

    def _lanes(self, table: Array, part: tuple[Array, Array, Array]) -> Array:
        """Expand a run table over the samples, shape (n_rows, C·S)."""
        full = table[:, :, self.records.run]
        full[VOLTS], full[TIME], full[LENGTH] = part[0], self.records.time + part[1], part[2]
        return full.reshape(self.law.n_rows, -1)

    # ---- where records begin --------------------------------------------------------------------------------------

    def initial(self, point: Point) -> Array:
        """States at each run's first sample, shape (d, C, R)."""
        r, law = self.records, self.law
        table = self.run_table(point)
        flat = table.reshape(law.n_rows, -1)
        moving = np.broadcast_to(r.moving, point.local[:, 0].shape).ravel()
        x = np.zeros(flat.shape[1])
        if np.any(r.before):
            for _ in range(12):
                z = self._still(flat, x)
                step = 1e-6 * self._scale
                f = law.net(flat, z, 0.0 * x, self._sides(flat, z))
                z = self._still(flat, x + step)
                slope = (law.net(flat, z, 0.0 * x, self._sides(flat, z)) - f) / step
                slope = np.minimum(slope, -0.05 * flat[STIFFNESS])  # in a gap there is none: leap out of it
                x = x - np.where(moving, 0.0, f / slope)
        x = x + point.local[:, 0].ravel()
        z = self._still(flat, x)
        z[1] = np.where(moving | law.never_rests, point.local[:, 1].ravel(), 0.0)
        offsets = point.local[:, self.own_states].swapaxes(0, 1).reshape(law.n_states - 2, flat.shape[1])
        z[2:] += np.where(moving, offsets, 0.0)
        return z.reshape(law.n_states, *table.shape[1:])

    def _sides(self, table: Array, z: Array) -> Array:
        return np.where(self.law.switches(table, z, np.zeros(z.shape[1])) < 0, -1.0, 1.0)

    def _still(self, table: Array, x: Array) -> Array:
        z = np.zeros((self.law.n_states, x.size))
        z[0] = x
        for place in self.law.places:
            e = place.effect
            own = e.at_rest(self.law.values(table, place), x, table[VOLTS])
            if e.n_extra:
                z[place.extra] = own[: e.n_extra]
            if e.n_memory:
                z[place.memory] = own[e.n_extra :]
        return z
