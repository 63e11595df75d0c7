"""Add several effects to the linear plant at once."""

from __future__ import annotations

from dataclasses import dataclass

from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, n_parameters, related
from stepid.effects.base import Effect
from stepid.fitting.equation_score import EquationOfMotion
from stepid.fitting.joint_score import ScoredSet, score_sets
from stepid.fitting.multistart import Start
from stepid.fitting.score_test import columns
from stepid.fitting.tangent import Tangent


@dataclass(frozen=True)
class AddTogether:
    """Add sets of effects of the catalogue, by their joint score: none of them may show without the others.

    Parameters
    ----------
    size : int
        Effects of a set.
    along : bool
        Whether they are scored along the measured motion, by its equation, or on the response of the linear plant.
    """

    size: int
    along: bool = False

    @property
    def name(self) -> str:
        """Name."""
        return f"add {self.size} together" + " along the motion" * self.along

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the sets, on the linear plant, of which each effect promises to take a share of what is left."""
        effort = context.effort
        if node.effects or effort.effects < self.size:
            return []
        found: dict[frozenset[str], list[ScoredSet]] = {}
        for one in self._scored(node, context):
            names = frozenset(e.name for e in one.effects)
            if names in found or one.left < (1 - effort.worth) * one.inner:
                found.setdefault(names, []).append(one)
        out = [self._proposal(node, sets, context) for sets in found.values()]
        return sorted(out, key=lambda p: p.left * p.costly)[: effort.width]

    def _scored(self, node: Node, context: SearchContext) -> list[ScoredSet]:
        beside = EquationOfMotion(context.fit) if self.along else Tangent(node.best)
        if not beside.directed:
            return []
        every = context.catalogue
        table = beside.columns(every) if isinstance(beside, EquationOfMotion) else columns(context.fit, every)
        return score_sets(beside, table, self.size, context.effort.starts, apart=lambda a, b: not related(a, b))

    def _proposal(self, node: Node, sets: list[ScoredSet], context: SearchContext) -> Proposal:
        effects, left = sets[0].effects, min(sets[0].left, 1.0) * node.cost
        starts = tuple(Start(s.shared, _in_order(s, effects)) for s in sets)
        costly = 1.0 + context.effort.price * (n_parameters(effects) - self.size)
        return Proposal(effects, node.deviations, starts, node.key, node.best, left, costly, self.name)


def _in_order(scored: ScoredSet, effects: tuple[Effect, ...]) -> tuple[tuple[float, ...], ...]:
    return tuple(scored.values[scored.effects.index(e)] for e in effects)
