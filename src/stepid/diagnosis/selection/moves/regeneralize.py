"""Put another general law in the place of one that contains the same simpler law."""

from __future__ import annotations

from stepid.diagnosis.selection.moves.generalize import grown_from
from stepid.diagnosis.selection.moves.specialize import level_within
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext


class Regeneralize:
    """Replace a general effect by another of the same kin, from the simpler law that both contain.

    Neither is inside the other, and the simpler law alone may promise too little to be a step on the way.
    """

    name = "regeneralize"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with a general one exchanged for each other that shares a simpler law with it."""
        out: list[Proposal] = []
        names = {e.name for e in node.effects}
        for place, effect in enumerate(node.effects):
            inside = [e for e in context.catalogue if e.name in effect.contains]
            levels = {e.name: level_within(node, place, e, context) for e in inside}
            for general in context.catalogue:
                known = [level for name, level in levels.items() if level is not None and name in general.contains]
                if known and general.name not in names:
                    out += grown_from(node, place, (known[0],), general, context, self.name)
        return out
