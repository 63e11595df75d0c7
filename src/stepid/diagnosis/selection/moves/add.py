"""Add one effect to a set."""

from __future__ import annotations

from functools import partial

from stepid.diagnosis.selection.proposal import (
    Node,
    Postponed,
    Proposal,
    SearchContext,
    is_mode,
    n_parameters,
    overshadowed,
    related,
    standing,
)
from stepid.effects.base import Effect
from stepid.fitting.decimation import full_residual
from stepid.fitting.multistart import Scored, Start
from stepid.fitting.multistart_race import race_starts
from stepid.fitting.score_test import columns, score
from stepid.fitting.spectrum import resonances


class Add:
    """Add each effect of the catalogue, by its score on the node's residual; general ones in their own right only."""

    name = "add"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects and one more."""
        if len(node.effects) >= context.effort.effects:
            return []
        new = tuple(e for e in context.catalogue if not any(related(e, own) for own in node.effects))
        if not node.effects:
            return self._single(node, new, context)
        return self._further(node, new, context)

    def _single(self, node: Node, new: tuple[Effect, ...], context: SearchContext) -> list[Proposal]:
        fit = context.fit
        scored = score(node.best, columns(fit, new))
        found = {s.effect for s in scored} - _overshadowed(scored)
        out = []
        for effect in (e for e in new if e in found or not e.contains):
            own = [s for s in scored if s.effect is effect]
            starts = Postponed(partial(race_starts, fit, effect, own))
            left = node.cost - max((s.gain for s in own), default=0.0)
            out.append(Proposal((effect,), node.deviations, starts, node.key, node.best, left, 1.0, self.name))
        return out

    def _further(self, node: Node, new: tuple[Effect, ...], context: SearchContext) -> list[Proposal]:
        fit = context.fit
        # what rings in this node's residual may be hidden in the linear one
        left_over = full_residual(node.best, fit.linear, fit.coarse_linear)
        resonant = fit.scales._replace(resonances=resonances(fit.records, left_over))
        detected = tuple(e for e in new if e.starts(resonant) != e.starts(fit.scales))
        quiet = tuple(e for e in new if e not in detected)
        table = columns(fit, quiet, base=node.best) + columns(fit, detected, resonant, node.best)
        own: dict[str, list[Scored]] = {}
        scored = score(node.best, table)
        hidden = _overshadowed(scored)
        for one in scored:
            if one.effect not in hidden:
                own.setdefault(one.effect.name, []).append(one)
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
        if is_mode(effect):
            guesses = effect.starts(context.fit.scales)[-effort.starts :]
            starts += [Start(here.linear, (*here.values, tuple(guess))) for guess in guesses]
        left = max(node.cost - found[0].gain, 0.0)
        costly = effort.costly if any(e.contains for e in node.effects) else 1.0
        costly *= 1.0 + effort.price * (n_parameters((effect,)) - 1)
        effects = (*node.effects, effect)
        return Proposal(effects, node.deviations, tuple(starts), node.key, node.best, left, costly, self.name)


def _overshadowed(scored: list[Scored]) -> set[Effect]:
    hidden = overshadowed([((s.effect,), s.left) for s in scored])
    return {s.effect for s in scored if frozenset([s.effect.name]) in hidden}
