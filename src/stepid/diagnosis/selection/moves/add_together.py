"""Add several effects to the linear plant at once."""

from __future__ import annotations

from dataclasses import dataclass

from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, n_parameters, related
from stepid.effects.base import Effect
from stepid.fitting.joint_score import ScoredSet, score_sets
from stepid.fitting.multistart import Start
from stepid.fitting.score_test import columns


@dataclass(frozen=True)
class AddTogether:
    """Add sets of effects of the catalogue, by their joint score: none of them may show without the others.

    Parameters
    ----------
    size : int
        Effects of a set.
    """

    size: int

    @property
    def name(self) -> str:
        """Name."""
        return f"add {self.size} together"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the sets, on the linear plant, of which each effect promises to take a share of what is left."""
        effort = context.effort
        if node.effects or effort.effects < self.size:
            return []
        table = columns(context.fit, context.catalogue)
        scored = score_sets(node.best, table, self.size, effort.starts, apart=lambda a, b: not related(a, b))
        found: dict[frozenset[str], list[ScoredSet]] = {}
        for one in scored:
            names = frozenset(e.name for e in one.effects)
            if names in found or one.left < (1 - effort.worth) * one.inner:
                found.setdefault(names, []).append(one)
        out = [self._proposal(node, sets, context) for sets in found.values()]
        return sorted(out, key=lambda p: p.left * p.costly)[: effort.width]

    def _proposal(self, node: Node, sets: list[ScoredSet], context: SearchContext) -> Proposal:
        effects = sets[0].effects
        starts = tuple(Start(s.shared, _in_order(s, effects)) for s in sets)
        costly = 1.0 + context.effort.price * (n_parameters(effects) - self.size)
        return Proposal(effects, node.deviations, starts, node.key, node.best, sets[0].left, costly, self.name)


def _in_order(scored: ScoredSet, effects: tuple[Effect, ...]) -> tuple[tuple[float, ...], ...]:
    return tuple(scored.values[scored.effects.index(e)] for e in effects)
