"""Add one effect to a set."""

from __future__ import annotations

import numpy as np

from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, n_parameters, related, standing
from stepid.effects.base import Effect
from stepid.fitting.decimation import full_residual
from stepid.fitting.multistart import Scored, Start, race_starts
from stepid.fitting.score_test import columns, score
from stepid.fitting.spectrum import resonances

_MODE = 2  # own states that make an effect a mode, whose response is not in proportion to its mass


class Add:
    """Add each simple effect of the catalogue, by its score on the node's residual."""

    name = "add"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects and one more."""
        if len(node.effects) >= context.effort.effects:
            return []
        known = {e.name for e in context.catalogue}
        simple = tuple(e for e in context.catalogue if not known.intersection(e.contains))
        new = tuple(e for e in simple if not any(related(e, own) for own in node.effects))
        if not node.effects:
            return self._single(node, new, context)
        return self._further(node, new, context)

    def _single(self, node: Node, new: tuple[Effect, ...], context: SearchContext) -> list[Proposal]:
        fit = context.fit
        scored = score(fit, node.best, columns(fit, new))
        out = []
        for effect in new:
            own = [s for s in scored if s.effect is effect]
            starts = race_starts(fit, effect, own)
            left = node.cost - max((s.gain for s in own), default=0.0)
            out.append(Proposal((effect,), node.deviations, tuple(starts), node.key, node.best, left, 1.0, self.name))
        return out

    def _further(self, node: Node, new: tuple[Effect, ...], context: SearchContext) -> list[Proposal]:
        fit = context.fit
        # what rings in this node's residual may be hidden in the linear one
        left_over = full_residual(node.best, fit.linear, fit.coarse_linear)
        heard = fit.scales._replace(resonances=resonances(fit.records, left_over))
        ringing = tuple(e for e in new if e.starts(heard) != e.starts(fit.scales))
        quiet = tuple(e for e in new if e not in ringing)
        table = columns(fit, quiet, base=node.best) + columns(fit, ringing, heard, node.best)
        own: dict[str, list[Scored]] = {}
        for scored in score(fit, node.best, table):
            own.setdefault(scored.effect.name, []).append(scored)
        return [self._proposal(node, found, context) for found in own.values()]

    def _proposal(self, node: Node, found: list[Scored], context: SearchContext) -> Proposal:
        effort, effect = context.effort, found[0].effect
        here = standing(node)
        starts = []
        for scored in found[: effort.starts]:
            there = standing(node, scored.shared)
            starts.append(Start(there.linear, (*there.values, scored.values)))
        for scored in found[:1]:
            attenuated = effect.faint(scored.values, effort.attenuated)
            starts.append(Start(here.linear, (*here.values, attenuated)))
        if effect.n_extra >= _MODE:
            guesses = effect.starts(context.fit.scales)[-effort.starts :]
            starts += [Start(here.linear, (*here.values, tuple(guess))) for guess in guesses]
        left = max(node.cost - found[0].gain, 0.0)
        costly = effort.costly if any(e.contains for e in node.effects) else 1.0
        costly *= 1.0 + effort.price * (n_parameters((effect,)) - 1)
        effects = (*node.effects, effect)
        return Proposal(effects, node.deviations, tuple(starts), node.key, node.best, left, costly, self.name)


def inside(values: tuple[float, ...], effect: Effect) -> tuple[float, ...]:
    """Values within the effect's bounds."""
    low, high = (np.array([getattr(q, side) for q in effect.parameters]) for side in ("lower", "upper"))
    return tuple(float(v) for v in np.clip(values, low, high))
