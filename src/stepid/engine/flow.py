"""One step of many plants at once: Dormand–Prince between events, events located, sticking exact."""

from __future__ import annotations

import numpy as np

from stepid._base import Array
from stepid.engine.exact import FullStep, Index
from stepid.engine.law import LENGTH, Law

STILL = 1e-7  # m/s, slower than this is at rest where dry friction acts
_ROOT = 3e-12  # m or m/s, of the switching functions at an event
_EVENTS = 6  # reversals, contacts, stops and releases within one sample, at most
_MOST_PIECES = 64
_A = (
    np.array([1 / 5]),
    np.array([3 / 40, 9 / 40]),
    np.array([44 / 45, -56 / 15, 32 / 9]),
    np.array([19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729]),
    np.array([9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656]),
)
_B = np.array([35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84])
_C = (0.2, 0.3, 0.8, 8 / 9, 1.0)


def _smooth(
    law: Law, table: Array, z: Array, elapsed: Array, length: Array, sign: Array, sides: Array, moving: Array, n: int
) -> Array:
    """Advance by `length` in `n` equal Dormand–Prince steps (order 5) with the regime held fixed."""
    h = length / n
    shape = (law.n_rates, z.shape[1])
    k = np.empty((6, *shape))
    flat = k.reshape(6, -1)
    held = not moving.all()
    z = z.copy()
    for i in range(n):
        start = elapsed + i * h
        law.rates(table, z, sign, start, sides, k[0])
        if held:
            k[0, :2] *= moving
        for stage in range(1, 6):
            y = z.copy()
            y[: law.n_rates] += h * (_A[stage - 1] @ flat[:stage]).reshape(shape)
            law.remember(table, z, y, sign)
            law.rates(table, y, sign, start + _C[stage - 1] * h, sides, k[stage])
            if held:
                k[stage, :2] *= moving
        y = z.copy()
        y[: law.n_rates] += h * (_B @ flat).reshape(shape)
        law.remember(table, z, y, sign)
        z = y
    return z


def _stretch(
    law: Law, table: Array, z: Array, elapsed: Array, length: Array, sign: Array, sides: Array, moving: Array
) -> Array:
    """Advance every lane by its own `length` with as many substeps as it needs."""
    needed = law.pieces(table, z, sign, elapsed, sides, length)
    needed = np.ceil(np.clip(np.nan_to_num(needed, nan=1.0), 1.0, _MOST_PIECES if law.fineness >= 1 else 8.0))
    most = needed.max(initial=1.0)
    if most == needed.min(initial=most):
        return _smooth(law, table, z, elapsed, length, sign, sides, moving, int(most))
    out = np.empty_like(z)
    group = np.where(needed <= 1, 0, np.where(needed <= 4, 1, 2))  # few groups: each costs a round of calls
    for value in range(3):
        at = np.flatnonzero(group == value)
        if at.size:
            n = int(needed[at].max())
            out[:, at] = _smooth(
                law, table[:, at], z[:, at], elapsed[at], length[at], sign[at], sides[:, at], moving[at], n
            )
    return out


def _direction(law: Law, table: Array, z: Array, elapsed: Array, sides: Array) -> tuple[Array, Array]:
    """Direction of motion of each lane, and 1.0 where it moves, 0.0 where friction holds it."""
    lanes = z.shape[1]
    moving = np.ones(lanes)
    if not law.reverses:
        return np.ones(lanes), moving
    sign = np.where(z[1] < 0, -1.0, 1.0)
    at = np.flatnonzero(np.abs(z[1]) <= (STILL if law.dry else 0.0))
    if at.size:
        z[1, at] = 0.0
        net = law.net(table[:, at], z[:, at], elapsed[at], sides[:, at])
        sign[at] = np.where(net < 0, -1.0, 1.0)
        if law.dry:
            hold = law.breakaway(table[:, at], z[:, at], sign[at], elapsed[at], sides[:, at])
            moving[at] = np.abs(net) > hold
    return sign, moving


