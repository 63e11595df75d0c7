"""Let conditions differ beside an effect that was found in the place of one of them."""

from __future__ import annotations

from stepid.diagnosis.selection.candidate import Deviations
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, standing


class Remain:
    """Free again what runs may still differ by, once an effect takes most of it.

    Where it is free already a linearized step promises nothing of the effect. So the set starts from the effect.

    Parameters
    ----------
    conditions : frozenset of str
        Those of the best answer so far.
    """

    name = "remain"

    def __init__(self, conditions: Deviations) -> None:
        self._conditions = conditions

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with these conditions."""
        here = (standing(node),)  # what it gains is judged by the fit
        return [Proposal(node.effects, self._conditions, here, node.key, node.best, node.cost, 1.0, self.name)]
