"""Take one effect, or one condition that differs from run to run, away."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, standing
from stepid.fitting.absent import without
from stepid.fitting.deviations import starts_kept
from stepid.fitting.multistart import Start
from stepid.fitting.multistart_race import race_starts
from stepid.fitting.score_test import columns, score


class Drop:
    """Take each effect or condition of a set away: a smaller set can have been stuck where the larger one was not.

    An effect with which runs may begin off their rest, or in motion, is taken away without that freedom and with it:
    what the freedom does is no sign of the effect.
    """

    name = "drop"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects without one of them, and with one condition less that differs from run to run."""
        out = [proposal for place in range(len(node.effects)) for proposal in self._without(node, place, context)]
        for kind in sorted(node.deviations if node.size > 1 or len(node.deviations) > 1 else ()):  # less is the root
            left = node.cost  # what it gains is judged by the fit without it
            fewer = node.deviations - {kind}
            out.append(Proposal(node.effects, fewer, (standing(node),), node.key, node.best, left, 1.0, self.name))
        return out

    def _without(self, node: Node, place: int, context: SearchContext) -> Iterator[Proposal]:
        """Propose the node's effects without the one at a place, with the starts that it lets be free, and without."""
        rest = [i for i in range(len(node.effects)) if i != place]
        effects = tuple(node.effects[i] for i in rest)
        begun = starts_kept(node.best.problem, effects)
        if not (rest or begun):  # that is the root
            return
        of = node.best.problem.layout
        values = tuple(float(v) for v in node.best.shared[of.values[place]])
        moved, left = without(node.best, of.values[place], np.array(node.effects[place].faint(values, 0.0)))
        left = left if np.isfinite(left) else node.cost  # not to be foreseen: it may cost nothing
        starts = tuple(
            Start(shared[of.linear], tuple(tuple(map(float, shared[of.values[i]])) for i in rest))
            for shared in (moved, node.best.shared)
        )
        if begun - node.deviations:
            kept = node.deviations | begun
            yield Proposal(effects, kept, starts, node.key, node.best, left, 1.0, self.name)
        if not rest:
            return
        if len(effects) == 1:  # where what is taken away had taken mass or stiffness from the plant
            fit = context.fit
            starts += tuple(race_starts(fit, effects[0], score(fit.coarse_linear, columns(fit, effects))))
        yield Proposal(effects, node.deviations, starts, node.key, node.best, left, 1.0, self.name)
