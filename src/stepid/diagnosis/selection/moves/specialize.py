"""Put a simpler effect in the place of one that contains it."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
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
            for inner in context.catalogue:
                level = level_within(effect, np.array(here.values[place]), inner)
                taken = any(inner.name == e.name for e in node.effects)
                if inner.name not in effect.contains or taken or level is None:
                    continue
                effects = (*node.effects[:place], inner, *node.effects[place + 1 :])
                values = (*here.values[:place], (level,), *here.values[place + 1 :])
                starts = (Start(here.linear, values),)
                out.append(Proposal(effects, node.deviations, starts, node.key, node.best, node.cost, 1.0, self.name))
        return out


def level_within(general: Effect, values: Array, simple: Effect) -> float | None:
    """Strength of a simple effect of one parameter inside a general one: the mean of those in its unit, if any."""
    if len(simple.parameters) > 1 or simple.run_parameters != general.run_parameters:
        return None
    unit = simple.parameters[0].unit
    alike = [v for v, q in zip(values, general.parameters, strict=True) if q.unit == unit]
    return float(np.mean(alike)) if alike else None
