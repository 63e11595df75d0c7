"""Put a simpler effect in the place of one that contains it."""

from __future__ import annotations

import numpy as np

from stepid.diagnosis.selection.moves.likeness import ForceAlong, is_force
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, standing
from stepid.effects.base import Effect
from stepid.fitting.multistart import Start


class Specialize:
    """Replace an effect by a simpler one inside it: the simpler one may have been stuck on its own."""

    name = "specialize"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with one of them simpler."""
        out = []
        for place, effect in enumerate(node.effects):
            for inner in context.catalogue:
                if inner.name not in effect.contains or any(inner.name == e.name for e in node.effects):
                    continue
                starts = _starts(node, place, inner, context)
                if not starts:
                    continue
                effects = (*node.effects[:place], inner, *node.effects[place + 1 :])
                out.append(Proposal(effects, node.deviations, starts, node.key, node.best, node.cost, 1.0, self.name))
        return out


def _starts(node: Node, place: int, simple: Effect, context: SearchContext) -> tuple[Start, ...]:
    """From where the node stands, and from a plant and rest positions that follow what the simple effect does not."""
    level, here = level_within(node, place, simple, context), standing(node)
    if level is None:
        return ()
    before, after = here.values[:place], here.values[place + 1 :]
    out = [Start(here.linear, (*before, (level,), *after))]
    if is_force(node.effects[place]):
        force = ForceAlong(node, place, context)
        found = (force.by((one,)) for one in simple.regressors(context.fit.scales, force.motion))
        like = min(filter(None, found), key=lambda one: one.left, default=None)
        if like is not None:
            linear, displacement = force.beside(like)
            out.append(Start(linear, (*before, *like.values, *after), displacement))
    return tuple(out)


def level_within(node: Node, place: int, simple: Effect, context: SearchContext) -> float | None:
    """Strength of a simple effect of one parameter inside a general one of a node, None where it has no such strength.

    That with which it comes nearest to the general one's force along the motion; of a law with a memory the mean of the
    parameters in its unit. Where the general one has none in its unit (a power of the speed), their forces have to be
    nearly the same.
    """
    general, values = node.effects[place], standing(node).values[place]
    if len(simple.parameters) > 1 or simple.run_parameters != general.run_parameters:
        return None
    unit = simple.parameters[0].unit
    same = [v for v, q in zip(values, general.parameters, strict=True) if q.unit == unit]
    near: list[float | None] = []
    if is_force(general):
        force = ForceAlong(node, place, context)
        inside = simple.regressors(context.fit.scales, force.motion)
        found = (force.by((one,)) for one in inside)
        if same or any(like.left < context.effort.alike for like in found if like):
            near = [force.strength(one) for one in inside]
    mean = float(np.mean(same)) if same else None
    return next((level for level in near if level is not None), mean)
