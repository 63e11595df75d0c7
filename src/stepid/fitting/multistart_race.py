"""Where one effect starts in the race, by its scores, the weak form and its own guesses."""

from __future__ import annotations

from collections.abc import Sequence

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.multistart import FitContext, Scored, Start
from stepid.fitting.multistart_held import held_starts


def _less_damped(context: FitContext, effect: Effect) -> list[Array]:
    """The linear optimum; for dry friction, also with less damping, which stood in for the friction."""
    out = [context.coarse_linear.shared]
    if effect.dry:
        damping = context.coarse_linear.problem.layout.damping
        for share in (0.65, 0.35):
            lighter = context.coarse_linear.shared.copy()
            lighter[damping] *= share
            out.append(lighter)
    return out


def race_starts(context: FitContext, effect: Effect, scored: Sequence[Scored]) -> list[Start]:
    """Starts of one effect: its best scores, the weak form's best, its own guesses where it is hard to score."""
    own = [s for s in scored if s.effect is effect][:2]
    starts = [Start(s.shared, (s.values,)) for s in own]
    starts += [Start(context.coarse_linear.shared, (s.values,)) for s in own[:1]]
    starts += context.weak_starts(effect, 3)
    if not effect.linear or len(starts) < 2:
        own_guesses = effect.starts(context.scales)
        starts += [Start(shared, (tuple(v),)) for shared in _less_damped(context, effect) for v in own_guesses]
    if own:
        starts.append(Start(context.coarse_linear.shared, (effect.faint(own[0].values, 0.05),)))
    starts += held_starts(context, effect)
    return starts
