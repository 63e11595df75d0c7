"""The states that effects are laws of."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Motion
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.weak_form import force_along

_SEEN = 200  # samples of the motion that tell what a force depends on


def states_of(context: FitContext, effect: Effect, values: tuple[float, ...]) -> frozenset[str]:
    """The states that an effect's force is a law of, 'position' and 'velocity'; none where time or memory is in it.

    An effect of no strength has none: its force depends on nothing.

    Parameters
    ----------
    context : FitContext
    effect : Effect
    values : tuple of float
        Of its parameters.
    """
    if effect.n_extra or effect.n_memory or effect.run_parameters:
        return frozenset()
    some = np.linspace(0, context.motion.x.size - 1, _SEEN).astype(np.intp)
    motion = Motion(*(field[some] for field in context.motion))
    zero, one = np.zeros(_SEEN), np.ones(_SEEN)

    def alike(**changed: Array) -> bool:
        return np.array_equal(force, force_along(effect, values, motion._replace(**changed)))

    force = force_along(effect, values, motion)
    if not alike(time=zero, volts=zero):
        return frozenset()
    free = {"position": alike(x=zero), "velocity": alike(v=zero, sign=one)}
    return frozenset(state for state, without in free.items() if not without)


def states_of_all(context: FitContext, optimum: Optimum) -> tuple[frozenset[str], ...]:
    """`states_of` each effect of a fit."""
    layout = optimum.problem.layout
    values = (tuple(float(v) for v in optimum.shared[place]) for place in layout.values)
    return tuple(states_of(context, e, v) for e, v in zip(layout.effects, values, strict=True))
