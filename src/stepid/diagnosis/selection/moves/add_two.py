"""Add two effects to the linear plant at once."""

from __future__ import annotations

from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, n_parameters, overshadowed, related
from stepid.effects.base import Effect
from stepid.fitting.joint_score import ScoredPair, score_pairs
from stepid.fitting.multistart import Start
from stepid.fitting.score_test import columns


class AddTwo:
    """Add each pair of effects of the catalogue, by their joint score: neither may show without the other."""

    name = "add two"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the pairs, on the linear plant."""
        if node.effects or context.effort.effects < 2:
            return []
        table = columns(context.fit, context.catalogue)
        scored = score_pairs(node.best, table, 2 * context.effort.starts, apart=lambda a, b: not related(a, b))
        found: dict[tuple[Effect, Effect], list[ScoredPair]] = {}
        hidden = overshadowed([(pair.effects, pair.left) for pair in scored])
        for pair in (p for p in scored if frozenset(e.name for e in p.effects) not in hidden):
            found.setdefault(pair.effects, []).append(pair)
        return [self._proposal(node, effects, pairs, context) for effects, pairs in found.items()]

    def _proposal(
        self, node: Node, effects: tuple[Effect, Effect], pairs: list[ScoredPair], context: SearchContext
    ) -> Proposal:
        starts = tuple(Start(p.shared, p.values) for p in pairs)
        costly = 1.0 + context.effort.price * (n_parameters(effects) - 2)
        return Proposal(effects, node.deviations, starts, node.key, node.best, pairs[0].left, costly, self.name)
