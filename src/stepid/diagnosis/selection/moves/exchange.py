"""Put another effect in the place of one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stepid.diagnosis.selection.candidate import Deviations
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, n_parameters, related
from stepid.fitting.absent import Absent
from stepid.fitting.deviations import SCATTER
from stepid.fitting.multistart import Start
from stepid.fitting.score_test import columns, score


class Exchange:
    """Replace each effect of a set by any other simple one, by its score on what the set leaves without that effect."""

    name = "exchange"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with one of them, or a condition that differs, exchanged for an effect."""
        out, of = [], node.best.problem.layout
        every = range(len(node.effects))
        for place, effect in enumerate(node.effects):
            values = np.array(effect.faint(tuple(float(v) for v in node.best.shared[of.values[place]]), 0.0))
            rest = [i for i in every if i != place]
            out += self._instead(node, Absent(of.values[place], values), rest, node.deviations, context)
            if effect.run_parameters:
                out.append(self._deviating(node, place))
        for kind in sorted(node.deviations) if len(node.effects) < context.effort.effects else ():
            out += self._instead(node, Absent(row=of.deviation(kind)), list(every), node.deviations - {kind}, context)
        return out

    def _deviating(self, node: Node, place: int) -> Proposal:
        """All conditions free in place of an effect that has a freedom of its own in every run: they may imitate it."""
        of = node.best.problem.layout
        rest = [i for i in range(len(node.effects)) if i != place]
        start = Start(
            node.best.shared[of.linear], tuple(tuple(map(float, node.best.shared[of.values[i]])) for i in rest)
        )
        effects = tuple(node.effects[i] for i in rest)
        return Proposal(effects, frozenset(SCATTER), (start,), node.key, node.best, node.cost, 1.0, self.name)

    def _instead(
        self, node: Node, absent: Absent, rest: list[int], deviations: Deviations, context: SearchContext
    ) -> list[Proposal]:
        fit, effort, of = context.fit, context.effort, node.best.problem.layout
        every = {e.name for e in context.catalogue}
        new = tuple(
            e
            for e in context.catalogue
            if not every.intersection(e.contains) and not any(related(e, own) for own in node.effects)
        )
        out: dict[str, Proposal] = {}
        for scored in score(node.best, columns(fit, new), instead=absent):
            name = scored.effect.name
            starts = tuple(
                Start(s[of.linear], (*(tuple(map(float, s[of.values[i]])) for i in rest), scored.values))
                for s in (scored.shared, node.best.shared)
            )
            if name in out:
                known = tuple(out[name].starts)
                if len(known) < 2 * effort.starts:
                    out[name] = replace(out[name], starts=(*known, *starts))
                continue
            effects = (*(node.effects[i] for i in rest), scored.effect)
            costly = 1.0 + effort.price * (n_parameters((scored.effect,)) - 1)
            out[name] = Proposal(effects, deviations, starts, node.key, node.best, scored.left, costly, self.name)
        return list(out.values())
