"""Third question: which candidates explain it? Every effect is fitted; the best are polished on all data."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.selection.candidate import Candidate, polish
from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.multistart import Contender, FitContext, Start, race_starts
from stepid.fitting.multistart_cogging import well_starts
from stepid.fitting.problem import start_local
from stepid.fitting.score_test import columns, promises, score

Progress = Callable[[str], None]
_FIELD = 8  # effects that race after the first scoring
_CLOSE = 5.0  # times the best score's cost within which an effect races at once
_PLAIN = 4.0  # times the cost of noise above which the linear gap is plain to see
_PLAINEST = 16.0  # the same for effects that are hard to score
_AS_WELL = 4.0  # times the winner's score within which another may explain as much
_NEAR = 3.0  # times the floor's cost at which a contender runs on at once
_HOPELESS = 6.0  # times the cost of one that reached the floor
_STUCK = 3.0  # χ² by which a simple effect may be worse than one that contains it, before it is tried from there
_DEEP = 15  # steps from a start that knows its well, which get worse before they get better
_SLOW = 60.0  # χ² by which a law that has just begun may be worse than one it contains
_IDLE = 1.0  # χ² that a step must promise, of a law that does no better than a simpler one inside it
WORTH = 0.3  # share of what a simpler effect leaves that a costly general one must promise to take away (1 if it is it)
PROMISE = 3.0  # χ² that a more general effect must promise where a simpler one reached the floor


def singles(context: FitContext, catalogue: tuple[Effect, ...], progress: Progress) -> list[Contender]:
    """Race the effects that their scores do not rule out, each alone; the best first."""
    scored = score(context, context.outline, columns(context, catalogue))
    left: dict[Effect, float] = {}
    for s in scored:
        if not s.effect.contains:
            left.setdefault(s.effect, context.outline.cost - s.gain)
    ranked = list(left)[:_FIELD]
    best = max(min(left.values(), default=0.0), context.noise_cost)
    field = [e for place, e in enumerate(ranked) if place < 3 or left[e] < _CLOSE * best]
    dry = [e for e in catalogue if e.dry and (e in field or not e.contains)]  # hard to score: they always race
    contenders: list[Contender] = []
    gap = context.outline.cost / context.noise_cost
    for effect in [*(e for e in field if not e.dry), *dry]:
        keep = 3
        if gap > _PLAIN and settled(context, contenders):  # something explains a plain gap: only what may do as well
            winner = min(contenders, key=lambda c: c.cost).effects[0]
            behind = left.get(effect, np.inf) > _AS_WELL * left.get(winner, np.inf)
            if behind and (not effect.dry or gap > _PLAINEST):
                continue
            keep = 1 if effect.dry and effect not in ranked[:2] else 3
        contender = _enter(context, effect, race_starts(context, effect, scored), progress, keep=keep)
        if contender.cost < _NEAR * context.floored:
            contender.run(laps=10)
        contenders.append(contender)
    advance(context, contenders)
    return generalized(context, contenders, catalogue, progress)


def settled(context: FitContext, contenders: list[Contender]) -> bool:
    """Tell whether a contender has reached the noise floor."""
    return min((c.cost for c in contenders), default=np.inf) < context.floored


def widen(
    context: FitContext, contenders: list[Contender], catalogue: tuple[Effect, ...], progress: Progress
) -> list[Contender]:
    """Race the effects that `singles` left out; the best first."""
    known = {c.effects[0] for c in contenders}
    scored = score(context, context.outline, columns(context, tuple(e for e in catalogue if e not in known)))
    unscored = [e for e in catalogue if e not in known]
    ranked = [e for e in dict.fromkeys([*(s.effect for s in scored), *unscored]) if not e.contains]
    more = [_enter(context, e, race_starts(context, e, scored), progress) for e in ranked]
    contenders = [*contenders, *more]
    advance(context, contenders)
    return generalized(context, contenders, catalogue, progress, every=True)


def generalized(
    context: FitContext,
    contenders: list[Contender],
    catalogue: tuple[Effect, ...],
    progress: Progress,
    *,
    every: bool = False,
) -> list[Contender]:
    """Add the effects that contain a good candidate (or any, where `every` is wanted), started from it; best first."""
    by_name = {c.effects[0].name: c for c in contenders}
    best, done = contenders[0].cost, settled(context, contenders[:1])
    limit = best + 60 * context.unit if done else 4 * best
    offers = []
    for effect in catalogue:
        inner = [by_name[n] for n in effect.contains if n in by_name]
        good = [c for c in inner if c.cost < limit or ((every or c in contenders[:3]) and not done)]
        if good and effect.name not in by_name:
            starts = [found for c in good for found in _promised(context, effect, c)]
            if starts:
                offers.append((min(left for left, _, _ in starts), effect, starts))
    added: list[Contender] = []
    for _, effect, starts in sorted(offers, key=lambda offer: offer[0]):
        if not effect.affine and not done:
            starts = [s for s in starts if s[1] > WORTH * max(s[0] + s[1] - context.noise_cost, 0.0)]
        if settled(context, [*contenders, *added]) and not effect.affine:
            # an affine one is quick, and may be as good without promising any gain
            least = min(c.cost for c in [*contenders, *added]) + 60 * context.unit
            starts = [s for s in starts if s[1] > PROMISE * context.unit and s[0] - 3 * s[1] < least]
        if starts:
            added.append(_enter(context, effect, [s for _, _, s in starts], progress))
    if added:
        contenders = [*contenders, *added]
        advance(context, contenders)
        for general in added:
            for simple in (by_name[n] for n in general.effects[0].contains if n in by_name):
                _release(context, simple, general)
        contenders.sort(key=lambda c: c.cost)
    return contenders


def _release(context: FitContext, simple: Contender, general: Contender) -> None:
    """Fit a simple effect from where one that contains it ended: it may have been stuck where the other was not."""
    if general.best is None or simple.cost < general.cost + _STUCK * context.unit:
        return
    n = general.coarse.layout.linear.stop
    level = level_within(general.effects[0], general.best.shared[n:], simple.effects[0])
    if level is None:
        return
    problem = simple.coarse
    local = start_local(problem, general.best)
    shared = np.append(general.best.shared[:n], level)
    found = minimize(problem, shared, local, tolerance=context.tolerance, iterations=30)
    if found is not None and found.cost < simple.cost:
        simple.best, simple.polished = found, None


def level_within(general: Effect, values: Array, simple: Effect) -> float | None:
    """Strength of a simple effect inside a general one: the mean of the parameters in its unit; None where none is."""
    unit = simple.parameters[0].unit
    alike = [v for v, q in zip(values, general.parameters, strict=True) if q.unit == unit]
    return float(np.mean(alike)) if alike else None


def _promised(context: FitContext, effect: Effect, inner: Contender) -> list[tuple[float, float, Start]]:
    """Starts of a more general effect: the cost each promises to leave, and what it promises to gain."""
    if inner.best is None:
        return []
    told_for, found = inner.promised.get(effect, (None, []))
    if told_for is not inner.best:
        starts = _grown(context, effect, inner)
        gains = promises(context, inner.best, (effect,), starts)
        found = [(inner.cost - gain, gain, start) for gain, start in zip(gains, starts, strict=True)]
        inner.promised[effect] = inner.best, found
    return found


def _enter(context: FitContext, effect: Effect, starts: list[Start], progress: Progress, *, keep: int = 3) -> Contender:
    progress(effect.name)
    contender = Contender(context, (effect,))
    contender.begin(starts, like=context.outline, keep=keep, laps=min(keep + 1, 3))
    wells = [] if settled(context, [contender]) else well_starts(context, effect)
    if wells:
        contender.begin(wells, like=context.outline, keep=1, laps=_DEEP)
    return contender


def _grown(context: FitContext, effect: Effect, inner: Contender) -> list[Start]:
    """Starts of an effect that contains a simpler one, at the simpler one's optimum."""
    if inner.best is None:
        return []
    n = inner.coarse.layout.linear.stop
    linear, values = inner.best.shared[:n], inner.best.shared[n:]
    return [Start(linear, (grown,)) for grown in grow(context, effect, tuple(float(v) for v in values))]


