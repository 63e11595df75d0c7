"""Fits of given effects: one after another, each from its best starts on top of those before."""

from __future__ import annotations

from stepid.effects.base import Effect
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext, Start
from stepid.fitting.multistart_cogging import well_starts
from stepid.fitting.multistart_race import race_starts
from stepid.fitting.score_test import columns, score

_NOISY = 0.05  # of the cost of noise, within which a start need not be bettered
_AGREE = 3  # starts that end at the same cost, for it to be taken as the least
_SAME = 1e-3  # relative difference of costs that are the same


def fit_effects(context: FitContext, effects: tuple[Effect, ...]) -> Optimum | None:
    """Fit effects one after another, each from its best starts on top of those before, then all together.

    Where that leaves more than noise, in other orders, too: which comes first decides where its fellows begin.
    """
    if not effects:
        return context.linear
    best: CandidateFit | None = None
    for first in range(len(effects)):
        found = _one_after_another(context, effects[first:] + effects[:first])
        if found is not None and first:
            found = _reordered(found, effects)
        if found is not None and (best is None or found.cost < best.cost):
            best = found
        if best is not None and best.cost <= context.noise_limit:
            break
    if best is None:
        return None
    best.polish(iterations=40)
    return best.polished


def _one_after_another(context: FitContext, effects: tuple[Effect, ...]) -> CandidateFit | None:
    """Fit effects in this order; None where one of them has no stable fit."""
    starts = well_starts(context, effects[0])
    starts += race_starts(context, effects[0], score(context.coarse_linear, columns(context, effects[:1])))
    fitted = _raced(context, effects[:1], starts, context.coarse_linear)
    for count in range(2, len(effects) + 1):
        if fitted.best is None:
            return None
        n = fitted.best.problem.layout.linear.stop
        scored = score(fitted.best, columns(context, (effects[count - 1],)))
        guesses = [s.values for s in scored[:3]]
        guesses += [tuple(v) for v in effects[count - 1].starts(context.scales)]
        guesses.append(effects[count - 1].faint(guesses[0], 0.0))  # with it they leave no more than without
        linear, values = fitted.best.shared[:n], fitted.best.shared[n:]
        starts = [Start(linear, (tuple(values), v)) for v in guesses]
        fitted = _raced(context, effects[:count], starts, fitted.best)
    return None if fitted.best is None else fitted


def _reordered(found: CandidateFit, effects: tuple[Effect, ...]) -> CandidateFit:
    """The same fit with its effects in this order."""
    assert found.best is not None
    shared, of = found.best.shared, found.best.problem.layout
    own = {e.name: tuple(map(float, shared[place])) for e, place in zip(found.effects, of.values, strict=True)}
    out = CandidateFit(found.context, effects)
    start = Start(shared[: of.linear.stop], tuple(own[e.name] for e in effects))
    out.begin([start], like=found.best, keep=1)
    out.run(iterations=40)
    return out


def _raced(context: FitContext, effects: tuple[Effect, ...], starts: list[Start], like: Optimum) -> CandidateFit:
    """Race the starts; where the winner leaves more than noise, run them to their ends until some agree on the best."""
    best = CandidateFit(context, effects)
    best.begin(starts, like=like, keep=1)
    best.run(iterations=40)
    agree = 0
    for start in starts:
        if best.excess < _NOISY * context.noise_cost or agree == _AGREE:
            break
        other = CandidateFit(context, effects)
        other.begin([start], like=like)
        other.run(iterations=40)
        agree = agree + 1 if abs(other.cost - best.cost) < _SAME * best.cost else agree
        if other.cost < (1 - _SAME) * best.cost:
            best, agree = other, 0
    return best
