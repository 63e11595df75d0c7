"""Put an effect whose force is nearly the same in the place of one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stepid.diagnosis.selection.moves.likeness import ForceAlong, is_force
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, related, standing
from stepid.effects.base import Effect
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
        new = [e for e in context.catalogue if not e.contains and not any(related(e, own) for own in node.effects)]
        forces = [place for place, effect in enumerate(node.effects) if is_force(effect)]
        found = [each for place in forces for each in self._in_place(node, place, new, context)]
        return [proposal for _, proposal in sorted(found, key=lambda item: item[0])]

    def _in_place(
        self, node: Node, place: int, new: Sequence[Effect], context: SearchContext
    ) -> Iterator[tuple[float, Proposal]]:
        """Effects that are like one of the node's, each with the share of its force that they leave."""
        force, here = ForceAlong(node, place, context), standing(node)
        rest = [i for i in range(len(node.effects)) if i != place]
        kept = tuple(here.values[i] for i in rest)
        for other in new:
            near = [f for f in force.nearest(other) if f.left < self.most(context)]
            if near:
                plants = ((f.values, *force.beside(f)) for f in near[: context.effort.starts])
                starts = tuple(Start(linear, (*kept, *values), apart) for values, linear, apart in plants)
                effects = (*(node.effects[i] for i in rest), other)
                yield (
                    near[0].left,
                    Proposal(effects, node.deviations, starts, node.key, node.best, node.cost, move=self.name),
                )
