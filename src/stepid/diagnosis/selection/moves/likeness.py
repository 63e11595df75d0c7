"""Which effects are alike: laws whose forces along a motion are nearly the same beside what a linear fit follows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.selection.proposal import Node, SearchContext, standing
from stepid.effects.base import Effect, Motion, Regressor
from stepid.effects.drive import acts_on_input
from stepid.fitting.weak_form import force_along, motion_along


class Likeness(NamedTuple):
    """What effects in the place of one leave of its force: as a share, and as a force [N]; and their values."""

    left: float
    values: tuple[tuple[float, ...], ...]
    rest: Array


class ForceAlong:
    """The force of one effect of a node along its motion, where the cart moves.

    Parameters
    ----------
    node : Node
    place : int
        Of the effect among the node's.
    context : SearchContext
    """

    def __init__(self, node: Node, place: int, context: SearchContext) -> None:
        self._layout, here, self._scales = node.best.problem.layout, standing(node), context.fit.scales
        self._linear, self._displacement = here.linear, node.best.local[0]
        records = node.best.problem.records
        self._spring = records.spring
        self.motion: Motion = motion_along(records, here.linear, *node.best.solved.states[:2])
        self._seen = np.abs(self.motion.v) > context.effort.attenuated * np.abs(self.motion.v).max()
        self._force = force_along(node.effects[place], here.values[place], self.motion)[self._seen]
        self._plain = np.column_stack([self.motion.x, self.motion.v])[self._seen]
        # what a fit follows without any effect: a rest position for each run and the gain, too
        rests = records.run[:, None] == np.arange(len(records.runs))
        self._followed = np.column_stack([self._plain, self.motion.volts[self._seen], rests[self._seen]])
        self._follows = np.linalg.qr(self._followed[:, self._followed.any(axis=0)])[0]
        # of a force that rest positions stand in for nothing but rounding is left
        faint = np.sqrt(np.finfo(float).eps) * float(self._force @ self._force)
        beyond = self._power_beyond(self._force)
        self._beyond = max(beyond, faint, np.finfo(float).tiny)
        self._beside_effects = self._followed if beyond > faint else self._plain

    def _power_beyond(self, force: Array) -> float:
        """Power of the part of a force that a fit without effects cannot follow, N²."""
        beyond = force - self._follows @ (self._follows.T @ force)
        return float(beyond @ beyond)

    def strength(self, one: Regressor) -> float | None:
        """First parameter of an effect of one force that comes nearest to this one, None where it cannot have it."""
        force = one.forces[0][self._seen]
        size = float(force @ force)
        values = one.values(np.array([float(force @ self._force) / size])) if size > 0 else None
        return None if values is None else values[0]

    def by(self, regressors: Sequence[Regressor]) -> Likeness | None:
        """What some effects can do in its place; None where a law cannot have such a strength, or is linear there.

        A damper of one way is the damper where all runs move that way.
        """
        own = np.column_stack([f[self._seen] for one in regressors for f in one.forces])
        bent = own - self._plain @ _least_squares(self._plain, own)
        if np.any(np.sum(bent**2, axis=0) <= np.sqrt(np.finfo(float).eps) * np.sum(own**2, axis=0)):
            return None
        plain = self._beside_effects.shape[1]
        found = _least_squares(np.column_stack([self._beside_effects, own]), self._force)
        left = self._force - own @ found[plain:]
        out, at = [], plain
        for one in regressors:
            values = one.values(found[at : at + len(one.forces)])
            if values is None:
                return None
            out.append(values)
            at += len(one.forces)
        return Likeness(self._power_beyond(left) / self._beyond, tuple(out), left)

    def nearest(self, effect: Effect) -> list[Likeness]:
        """What one effect can do in its place, from each of its regressors, the nearest first."""
        found = (self.by((one,)) for one in effect.regressors(self._scales, self.motion))
        return sorted(filter(None, found), key=lambda like: like.left)

    def beside(self, like: Likeness) -> tuple[Array, Array]:
        """The linear plant and how far from the spring's rest position [m] each run starts beside effects in its place.

        They stand in for what these leave of the force.
        """
        spring, damper, drive, *rests = _least_squares(self._followed, like.rest)
        linear = self._linear.copy()
        linear[self._layout.stiffness] -= spring
        linear[self._layout.damping] -= damper
        linear[self._layout.force_gain] += drive
        stiffness = linear[self._layout.stiffness][self._spring]
        pushed = np.divide(rests, stiffness, out=np.zeros_like(stiffness), where=stiffness > 0)
        return linear, self._displacement - pushed


def _least_squares(forces: Array, sought: Array) -> Array:
    """Coefficients of forces, one a column, that come nearest to others; none of what rounding decides."""
    size = np.linalg.norm(forces, axis=0)
    size[size == 0] = np.inf
    scaled = np.linalg.lstsq(forces / size, sought, rcond=np.sqrt(np.finfo(float).eps))[0]
    out: Array = (scaled.T / size).T
    return out


def is_force(effect: Effect) -> bool:
    """Tell whether an effect is a force that position, velocity and time tell, the same in every run."""
    outside = acts_on_input(effect) or type(effect).reading is not Effect.reading
    return not (outside or effect.n_extra or effect.n_memory or effect.run_parameters)
