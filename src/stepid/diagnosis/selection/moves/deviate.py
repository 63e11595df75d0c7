"""Let one condition differ from run to run."""

from __future__ import annotations

from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, standing
from stepid.fitting.deviations import SCATTER, promised


class Deviate:
    """Free one condition in every run, or all: start time, gain, damping, friction."""

    name = "deviate"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with one more condition that differs from run to run."""
        out = []
        promises = promised(node.best, (kind for kind in SCATTER if kind not in node.deviations))
        every = {kind: promises[kind] for kind in SCATTER if kind in promises}
        for kind, found in every.items():
            left = max(node.cost - found.gain, 0.0)
            deviations = node.deviations | {kind}
            here = (standing(node),)
            costly = 1.0 + context.effort.price * int((found.values != 0).sum())
            out.append(Proposal(node.effects, deviations, here, node.key, node.best, left, costly, self.name))
        if len(every) > 1:  # each alone may show little; which of them are needed is seen from there
            left = max(node.cost - sum(found.gain for found in every.values()), 0.0)
            costly = 1.0 + context.effort.price * sum(int((found.values != 0).sum()) for found in every.values())
            deviations = node.deviations.union(every)
            out.append(
                Proposal(node.effects, deviations, (standing(node),), node.key, node.best, left, costly, self.name)
            )
        return out
