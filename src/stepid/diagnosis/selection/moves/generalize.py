"""Put a more general effect in the place of one that it contains."""

from __future__ import annotations

from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, n_parameters, standing
from stepid.effects.base import Effect
from stepid.fitting.multistart import Start
from stepid.fitting.score_test import promises


class Generalize:
    """Replace an effect by one that contains it, from where the simpler one stands."""

    name = "generalize"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with one of them more general."""
        here, out = standing(node), []
        for place, effect in enumerate(node.effects):
            for general in context.catalogue:
                if effect.name in general.contains and all(general.name != e.name for e in node.effects):
                    out += grown_from(node, place, here.values[place], general, context, self.name)
        return out


def grown_from(
    node: Node, place: int, inner: tuple[float, ...], general: Effect, context: SearchContext, move: str
) -> list[Proposal]:
    """Propose a node's effects with the one at a place exchanged for a general one, grown from a simpler law in it.

    Parameters
    ----------
    node : Node
    place : int
        Of the effect that is exchanged.
    inner : tuple of float
        Parameters of the simpler law.
    general : Effect
    context : SearchContext
    move : str
        Name of the move.
    """
    fit, here = context.fit, standing(node)
    grown = [tuple(v) for v in general.grow(inner, fit.scales) or general.starts(fit.scales)]
    effects = (*node.effects[:place], general, *node.effects[place + 1 :])
    starts = [Start(here.linear, (*here.values[:place], v, *here.values[place + 1 :])) for v in grown]
    if len(effects) == 1:  # alone it may take the damper's part, too, or a spring's
        starts += fit.weak_starts(general, context.effort.starts)
    gains = promises(fit, node.best, effects, starts)
    order = sorted(range(len(starts)), key=lambda i: -gains[i])
    if not order:
        return []
    left = max(node.cost - gains[order[0]], 0.0)
    costly = 1.0 + context.effort.price * (n_parameters((general,)) - 1)
    kept = tuple(starts[i] for i in order)
    return [Proposal(effects, node.deviations, kept, node.key, node.best, left, costly, move)]
