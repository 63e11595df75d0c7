"""The plant's law on lanes: linear part plus effects, evaluated for many plants and moments at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Motion, Values

MASS, STIFFNESS, DAMPING, GAIN, VOLTS, TIME, LENGTH, FIRST = range(8)
"""Rows of a lane table: the plant, the held input, the step's start and length; effect values from FIRST on."""


class _Place(NamedTuple):
    effect: Effect
    values: slice
    extra: slice
    memory: slice
    sides: slice
    drives: bool  # changes the input
    pushes: bool  # adds a force


class Law:
    """A linear plant with effects; knows where each effect's values and states stand in the arrays.

    States are the rows of an array of shape (n_states, lanes): position, velocity, the effects' own states, their
    memories. Lane tables have shape (n_rows, lanes), see `FIRST`.
    """

    def __init__(self, effects: tuple[Effect, ...], fineness: float = 1.0) -> None:
        self.effects = effects
        self.fineness = fineness  # substeps are scaled by it: below 1 for searching, above 1 for checking
        self.n_rates = 2 + sum(e.n_extra for e in effects)
        self.n_states = self.n_rates + sum(e.n_memory for e in effects)
        self.n_sides = sum(e.n_switches for e in effects)
        self.linear = all(e.linear for e in effects)
        self.affine = all(e.linear or e.affine for e in effects)
        self.never_rests = any(e.never_rests for e in effects)
        self.dry = any(e.dry for e in effects)
        self.reverses = any(e.reverses for e in effects)
        row, extra, memory, side = FIRST, 2, self.n_rates, 0
        places = []
        for e in effects:
            width = len(e.parameters) + len(e.run_parameters)
            places.append(
                _Place(
                    e,
                    slice(row, row + width),
                    slice(extra, extra + e.n_extra),
                    slice(memory, memory + e.n_memory),
                    slice(side, side + e.n_switches),
                    type(e).drive is not Effect.drive,
                    type(e).force is not Effect.force,
                )
            )
            row, extra, memory, side = row + width, extra + e.n_extra, memory + e.n_memory, side + e.n_switches
        self.places = tuple(places)
        self.n_rows = row
        self._n_memory = self.n_states - self.n_rates
        self._relaxing = tuple(place for place in places if type(place.effect).relax is not Effect.relax)

    def values(self, table: Array, place: _Place) -> Values:
        """Return one effect's parameter values from a lane table."""
        return tuple(table[place.values])

    def motion(
        self, table: Array, place: _Place, z: Array, sign: Array, elapsed: Array | float, sides: Array
    ) -> Motion:
        """Return what one effect sees."""
        return _seen(place, _rows(table), z, sign, table[TIME] + elapsed, _own_sides(place, sides))

    def rates(
        self, table: Array, z: Array, sign: Array, elapsed: Array | float, sides: Array, out: Array, dry: bool = True
    ) -> Array:
        """Write the rates of position, velocity and the effects' own states into `out`, shape (n_rates, lanes)."""
        return Lanes(self, table, sides).rates(z, sign, elapsed, out, dry=dry)

    def net(self, table: Array, z: Array, elapsed: Array | float, sides: Array) -> Array:
        """Force on the cart without dry friction, N."""
        out = np.empty((self.n_rates, z.shape[1]))
        force: Array = self.rates(table, z, np.ones(z.shape[1]), elapsed, sides, out, dry=False)[1] * table[MASS]
        return force

    def breakaway(self, table: Array, z: Array, sign: Array, elapsed: Array | float, sides: Array) -> Array:
        """Largest force that dry friction holds at rest, N."""
        total = np.zeros(z.shape[1])
        for place in self.places:
            if place.effect.dry:
                m = self.motion(table, place, z, sign, elapsed, sides)
                total += place.effect.breakaway(self.values(table, place), m)
        return total

    def switches(self, table: Array, z: Array, elapsed: Array | float) -> Array:
        """Switching functions of all effects, shape (n_sides, lanes)."""
        out = np.empty((self.n_sides, z.shape[1]))
        blank = np.ones(z.shape[1])
        for place in self.places:
            if place.effect.n_switches:
                m = self.motion(table, place, z, blank, elapsed, out)
                out[place.sides] = place.effect.switches(self.values(table, place), m)
        return out

    def remember(self, table: Array, before: Array, after: Array, sign: Array) -> None:
        """Update the memory rows of `after` for a move from `before` without reversal."""
        if self._n_memory:
            for place in self.places:
                if place.effect.n_memory:
                    after[place.memory] = place.effect.remember(
                        self.values(table, place), tuple(before[place.memory]), after[0] - before[0], sign
                    )

    def relax(self, table: Array, before: Array, after: Array, time: Array, length: Array | None = None) -> None:
        """Write own states that follow the held input alone into `after`, see `Effect.relax`."""
        for place in self._relaxing:
            blank, sides = np.ones(before.shape[1]), np.ones((self.n_sides, before.shape[1]))
            m = self.motion(table, place, before, blank, 0.0, sides)
            after[place.extra] = place.effect.relax(self.values(table, place), m, time, length)

    def pieces(self, table: Array, z: Array, sign: Array, elapsed: Array, sides: Array, length: Array) -> Array:
        """Substeps that each lane needs for a step of `length`."""
        needed = np.sqrt(np.abs(table[STIFFNESS] / table[MASS])) * length / 0.25
        acceleration = None
        for place in self.places:
            if type(place.effect).pieces is not Effect.pieces:
                if acceleration is None:
                    out = np.empty((self.n_rates, z.shape[1]))
                    acceleration = self.rates(table, z, sign, elapsed, sides, out)[1]
                m = self.motion(table, place, z, sign, elapsed, sides)
                needed = np.maximum(needed, place.effect.pieces(self.values(table, place), m, acceleration, length))
        scaled: Array = needed * self.fineness
        return scaled


