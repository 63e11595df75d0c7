"""Where friction may have held the cart: starts that follow from where each run began and came to rest."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.multistart import FitContext, Start
from stepid.simulation.records import Records, mass_span

_LAST = 10  # samples under one input, at the end of which a cart that rests does not move
_NOISE = 6.0  # times the floor that readings at rest differ by at most
_TIMES = 10.0  # the least friction that holds every run where it began: more holds it, too, and a fit lowers it
_CENTER = 1e-3  # weight of "the runs began around the spring's rest position", which the stops alone leave open


class _Stop(NamedTuple):
    """A place where a run came to rest: how far from where it began [m], under which input [V], moving which way."""

    run: int
    travel: float
    volts: float
    way: float


def held_starts(context: FitContext, effect: Effect) -> list[Start]:
    """Starts of a dry friction of one parameter in which runs begin off the spring's rest position, held by it.

    A cart that moved one way comes to rest where spring and drive differ by the friction: k x = K u ∓ F. For a friction
    F the runs' travels tell the gain and where each began. Each F that holds all of them there is as good, until it
    is fitted. Where steps move the cart only once the linear plant's mass tells little: others are tried, too.

    Parameters
    ----------
    context : FitContext
    effect : Effect

    Returns
    -------
    list of Start
        None where the runs' travels tell of no friction.
    """
    if not effect.dry or len(effect.parameters) > 1:
        return []
    records, floor = context.records, context.floor
    stops = _stops(records, floor)
    held = sorted({stop.run for stop in stops})
    if len(held) < 2:
        return []
    pushes = effect.regressors(context.scales, context.motion)
    size = max((float(np.abs(push.forces[0]).max()) for push in pushes), default=0.0)
    if not size > 0:
        return []
    layout = context.coarse_linear.problem.layout
    out = []
    for linear in _plants(context):
        stiffness = linear[layout.stiffness][records.spring]
        least = _holds(records, stops, held, stiffness, 0.0)[2]
        values = pushes[0].values(np.array([_TIMES * least / size]))
        if least < _NOISE * floor * float(stiffness[held].min()) or values is None:
            continue
        gain, apart, _ = _holds(records, stops, held, stiffness, _TIMES * least)
        begun = linear.copy()
        begun[layout.force_gain] = gain
        out.append(Start(begun, (values,), apart))
    return out


def _plants(context: FitContext) -> list[Array]:
    """The linear plant, and others with the span of the added masses for its mass: weights would change these.

    One has the plant's rates, one its spring and damper, one is critically damped and as slow.
    """
    linear, layout = context.coarse_linear.shared, context.coarse_linear.problem.layout
    span, mass = mass_span(context.records), float(linear[layout.base_mass][0])
    if span == 0 or mass <= 0:
        return [linear]
    heavier, slow = linear.copy(), linear.copy()
    heavier[layout.base_mass] *= span / mass
    delay = float(linear[layout.damping].mean() / linear[layout.stiffness].mean())
    if delay <= 0:
        return [linear, linear * span / mass, heavier]
    stiffer = 4.0 * span / delay**2 / float(linear[layout.stiffness].mean())
    slow[layout.stiffness] *= stiffer
    slow[layout.damping] *= stiffer
    slow[layout.base_mass] *= span / mass
    return [linear, linear * span / mass, heavier, slow]


def _stops(records: Records, floor: float) -> list[_Stop]:
    """Where driven runs that begin at rest come to rest again, each as long as its input stays as it is."""
    out = []
    for run, piece in enumerate(records.pieces()):
        if records.moving[run] or not records.driven[run]:
            continue
        position, volts = records.position[piece], records.volts[piece]
        edges = [0, *(np.flatnonzero(np.diff(volts)) + 1).tolist(), volts.size]
        for first, end in pairwise(edges):
            last = position[max(end - _LAST, first) : end]
            moved = np.flatnonzero(np.abs(position[first:end] - last.mean()) > _NOISE * floor)
            if last.size == _LAST and np.ptp(last) <= _NOISE * floor and moved.size:
                place = float(last.mean())
                way = float(np.sign(place - position[first + moved[-1]]))
                out.append(_Stop(run, place - float(position[0]), float(volts[end - 1]), way))
    return out


def _holds(
    records: Records, stops: list[_Stop], held: list[int], stiffness: Array, friction: float
) -> tuple[float, Array, float]:
    """Gain [N/V] and displacements at the start [m] by which runs come to rest where they did; what holds them [N]."""
    column = {run: i for i, run in enumerate(held)}
    matrix = np.zeros((len(stops) + len(held), len(held) + 1))
    right = np.zeros(len(matrix))
    for i, stop in enumerate(stops):
        matrix[i, column[stop.run]], matrix[i, -1] = 1.0, -stop.volts
        right[i] = -stop.way * friction - stiffness[stop.run] * stop.travel
    before = records.before[held]
    matrix[len(stops) :, :-1] = _CENTER * np.eye(len(held))
    matrix[len(stops) :, -1] = -_CENTER * before
    found = np.linalg.lstsq(matrix, right, rcond=None)[0]
    apart = np.full(len(records.runs), np.nan)
    apart[held] = found[:-1] / stiffness[held]
    return float(found[-1]), apart, float(np.abs(found[:-1] - found[-1] * before).max())
