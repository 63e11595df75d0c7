"""Where within a step a law changes: reversals, contacts, stops and releases, located for many plants at once."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.simulation.exact import Index
from stepid.simulation.series import crossing
from stepid.simulation.stretch import Stretch

_ROOT = 3e-9  # m, m/s or N, of a switching function so near an event that the rest of the way is straight
_BEYOND = 1e-11  # by which the state is past the event: what held lets go
_GUESSES = 5  # on the cubic between two states
_CLOSE = 1e-3  # share of a step over which a margin's slope is taken


def margins(way: Stretch, z: Array, time: Array | float) -> Array:
    """Functions that are positive while the regime lasts: one a switch, then velocity or holding force.

    Parameters
    ----------
    way : Stretch
    z : array, shape (n_states, lanes)
        States so long after its start.
    time : array, shape (lanes,), or float
        s

    Returns
    -------
    array, shape (n_sides + 1, lanes)
    """
    law, elapsed = way.law, way.elapsed + time
    rows = np.empty((law.n_sides + 1, z.shape[1]))
    if law.n_sides:
        rows[:-1] = way.sides * law.switches(way.table, z, elapsed)
    rows[-1] = way.sign * z[1] if law.reverses else 1.0
    if law.dry:
        held = np.flatnonzero(way.moving == 0)
        if held.size:
            part = way.table[:, held], z[:, held], elapsed[held], way.sides[:, held]
            net = law.net(*part)
            rows[-1, held] = law.breakaway(part[0], part[1], np.sign(net), part[2], part[3]) - np.abs(net)
            rows[:-1, held] = 1.0
    return rows


def first_event(way: Stretch, end: Array, z_end: Array) -> tuple[Array, Index, Array]:
    """Locate the first event of each lane: when, which margin, and the state there.

    Parameters
    ----------
    way : Stretch
    end : array, shape (n_sides + 1, lanes)
        Margins at its end, of each lane one at least negative.
    z_end : array, shape (n_states, lanes)
        States there.
    """
    lanes = np.arange(way.left.size)
    if not way.law.n_sides and way.moving.all() and way.terms is not None:  # it can but turn around
        c = way.sign * way.terms[:, 1]
        when = crossing(np.maximum(way.sign * way.z[1], 0.0), c, way.left, end[-1])
        return when, np.zeros(lanes.size, dtype=np.intp), way.at(when)
    start = margins(way, way.z, 0.0)
    gone = end < 0
    guess = np.where(gone, np.maximum(start, 0) / np.where(gone, np.maximum(start, 0) - end, 1.0), np.inf)
    which = np.argmin(guess, axis=0)
    when, z = _locate(way, which, start[which, lanes], end[which, lanes], way.left, z_end)
    if not way.law.n_sides:
        return when, which, z
    # a switch may have been passed and passed back before the reversal, or earlier than the guess said
    there = margins(way, z, when)
    there[which, lanes] = 1.0
    early = np.flatnonzero((there < 0).any(axis=0))
    if early.size:
        row = np.argmin(there[:, early], axis=0)
        pick = np.arange(early.size)
        ends = there[:, early][row, pick]
        when[early], z[:, early] = _locate(
            way.take(early), row, start[:, early][row, pick], ends, when[early], z[:, early]
        )
        which[early] = row
    return when, which, z


def _locate(way: Stretch, which: Index, start: Array, end: Array, high: Array, z_end: Array) -> tuple[Array, Array]:
    """Find where margin `which` of each lane changes sign within [0, high], `z_end` the state there."""
    left = high
    lanes = np.arange(left.size)
    low = np.zeros_like(high)
    f_low, f_high = np.maximum(start, 0.0), end.copy()
    z_low, z_high = way.z, z_end.copy()
    at, slope = _interpolated(way, which, f_low, end, left, z_end)
    for _ in range(14):
        z_at = way.onward(z_low, low, at)
        f = margins(way, z_at, at)[which, lanes]
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
    z_there = z_at + rest * way.rates(z_at, at)
    way.law.remember(way.table, z_at, z_there, way.sign)
    near = (np.abs(f) < _ROOT) | ~past
    return np.where(near, at + rest, high), np.where(near, z_there, z_high)


def _between(f_low: Array, f_high: Array, low: Array, high: Array) -> Array:
    """Anderson-Bjorck: a false-position step, with the end that stays made lighter."""
    share = np.where(f_low > 0, f_low / np.where(f_low > 0, f_low - f_high, 1.0), 0.5)
    out: Array = low + np.clip(share, 1e-3, 1 - 1e-6) * (high - low)
    return out


def _interpolated(
    way: Stretch, which: Index, start: Array, end: Array, length: Array, z_end: Array
) -> tuple[Array, Array]:
    """Where margin `which` of each lane changes sign on the cubic between the states at both ends, and its slope."""
    n, lanes = way.law.n_rates, np.arange(length.size)
    first, last = way.rates(way.z, 0.0)[:n] * length, way.rates(z_end, length)[:n] * length
    chord = z_end[:n] - way.z[:n]
    bend, twist = 3 * chord - 2 * first - last, first + last - 2 * chord

    def margin(share: Array) -> Array:
        between = way.z.copy()
        between[:n] += share * (first + share * (bend + share * twist))
        way.law.remember(way.table, way.z, between, way.sign)
        return np.asarray(margins(way, between, share * length)[which, lanes])

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