def grow(context: FitContext, effect: Effect, inner: tuple[float, ...]) -> list[tuple[float, ...]]:
    """Values of an effect at the optimum of one that it contains; its own guesses where it does not say."""
    return [tuple(v) for v in effect.grow(inner, context.scales) or effect.starts(context.scales)]


def advance(context: FitContext, contenders: list[Contender], laps: tuple[int, ...] = (5, 10, 20)) -> None:
    """Let the promising ones run on: the fewer, the further."""
    for keep, lap in zip((6, 4, 3), laps, strict=True):
        contenders.sort(key=lambda c: c.cost)
        best = contenders[0].cost if contenders else np.inf
        hopeless = _HOPELESS * best if settled(context, contenders[:1]) else np.inf
        for place, contender in enumerate(contenders):
            if lags(context, contender, contenders, begun=lap == laps[0]):
                continue
            if contender.cost < hopeless and (place < keep or contender.cost < 1.5 * best):
                enough = max(0.003 * (contender.cost - best), 0.002 * contender.excess, 0.2 * context.unit)
                contender.run(laps=lap, tolerance=enough)
    contenders.sort(key=lambda c: c.cost)


def lags(context: FitContext, contender: Contender, others: list[Contender], *, begun: bool = False) -> bool:
    """Tell whether a law is plainly worse than a simpler one that it contains: stuck, and slow to get free.

    One that has just begun may be worse for a while, unless the simpler one is at the floor.
    """
    if all(e.linear or e.affine for e in contender.effects):
        return False
    least = _inside(contender, others)
    if least < context.floored:
        return contender.cost > least + (_SLOW if begun else _STUCK) * context.unit
    return not begun and contender.cost > least + max(_SLOW * context.unit, 0.02 * least)


