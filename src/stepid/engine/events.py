"""Where within a step a law changes: reversals, contacts, stops and releases, located for many plants at once."""

from __future__ import annotations

import numpy as np

from stepid._base import Array
from stepid.engine.law import Lanes, Law
from stepid.engine.substeps import stretch

_ROOT = 3e-9  # m, m/s or N, of a switching function so near an event that the rest of the way is straight
_BEYOND = 1e-11  # by which the state is past the event: what held lets go
_GUESSES = 5  # on the cubic between two states
_CLOSE = 1e-3  # share of a step over which a margin's slope is taken


def margins(law: Law, table: Array, z: Array, elapsed: Array, sign: Array, sides: Array, moving: Array) -> Array:
    """Functions that are positive while the regime lasts: one a switch, then velocity or holding force."""
    rows = np.empty((law.n_sides + 1, z.shape[1]))
    if law.n_sides:
        rows[:-1] = sides * law.switches(table, z, elapsed)
    rows[-1] = sign * z[1] if law.reverses else 1.0
    if law.dry:
        held = np.flatnonzero(moving == 0)
        if held.size:
            part = table[:, held], z[:, held], elapsed[held], sides[:, held]
            net = law.net(*part)
            rows[-1, held] = law.breakaway(part[0], part[1], np.sign(net), part[2], part[3]) - np.abs(net)
            rows[:-1, held] = 1.0
    return rows


def first_event(
    law: Law,
    table: Array,
    z: Array,
    elapsed: Array,
    left: Array,
    sign: Array,
    sides: Array,
    moving: Array,
    start: Array,
    end: Array,
    z_end: Array,
) -> tuple[Array, Array, Array]:
    """Locate the first event of each lane: when, which margin, and the state there."""
    lanes = np.arange(z.shape[1])
    gone = end < 0
    guess = np.where(gone, np.maximum(start, 0) / np.where(gone, np.maximum(start, 0) - end, 1.0), np.inf)
    which = np.argmin(guess, axis=0)
    when, after = _locate(
        law, table, z, elapsed, sign, sides, moving, which, start[which, lanes], end[which, lanes], left, z_end
    )
    # a switch may have been passed and passed back before the reversal, or earlier than the guess said
    there = margins(law, table, after, elapsed + when, sign, sides, moving)
    there[which, lanes] = 1.0
    early = np.flatnonzero((there < 0).any(axis=0))
    if early.size:
        row = np.argmin(there[:, early], axis=0)
        pick = np.arange(early.size)
        when[early], after[:, early] = _locate(
            law,
            table[:, early],
            z[:, early],
            elapsed[early],
            sign[early],
            sides[:, early],
            moving[early],
            row,
            start[:, early][row, pick],
            there[:, early][row, pick],
            when[early],
            after[:, early],
        )
        which[early] = row
    return when, which, after


def _locate(
    law: Law,
    table: Array,
    z: Array,
    elapsed: Array,
    sign: Array,
    sides: Array,
    moving: Array,
    which: Array,
    start: Array,
    end: Array,
    high: Array,
    z_end: Array,
) -> tuple[Array, Array]:
    """Find where margin `which` of each lane changes sign within [0, high], `z_end` the state there."""
    left = high
    lanes = np.arange(z.shape[1])
    low = np.zeros_like(high)
    f_low, f_high = np.maximum(start, 0.0), end.copy()
    z_low, z_high = z, z_end.copy()
    at, slope = _interpolated(law, table, z, elapsed, sign, sides, moving, which, f_low, end, left, z_end)
    for _ in range(14):
        z_at = stretch(law, table, z_low, elapsed + low, at - low, sign, sides, moving)
        f = margins(law, table, z_at, elapsed + at, sign, sides, moving)[which, lanes]
        past = f < 0
        lighter_low = np.where(f_high < 0, 1 - f / f_high, 0.5)
        lighter_high = np.where(f_low > 0, 1 - f / np.where(f_low > 0, f_low, 1.0), 0.5)
        f_low = np.where(past, f_low * np.where(lighter_low > 0, lighter_low, 0.5), f)
        f_high = np.where(past, f, f_high * np.where(lighter_high > 0, lighter_high, 0.5))
        low, high = np.where(past, low, at), np.where(past, at, high)
        z_low, z_high = np.where(past, z_low, z_at), np.where(past, z_at, z_high)
        if np.all((np.abs(f) < _ROOT) | (high - low < 1e-10 * left)):
            break
        newton = at - f / slope
        inside = (newton > low) & (newton < high)
        at = np.where(inside, newton, _between(f_low, f_high, low, high))
    # so near, the rest of the way to just past the event is straight; where the bracket closed first, its far end
    rest = np.where(np.abs(f) < _ROOT, -(f + _BEYOND) / slope, 0.0)
    rates = np.zeros_like(z_at)
    law.rates(table, z_at, sign, elapsed + at, sides, rates[: law.n_rates])
    rates[:2] *= moving
    z_there = z_at + rest * rates
    law.remember(table, z_at, z_there, sign)
    near = (np.abs(f) < _ROOT) | ~past
    return np.where(near, at + rest, high), np.where(near, z_there, z_high)


def _between(f_low: Array, f_high: Array, low: Array, high: Array) -> Array:
    """Anderson-Bjorck: a false-position step, with the end that stays made lighter."""
    share = np.where(f_low > 0, f_low / np.where(f_low > 0, f_low - f_high, 1.0), 0.5)
    out: Array = low + np.clip(share, 1e-3, 1 - 1e-6) * (high - low)
    return out


def _interpolated(
    law: Law,
    table: Array,
    z: Array,
    elapsed: Array,
    sign: Array,
    sides: Array,
    moving: Array,
    which: Array,
    start: Array,
    end: Array,
    length: Array,
    z_end: Array,
) -> tuple[Array, Array]:
    """Where margin `which` of each lane changes sign on the cubic between the states at both ends, and its slope."""
    n, lanes = law.n_rates, np.arange(z.shape[1])
    rates = np.empty((2, n, z.shape[1]))
    held = Lanes(law, table, sides)
    held.rates(z, sign, elapsed, rates[0])
    held.rates(z_end, sign, elapsed + length, rates[1])
    rates[:, :2] *= moving
    rates *= length
    chord = z_end[:n] - z[:n]
    bend, twist = 3 * chord - 2 * rates[0] - rates[1], rates[0] + rates[1] - 2 * chord

    def margin(share: Array) -> Array:
        between = z.copy()
        between[:n] += share * (rates[0] + share * (bend + share * twist))
        law.remember(table, z, between, sign)
        there = margins(law, table, between, elapsed + share * length, sign, sides, moving)
        return np.asarray(there[which, lanes])

    low, high = np.zeros_like(length), np.ones_like(length)
    f_low, f_high = start, end
    for _ in range(_GUESSES):
        at = _between(f_low, f_high, low, high)
        f = margin(at)
        past = f < 0
        f_low, f_high = np.where(past, 0.5 * f_low, f), np.where(past, f, 0.5 * f_high)
        low, high = np.where(past, low, at), np.where(past, at, high)
    ahead, behind = np.minimum(at + _CLOSE, 1.0), np.maximum(at - _CLOSE, 0.0)
    slope = (margin(ahead) - margin(behind)) / ((ahead - behind) * length)
    return at * length, np.where(slope != 0, slope, np.inf)
