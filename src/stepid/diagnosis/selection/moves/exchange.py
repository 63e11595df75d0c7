"""Put another effect in the place of one."""

from __future__ import annotations

import numpy as np

from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, n_parameters, related
from stepid.fitting.deviations import SCATTER
from stepid.fitting.multistart import Start
from stepid.fitting.score_test import columns, score, without


class Exchange:
    """Replace each effect of a set by any other simple one, by its score on what the set leaves without that effect."""

    name = "exchange"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects with one of them exchanged."""
        out = []
        for place in range(len(node.effects)):
            out += self._instead(node, place, context)
            if node.effects[place].run_parameters:
                out.append(self._deviating(node, place))
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

    def _instead(self, node: Node, place: int, context: SearchContext) -> list[Proposal]:
        fit, effort, effect = context.fit, context.effort, node.effects[place]
        rest = [i for i in range(len(node.effects)) if i != place]
        known = {e.name for e in context.catalogue}
        new = tuple(
            e
            for e in context.catalogue
            if not known.intersection(e.contains) and not any(related(e, own) for own in node.effects)
        )
        of = node.best.problem.layout
        own = of.values[place]
        values = np.array(effect.faint(tuple(float(v) for v in node.best.shared[own]), 0.0))
        moved, _ = without(node.best, own, values)
        out: dict[str, Proposal] = {}
        for scored in score(fit, node.best, columns(fit, new), instead=(own, values)):
            name = scored.effect.name
            shared = [np.array(moved), scored.shared]
            starts = [
                Start(s[of.linear], (*(tuple(map(float, s[of.values[i]])) for i in rest), scored.values))
                for s in shared
            ]
            if name in out:
                old = out[name]
                if len(old.starts) < 2 * effort.starts:
                    out[name] = _with_starts(old, (*old.starts, *starts[1:]))
                continue
            left = scored.left
            effects = (*(node.effects[i] for i in rest), scored.effect)
            costly = 1.0 + effort.price * (n_parameters((scored.effect,)) - 1)
            from_here = tuple(starts[::-1])
            out[name] = Proposal(effects, node.deviations, from_here, node.key, node.best, left, costly, self.name)
        return list(out.values())


def _with_starts(old: Proposal, starts: tuple[Start, ...]) -> Proposal:
    return Proposal(old.effects, old.deviations, starts, old.base, old.like, old.left, old.costly, old.move)
