"""One step of many plants at once: exact or in substeps between events, events located, sticking exact."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.simulation.events import first_event, margins
from stepid.simulation.exact import FullStep, Index
from stepid.simulation.law import LENGTH, Law
from stepid.simulation.stretch import Stretch

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
    way, after = _begun(law, table, z, full, group)
    if not (law.reverses or law.n_sides):
        return after
    out = after.copy()
    index = np.arange(z.shape[1])
    for _ in range(_EVENTS):
        end = margins(way, after, way.left)
        hit = np.flatnonzero((end < 0).any(axis=0))
        if not hit.size:
            break
        way, index = way.take(hit), index[hit]
        when, which, z = first_event(way, end[:, hit], after[:, hit])
        turned = which == law.n_sides
        z[1, turned] = 0.0
        sides = way.sides.copy()
        flipped = np.flatnonzero(~turned)
        sides[which[flipped], flipped] *= -1
        table, elapsed, left = way.table, way.elapsed + when, way.left - when
        sign, moving = _direction(law, table, z, elapsed, sides)
        way = Stretch(law, table, z, elapsed, left, sign, sides, moving, full, way.group)
        after = way.at(left)
        out[:, index] = after
    return out


def linearize(
    law: Law, table: Array, z: Array, eps: Array, full: FullStep | None = None, group: Index | None = None
) -> tuple[Array, Array]:
    """Advance every lane over its step, with the derivative by the state before it.

    Parameters
    ----------
    law, table, z, full, group
        See `advance`.
    eps : array, shape (n_states,)
        Differences of the states.

    Returns
    -------
    array, shape (n_states, lanes)
    array, shape (n_states, n_states, lanes)
        [i, j] = ∂z_i(after)/∂z_j(before): of affine laws exact but where an event comes between.
    """
    if full is None or group is None:
        return _differences(law, table, z, eps)
    way, after = _begun(law, table, z, full, group)
    slope = full.transition(group, way.sides)
    if law.reverses or law.n_sides:
        met = (margins(way, after, way.left) < 0).any(axis=0)
        near = np.flatnonzero(met | (way.z[1] == 0) if law.dry else met)
        if near.size:
            after[:, near], slope[:, :, near] = _differences(law, table[:, near], z[:, near], eps, full, group[near])
    return after, slope


def _differences(
    law: Law, table: Array, z: Array, eps: Array, full: FullStep | None = None, group: Index | None = None
) -> tuple[Array, Array]:
    """Advance every lane, and copies from slightly other states."""
    d = law.n_states
    copies = np.repeat(z[:, None], d + 1, axis=1)
    for j in range(d):
        copies[j, j + 1] += eps[j]
    many = None if group is None else np.tile(group, d + 1)
    psi = advance(law, np.tile(table, d + 1), copies.reshape(d, -1), full, many).reshape(d, d + 1, -1)
    return psi[:, 0], (psi[:, 1:] - psi[:, :1]) / eps[None, :, None]


def _begun(law: Law, table: Array, z: Array, full: FullStep | None, group: Index | None) -> tuple[Stretch, Array]:
    """The stretch from each lane's state on, and where it leads if no event comes between."""
    z = z.copy()
    elapsed, left = np.zeros(z.shape[1]), table[LENGTH].copy()
    sides = np.where(law.switches(table, z, elapsed) < 0, -1.0, 1.0)
    sign, moving = _direction(law, table, z, elapsed, sides)
    way = Stretch(law, table, z, elapsed, left, sign, sides, moving, full, group)
    if full is None or group is None:
        return way, way.at(left)
    after = full(group, table, z, sign, sides)
    held = np.flatnonzero(moving == 0)
    if held.size and law.n_rates > 2:
        after[:, held] = way.take(held).at(left[held])
    elif held.size:
        after[:, held] = z[:, held]
    return way, after
