"""Put an effect whose force is nearly the same in the place of one."""

from __future__ import annotations

from stepid.diagnosis.selection.moves.likeness import ForceAlong, is_force
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, related, standing
from stepid.fitting.multistart import Start


class Resemble:
    """Replace each effect of a set by simple ones whose force along its motion is nearly its own.

    A spring that softens with the cube may be a sine. Far from linear no response of the linear
    plant tells it.
    """

    name = "resemble"

    def most(self, context: SearchContext) -> float:
        """Share of the force that one in its place may leave."""
        return context.effort.alike

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with one of them exchanged for one that is like it, the nearest first."""
        out, here = [], standing(node)
        new = [e for e in context.catalogue if not e.contains and not any(related(e, own) for own in node.effects)]
        for place, effect in enumerate(node.effects):
            if not is_force(effect):
                continue
            force = ForceAlong(node, place, context)
            rest = [i for i in range(len(node.effects)) if i != place]
            kept = tuple(here.values[i] for i in rest)
            for other in new:
                found = [force.by((one,)) for one in other.regressors(context.fit.scales, force.motion)]
                near = sorted((f for f in found if f and f.left < self.most(context)), key=lambda f: f.left)
                if not near:
                    continue
                plants = ((f.values, *force.beside(f)) for f in near[: context.effort.starts])
                starts = tuple(Start(linear, (*kept, *values), apart) for values, linear, apart in plants)
                effects = (*(node.effects[i] for i in rest), other)
                proposal = Proposal(effects, node.deviations, starts, node.key, node.best, node.cost, move=self.name)
                out.append((near[0].left, proposal))
        return [proposal for _, proposal in sorted(out, key=lambda item: item[0])]
