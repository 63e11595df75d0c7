"""Put a simpler effect in the place of one that contains it."""

from __future__ import annotations

import numpy as np

from stepid.diagnosis.selection.moves.likeness import ForceAlong, Likeness, is_force
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, standing
from stepid.effects.base import Effect
from stepid.fitting.multistart import Start


class Specialize:
    """Replace an effect by a simpler one inside it: the simpler one may have been stuck on its own."""

    name = "specialize"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with one of them simpler."""
        here, out = standing(node), []
        for place, effect in enumerate(node.effects):
            before, after = here.values[:place], here.values[place + 1 :]
            for inner in context.catalogue:
                if inner.name not in effect.contains or any(inner.name == e.name for e in node.effects):
                    continue
                level, force, near = _within(node, place, inner, context)
                if level is None:
                    continue
                starts = [Start(here.linear, (*before, (level,), *after))]
                if force is not None and near:  # a plant and rest positions that follow what the simple one does not
                    linear, displacement = force.beside(near[0])
                    starts.append(Start(linear, (*before, *near[0].values, *after), displacement))
                effects = (*node.effects[:place], inner, *node.effects[place + 1 :])
                out.append(
                    Proposal(effects, node.deviations, tuple(starts), node.key, node.best, node.cost, 1.0, self.name)
                )
        return out


def level_within(node: Node, place: int, simple: Effect, context: SearchContext) -> float | None:
    """Strength of a simple effect of one parameter inside a general one of a node, None where it has no such strength.

    That with which it comes nearest to the general one's force along the motion; of a law with a memory the mean of the
    parameters in its unit. Where the general one has none in its unit (a power of the speed), their forces have to be
    nearly the same.
    """
    return _within(node, place, simple, context)[0]


def _within(
    node: Node, place: int, simple: Effect, context: SearchContext
) -> tuple[float | None, ForceAlong | None, list[Likeness]]:
    """`level_within`, the general effect's force and what the simple one does in its place, the nearest first."""
    general, values = node.effects[place], standing(node).values[place]
    if len(simple.parameters) > 1 or simple.run_parameters != general.run_parameters:
        return None, None, []
    unit = simple.parameters[0].unit
    same = [v for v, q in zip(values, general.parameters, strict=True) if q.unit == unit]
    mean = float(np.mean(same)) if same else None
    if not is_force(general):
        return mean, None, []
    force = ForceAlong(node, place, context)
    near = force.nearest(simple)
    levels: list[float | None] = []
    if same or (near and near[0].left < context.effort.alike):
        levels = [force.strength(one) for one in simple.regressors(context.fit.scales, force.motion)]
    return next((level for level in levels if level is not None), mean), force, near
