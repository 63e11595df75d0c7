"""Put two simple effects in the place of a general one whose force is nearly theirs."""

from __future__ import annotations

from itertools import product

from stepid.diagnosis.selection.moves.likeness import ForceAlong, Likeness
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, related, standing
from stepid.effects.base import Effect
from stepid.fitting.multistart import Start

_Pair = tuple[Effect, Effect]


class Split:
    """Replace a general law by two simple ones, one of them inside it, whose force along its path is nearly its own."""

    name = "split"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with one that is general exchanged for pairs of simple ones."""
        if len(node.effects) >= context.effort.effects:
            return []
        out, here = [], standing(node).values
        for place, effect in enumerate(node.effects):
            if not effect.contains or effect.affine or effect.n_extra or effect.n_memory:
                continue  # a curved law of velocity or position may be two; others are seldom mistaken
            force = ForceAlong(node, place, context)
            alike = [
                (pair, like) for pair, like in _parts(node, place, force, context) if like.left < context.effort.alike
            ]
            for pair, like in sorted(alike, key=lambda found: found[1].left)[:2]:
                effects = (*node.effects[:place], *pair, *node.effects[place + 1 :])
                values = (*here[:place], *like.values, *here[place + 1 :])
                starts = (Start(force.beside(like)[0], values),)
                left = 0.5 * node.cost
                out.append(Proposal(effects, node.deviations, starts, node.key, node.best, left, move=self.name))
        return out


def _parts(node: Node, place: int, force: ForceAlong, context: SearchContext) -> list[tuple[_Pair, Likeness]]:
    """Pairs of a simple law inside the effect at a place and each other one, how near they come to its force."""
    effect, scales = node.effects[place], context.fit.scales
    kept = [e for e in node.effects if e is not effect]
    able = [e for e in context.catalogue if not any(related(e, other) for other in kept)]
    inside = [e for e in able if e.name in effect.contains]
    others = [e for e in able if not (e.contains or e.dry or any(related(e, i) for i in inside))]
    nearest: dict[str, tuple[_Pair, Likeness]] = {}
    for one, other in product(inside, others):
        pairs = product(one.regressors(scales, force.motion), other.regressors(scales, force.motion))
        for like in filter(None, map(force.by, pairs)):
            if other.name not in nearest or like.left < nearest[other.name][1].left:
                nearest[other.name] = (one, other), like
    return list(nearest.values())
