"""The states that effects are laws of."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Motion
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.weak_form import force_along

_SEEN = 200  # samples of the motion that tell what a force depends on
_ENDS = 20  # further ones at each end of the motion, where a stop is


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
    motion = _some(context.motion, _ENDS)
    zero, one = np.zeros(motion.x.size), np.ones(motion.x.size)

    def alike(**changed: Array) -> bool:
        return np.array_equal(force, force_along(effect, values, motion._replace(**changed)))

    force = force_along(effect, values, motion)
    if not alike(time=zero, volts=zero):
        return frozenset()
    free = {"position": alike(x=zero), "velocity": alike(v=zero, sign=one)}
    return frozenset(state for state, without in free.items() if not without)


def cancelling(context: FitContext, optimum: Optimum, states: tuple[frozenset[str], ...]) -> str:
    """The state of two effects of a fit that cancel more than half of each other, '' where there are none.

    What a linear plant follows is no part of either. `states` are `states_of_all` its effects.
    """
    layout, motion = optimum.problem.layout, _some(context.motion)
    plain = np.linalg.qr(np.column_stack([np.ones_like(motion.x), motion.x, motion.v]))[0]
    forces: list[tuple[str, Array]] = []
    for effect, place, of in zip(layout.effects, layout.values, states, strict=True):
        if len(of) == 1:
            force = force_along(effect, tuple(map(float, optimum.shared[place])), motion)
            forces.append((next(iter(of)), force - plain @ (plain.T @ force)))
    for (state, one), (other_state, other) in combinations(forces, 2):
        smaller = min(np.linalg.norm(one), np.linalg.norm(other))
        if state == other_state and np.linalg.norm(one + other) < smaller / 2:
            return state
    return ""


def patchwork(context: FitContext, optimum: Optimum, states: tuple[frozenset[str], ...]) -> str:
    """The state of which effects of a fit together follow a law of any shape, '' where there is none.

    All of more than two are laws of it, or two cancel more than half of each other. `states` are `states_of_all`.
    """
    if len(states) < 2:
        return ""
    shared = states[0] if len(states) > 2 and len(set(states)) == 1 else frozenset()
    return next(iter(shared)) if len(shared) == 1 else cancelling(context, optimum, states)


def _some(motion: Motion, ends: int = 0) -> Motion:
    """Samples all along a motion, and so many more at each end of position and velocity."""
    orders = [np.argsort(values) for values in (motion.x, motion.v)] if ends else []
    far = [order[k] for order in orders for k in (slice(ends), slice(-ends, None))]
    some = np.unique(np.concatenate([np.linspace(0, motion.x.size - 1, _SEEN).astype(np.intp), *far]))
    return Motion(*(field[some] for field in motion))


def states_of_all(context: FitContext, optimum: Optimum) -> tuple[frozenset[str], ...]:
    """`states_of` each effect of a fit."""
    layout = optimum.problem.layout
    values = (tuple(float(v) for v in optimum.shared[place]) for place in layout.values)
    return tuple(states_of(context, e, v) for e, v in zip(layout.effects, values, strict=True))
