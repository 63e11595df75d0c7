"""The structure of a plant with effects as the kernel takes it, if it has room for them."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from stepid.effects.base import Effect
from stepid.errors import InputError
from stepid.simulation import kernel
from stepid.simulation.compiled import JIT
from stepid.simulation.laws import changes, law


def structure(effects: tuple[Effect, ...]) -> Any:
    """A new array of one `kernel.WORK`: effects in the order of the drive's chain, where values and states stand."""
    room = _structure(effects)
    if JIT:  # as bytes: numpy copies a record field by field
        return np.frombuffer(bytearray(room.tobytes()), room.dtype)
    return room.copy()  # with fields as attributes: plain Python reads them, too


@lru_cache(maxsize=1024)
def _structure(effects: tuple[Effect, ...]) -> Any:
    room = np.zeros(1, np.dtype((np.record, kernel.WORK)))
    work = room[0]
    at, own, side = kernel.Q_FIRST, 2, 0
    places = []
    for e in effects:
        last = (changes(e, name) for name in ("relax", "delay", "reading", "kink"))
        places.append((at, own, side, e.n_extra, e.n_memory, e.n_switches, changes(e, "drive"), e.dry, *last))
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
    work.kinked = any(changes(e, "kink") for e in effects)
    work.rated = any(e.n_extra for e in effects)
    return room


def leaps(effects: tuple[Effect, ...]) -> int:
    """Whether steps can be exact, as `stepid.simulation.kernel.simulate` asks: 2 linear, 1 affine between events, 0 no.

    A force that changes where the velocity changes sign may have another slope there: exact steps hold on to the old.
    """
    if all(e.linear for e in effects):
        return 2
    turns = any(e.reverses and changes(e, "force") for e in effects)
    return int(not turns and all((e.linear or e.affine) and not e.n_extra for e in effects))


def check_size(effects: tuple[Effect, ...]) -> None:
    """Refuse more than the kernel has room for.

    Raises
    ------
    stepid.errors.InputError
    """
    states = 2 + sum(e.n_extra + e.n_memory for e in effects)
    values = kernel.Q_FIRST + sum(len(e.parameters) + len(e.run_parameters) for e in effects)
    for what, has, most in (
        ("effects", len(effects), kernel.MOST_EFFECTS),
        ("states", states, kernel.MOST_STATES),
        ("switches", sum(e.n_switches for e in effects), kernel.MOST_SWITCHES),
        ("values", values, kernel.MOST_VALUES),
    ):
        if has > most:
            raise InputError(f"{has} {what} are more than a simulation holds ({most})", "Use fewer effects at once.")
