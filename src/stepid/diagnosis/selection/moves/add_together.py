"""Add several effects to the linear plant at once."""

from __future__ import annotations

from dataclasses import dataclass

from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, n_parameters, related
from stepid.effects.base import Effect
from stepid.fitting.equation_score import EquationOfMotion
from stepid.fitting.joint_score import JointScore, ScoredSet
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
        score = None if node.effects or effort.effects < self.size else self._score(node, context)
        if score is None:
            return []
        found: dict[frozenset[str], list[ScoredSet]] = {}
        for one in score.sets(self.size, effort.starts):
            names = frozenset(e.name for e in one.effects)
            if names in found or one.left < (1 - effort.worth) * one.inner:
                found.setdefault(names, []).append(one)
        order = sorted(found.values(), key=lambda sets: sets[0].left * self._costly(sets[0], context))
        return [self._proposal(node, sets, score, context) for sets in order[: effort.width]]

    def _score(self, node: Node, context: SearchContext) -> JointScore | None:
        """Scores of all sets, kept for sets of another size."""
        fit, every = context.fit, context.catalogue
        key = self.along, every
        if key not in fit.joint:
            beside = EquationOfMotion(fit) if self.along else Tangent(node.best)
            if not beside.directed or not beside.left.any():
                return None
            table = beside.columns(every) if isinstance(beside, EquationOfMotion) else columns(fit, every)
            fit.joint[key] = JointScore(beside, table, apart=lambda a, b: not related(a, b))
        kept: JointScore = fit.joint[key]
        return kept

    def _costly(self, scored: ScoredSet, context: SearchContext) -> float:
        return 1.0 + context.effort.price * (n_parameters(scored.effects) - self.size)

    def _proposal(self, node: Node, sets: list[ScoredSet], score: JointScore, context: SearchContext) -> Proposal:
        effects, left = sets[0].effects, min(sets[0].left, 1.0) * node.cost
        starts = tuple(Start(score.adapted(s), _in_order(s, effects)) for s in sets)
        costly = self._costly(sets[0], context)
        return Proposal(effects, node.deviations, starts, node.key, node.best, left, costly, self.name)


def _in_order(scored: ScoredSet, effects: tuple[Effect, ...]) -> tuple[tuple[float, ...], ...]:
    return tuple(scored.values[scored.effects.index(e)] for e in effects)
