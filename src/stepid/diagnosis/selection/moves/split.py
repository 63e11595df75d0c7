"""Put two simple effects in the place of a general one whose force is nearly theirs."""

from __future__ import annotations

from itertools import product

from stepid.diagnosis.selection.moves.likeness import ForceAlong
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, related
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
        found: dict[str, tuple[float, Proposal]] = {}
        others = [e for e in context.catalogue if not e.contains and not any(related(e, i) for i in inside)]
        for one, other in product(inside, [e for e in others if not e.dry]):
            for pair in product(one.regressors(scales, force.motion), other.regressors(scales, force.motion)):
                like, known = force.by(pair), found.get(other.name)
                if like is None or like.left >= context.effort.alike or (known is not None and like.left >= known[0]):
                    continue
                start, promise = Start(force.beside(like)[0], like.values), 0.5 * node.cost
                found[other.name] = (
                    like.left,
                    Proposal((one, other), node.deviations, (start,), node.key, node.best, promise, move=self.name),
                )
        best = sorted(found.values(), key=lambda item: item[0])[:2]
        return [proposal for _, proposal in best]
