"""The structure of a plant with effects as the kernel takes it."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from stepid.effects.base import Effect
from stepid.simulation import kernel
from stepid.simulation.laws import changes, law


def structure(effects: tuple[Effect, ...]) -> Any:
    """A new record of `kernel.WORK`: the effects in the order of the drive's chain, where values and states stand."""
    return _structure(effects).copy()[0]


@lru_cache(maxsize=1024)
def _structure(effects: tuple[Effect, ...]) -> Any:
    room = np.rec.array(np.zeros(1, kernel.WORK))
    work = room[0]
    at, own, side = kernel.Q_FIRST, 2, 0
    places = []
    for e in effects:
        does = (changes(e, "drive"), e.dry, changes(e, "relax"), changes(e, "delay"), changes(e, "reading"))
        places.append((at, own, side, e.n_extra, e.n_memory, e.n_switches, *does))
        at += len(e.parameters) + len(e.run_parameters)
        own, side = own + e.n_extra + e.n_memory, side + e.n_switches
    order = sorted(range(len(effects)), key=lambda i: effects[i].drive_order)
    work.effects, work.states, work.switches = len(effects), own, side
    for row, i in enumerate(order):
        work.laws[row] = law(effects[i])
        work.places[row] = places[i]
    work.reverses = any(e.reverses or e.n_switches for e in effects)
    work.dry = any(e.dry for e in effects)
    work.known = any(changes(e, "relax") or e.n_memory for e in effects)
    work.relaxing = max((row + 1 for row, i in enumerate(order) if changes(effects[i], "relax")), default=0)
    work.rated = any(e.n_extra for e in effects)
    work.restless = any(e.never_rests for e in effects)
    return room