def _margins(law: Law, table: Array, z: Array, elapsed: Array, sign: Array, sides: Array, moving: Array) -> Array:
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
    for _ in range(14):
        # Anderson-Bjorck: a false-position step, with the end that stays made lighter
        share = np.where(f_low > 0, f_low / np.where(f_low > 0, f_low - f_high, 1.0), 0.5)
        at = low + np.clip(share, 1e-3, 1 - 1e-6) * (high - low)
        z_at = _stretch(law, table, z_low, elapsed + low, at - low, sign, sides, moving)
        f = _margins(law, table, z_at, elapsed + at, sign, sides, moving)[which, lanes]
        past = f < 0
        lighter_low = np.where(f_high < 0, 1 - f / f_high, 0.5)
        lighter_high = np.where(f_low > 0, 1 - f / np.where(f_low > 0, f_low, 1.0), 0.5)
        f_low = np.where(past, f_low * np.where(lighter_low > 0, lighter_low, 0.5), f)
        f_high = np.where(past, f, f_high * np.where(lighter_high > 0, lighter_high, 0.5))
        low, high = np.where(past, low, at), np.where(past, at, high)
        z_low, z_high = np.where(past, z_low, z_at), np.where(past, z_at, z_high)
        if np.all((np.abs(f) < _ROOT) | (high - low < 1e-10 * left)):
            break
    # the state just past the event, whichever side the last try fell on
    close = ~past
    high, z_high = np.where(close, at, high), np.where(close, z_at, z_high)
    return high, z_high


def advance(law: Law, table: Array, z: Array, full: FullStep | None = None, group: Index | None = None) -> Array:
    """Advance every lane over its step.

    Parameters
    ----------
    law : Law
    table : array, shape (n_rows, lanes)
    z : array, shape (n_states, lanes)
    full : FullStep, optional
        Exact whole steps, for affine laws.
    group : array of int, shape (lanes,), optional
        Which of the plants of `full` each lane is.

    Returns
    -------
    array, shape (n_states, lanes)
    """
    lanes = z.shape[1]
    z = z.copy()
    elapsed, left = np.zeros(lanes), table[LENGTH].copy()
    sides = np.where(law.switches(table, z, elapsed) < 0, -1.0, 1.0)
    sign, moving = _direction(law, table, z, elapsed, sides)
    if full is None or group is None:
        after = _stretch(law, table, z, elapsed, left, sign, sides, moving)
    else:
        after = full(group, table, z, sign, sides)
        held = np.flatnonzero(moving == 0)
        if held.size and law.n_rates > 2:
            part = z[:, held], elapsed[held], left[held], sign[held], sides[:, held], moving[held]
            after[:, held] = _stretch(law, table[:, held], *part)
        elif held.size:
            after[:, held] = z[:, held]
    if not (law.reverses or law.n_sides):
        return after
    out = after.copy()
    index = np.arange(lanes)
    for _ in range(_EVENTS):
        end = _margins(law, table, after, elapsed + left, sign, sides, moving)
        hit = np.flatnonzero((end < 0).any(axis=0))
        if not hit.size:
            break
        table, z, elapsed, left, index = table[:, hit], z[:, hit], elapsed[hit], left[hit], index[hit]
        sides, sign, moving, end = sides[:, hit], sign[hit], moving[hit], end[:, hit]
        start = _margins(law, table, z, elapsed, sign, sides, moving)
        when, which, after = _first(law, table, z, elapsed, left, sign, sides, moving, start, end, after[:, hit])
        turned = which == law.n_sides
        after[1, turned] = 0.0
        sides = sides.copy()
        flipped = np.flatnonzero(~turned)
        sides[which[flipped], flipped] *= -1
        z, elapsed, left = after, elapsed + when, left - when
        sign, moving = _direction(law, table, z, elapsed, sides)
        after = _stretch(law, table, z, elapsed, left, sign, sides, moving)
        out[:, index] = after
    return out


def _first(
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
    there = _margins(law, table, after, elapsed + when, sign, sides, moving)
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
