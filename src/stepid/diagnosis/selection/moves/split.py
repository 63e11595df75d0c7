"""Put two simple effects in the place of a general one whose force is nearly theirs."""

from __future__ import annotations

from itertools import product

from stepid.diagnosis.selection.moves.likeness import ForceAlong, Likeness
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, related
from stepid.effects.base import Effect
from stepid.fitting.multistart import Start


class Split:
    """Replace a general law by two simple ones, one of them inside it, whose force along its path is nearly its own."""

    name = "split"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose pairs of simple effects for a general one that leads alone."""
        if len(node.effects) != 1 or context.effort.effects < 2:
            return []
        effect, scales = node.effects[0], context.fit.scales
        inside = [e for e in context.catalogue if e.name in effect.contains]
        if not inside or effect.affine or effect.n_extra or effect.n_memory:
            return []  # a curved law of velocity or position may be two; others are seldom mistaken
        force = ForceAlong(node, 0, context)
        others = [e for e in context.catalogue if not (e.contains or e.dry or any(related(e, i) for i in inside))]
        nearest: dict[str, tuple[Likeness, tuple[Effect, Effect]]] = {}
        for one, other in product(inside, others):
            pairs = product(one.regressors(scales, force.motion), other.regressors(scales, force.motion))
            for like in filter(None, map(force.by, pairs)):
                if other.name not in nearest or like.left < nearest[other.name][0].left:
                    nearest[other.name] = like, (one, other)
        alike = [found for found in nearest.values() if found[0].left < context.effort.alike]
        return [
            Proposal(
                pair,
                node.deviations,
                (Start(force.beside(like)[0], like.values),),
                node.key,
                node.best,
                0.5 * node.cost,
                move=self.name,
            )
            for like, pair in sorted(alike, key=lambda found: found[0].left)[:2]
        ]