def _idle(context: FitContext, contender: Contender, others: list[Contender]) -> bool:
    """Tell whether a simpler law, inside this one, is at the floor and this one does no better."""
    least = _inside(contender, others)
    return least < context.floored and contender.cost > least - PROMISE * context.unit


def _inside(contender: Contender, others: list[Contender]) -> float:
    """Least cost [m²] of the simpler laws inside a contender's; infinite where there is none."""
    inner = [c for c in others if c.effects != contender.effects and includes(contender.effects, c.effects)]
    return min((c.cost for c in inner), default=np.inf)


def includes(bigger: tuple[Effect, ...], smaller: tuple[Effect, ...]) -> bool:
    """Tell whether every effect of `smaller` is in `bigger` or contained in one of its effects."""
    return all(any(e.name == b.name or e.name in b.contains for b in bigger) for e in smaller)


def final(context: FitContext, contenders: list[Contender], *, count: int = 2, spread: float = 0.02) -> list[Candidate]:
    """Polish the best contenders, at least `count` and those within `spread` of the best cost; best evidence first."""
    contenders = sorted(contenders, key=lambda c: c.cost)
    best = contenders[0].cost if contenders else 0.0
    near = best + max(60 * context.unit, spread * best)
    hopeless = _HOPELESS * best if settled(context, contenders[:1]) else np.inf
    found = {}
    contenders = [c for c in contenders if not lags(context, c, contenders)]
    for place, contender in enumerate(contenders):
        if (place < count and contender.cost < hopeless) or contender.cost < near:
            done = polish(context, contender, enough=_IDLE if _idle(context, contender, contenders) else 0.05)
            if done is not None:
                found[contender] = done
    lead = min(found, key=lambda c: found[c].evidence, default=None)
    if lead is not None and len(lead.effects) < 3 and found[lead].optimum.rms > 1.03 * context.floor:
        for contender in sorted(found, key=lambda c: found[c].evidence)[:3]:
            if contender.best is not None and any(e.dry and not e.contains for e in contender.effects):
                # another pattern of sticking may be better
                if contender.resettle():
                    again = polish(context, contender)
                    if again is not None and again.evidence < found[contender].evidence:
                        found[contender] = again
                break
    return sorted(found.values(), key=lambda c: c.evidence)
