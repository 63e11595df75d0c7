"""One step of many plants at once: exact or in substeps between events, events located, sticking exact."""

from __future__ import annotations

import numpy as np

from stepid._base import Array
from stepid.engine.events import first_event, margins
from stepid.engine.exact import FullStep, Index
from stepid.engine.law import LENGTH, Law
from stepid.engine.substeps import stretch

STILL = 1e-7  # m/s, slower than this is at rest where dry friction acts
_EVENTS = 6  # reversals, contacts, stops and releases within one sample, at most


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
        after = stretch(law, table, z, elapsed, left, sign, sides, moving)
    else:
        after = full(group, table, z, sign, sides)
        held = np.flatnonzero(moving == 0)
        if held.size and law.n_rates > 2:
            part = z[:, held], elapsed[held], left[held], sign[held], sides[:, held], moving[held]
            after[:, held] = stretch(law, table[:, held], *part)
        elif held.size:
            after[:, held] = z[:, held]
    if not (law.reverses or law.n_sides):
        return after
    out = after.copy()
    index = np.arange(lanes)
    for _ in range(_EVENTS):
        end = margins(law, table, after, elapsed + left, sign, sides, moving)
        hit = np.flatnonzero((end < 0).any(axis=0))
        if not hit.size:
            break
        table, z, elapsed, left, index = table[:, hit], z[:, hit], elapsed[hit], left[hit], index[hit]
        sides, sign, moving, end = sides[:, hit], sign[hit], moving[hit], end[:, hit]
        start = margins(law, table, z, elapsed, sign, sides, moving)
        when, which, after = first_event(law, table, z, elapsed, left, sign, sides, moving, start, end, after[:, hit])
        turned = which == law.n_sides
        after[1, turned] = 0.0
        sides = sides.copy()
        flipped = np.flatnonzero(~turned)
        sides[which[flipped], flipped] *= -1
        z, elapsed, left = after, elapsed + when, left - when
        sign, moving = _direction(law, table, z, elapsed, sides)
        after = stretch(law, table, z, elapsed, left, sign, sides, moving)
        out[:, index] = after
    return out