class Lanes:
    """A law on given lanes, its table's rows sliced once: for many calls with the same table and sides."""

    def __init__(self, law: Law, table: Array, sides: Array) -> None:
        self._rows = _rows(table)
        self._time, self._gain, self._pull = table[TIME], table[GAIN], -table[STIFFNESS]
        self._places = [(place, law.values(table, place), _own_sides(place, sides)) for place in law.places]

    def rates(self, z: Array, sign: Array, elapsed: Array | float, out: Array, *, dry: bool = True) -> Array:
        """Write the rates of position, velocity and the effects' own states into `out`, shape (n_rates, lanes)."""
        mass, _, damping, volts = self._rows
        time = self._time + elapsed
        total = self._pull * z[0]
        total -= damping * z[1]
        for place, p, sides in self._places:
            e = place.effect
            m = _seen(place, self._rows, z, sign, time, sides)
            if place.drives:
                volts = e.drive(p, m._replace(volts=volts))
            if place.pushes:
                total += e.force(p, m)
            if dry and e.dry:
                total -= sign * e.friction(p, m)
            if e.n_extra:
                out[place.extra] = e.rates(p, m)
        total += self._gain * volts
        out[0] = z[1]
        np.divide(total, mass, out=out[1])
        return out


def _rows(table: Array) -> tuple[Array, Array, Array, Array]:
    """Mass, stiffness, damping and input, of which every effect is told."""
    return table[MASS], table[STIFFNESS], table[DAMPING], table[VOLTS]


def _own_sides(place: _Place, sides: Array) -> tuple[Array, ...]:
    """Sides of one effect's own switches."""
    return tuple(sides[place.sides]) if place.effect.n_switches else ()


def _seen(
    place: _Place,
    rows: tuple[Array, Array, Array, Array],
    z: Array,
    sign: Array,
    time: Array,
    sides: tuple[Array, ...],
) -> Motion:
    """What one effect sees."""
    extra = tuple(z[place.extra]) if place.effect.n_extra else ()
    memory = tuple(z[place.memory]) if place.effect.n_memory else ()
    return Motion(z[0], z[1], sign, time, *rows, sides, extra, memory)
