"""Two effects, then three: what is added to the best so far, and what goes with what."""

from __future__ import annotations

import numpy as np

from stepid._base import Array
from stepid.diagnose.compete import Candidate, Progress, advance, candidate, final
from stepid.effects.base import Effect
from stepid.engine.least_squares import minimize
from stepid.engine.problem import build, resonances
from stepid.engine.score import columns, score
from stepid.engine.search import Contender, Ground, Scored, Start
from stepid.engine.sketch import full_residual

STRONG = 20.0  # evidence that a further effect must bring
_BASES = 4  # fits on which a further effect is tried
_TRIED = 5  # additions that are raced on each


def _related(one: Effect, other: Effect) -> bool:
    return one.name == other.name or one.name in other.contains or other.name in one.contains


def _values(contender: Contender, shared: Array | None) -> Start:
    """Where a contender stands (or where `shared` says), as a start."""
    assert contender.best is not None
    sim = contender.best.problem.simulator
    shared = contender.best.shared if shared is None else shared
    at, values = sim.n_linear, []
    for effect in contender.effects:
        values.append(tuple(float(v) for v in shared[at : at + len(effect.parameters)]))
        at += len(effect.parameters)
    return Start(shared[: sim.n_linear], tuple(values))


def extend(
    ground: Ground, bases: list[Contender], catalogue: tuple[Effect, ...], progress: Progress, *, tried: int = _TRIED
) -> list[Contender]:
    """Race every base with one effect more, the most promising by their scores; best first."""
    simple = tuple(e for e in catalogue if not e.contains)
    table = columns(ground, simple)
    offers: dict[frozenset[str], tuple[float, Contender, list[Scored]]] = {}
    wanted: list[frozenset[str]] = []
    for base in bases:
        base.run(laps=20, tolerance=0.002 * base.excess)
        if base.best is None:
            continue
        # what rings in this base's residual may be hidden in the linear one
        left_over = full_residual(base.best, ground.linear, ground.outline)
        heard = ground.scales._replace(resonances=resonances(ground.records, left_over))
        ringing = {e for e in simple if e.starts(heard) != e.starts(ground.scales)}
        offered = [c for c in table if c.effect not in ringing] + columns(ground, tuple(ringing), heard)
        own: list[frozenset[str]] = []
        for scored in score(ground, base.best, offered):
            if any(_related(scored.effect, e) for e in base.effects):
                continue
            key = frozenset([scored.effect.name, *(e.name for e in base.effects)])
            left = base.best.cost - scored.gain
            known = offers.get(key)
            if known is None or (left < known[0] and known[1] is not base):
                offers[key] = (left, base, [scored])
            elif known[1] is base and len(known[2]) < 2:
                known[2].append(scored)
            if key not in own:
                own.append(key)
        wanted += own[:tried]
    contenders = []
    for key in dict.fromkeys(wanted):
        _, base, additions = offers[key]
        effect = additions[0].effect
        here = _values(base, None)
        progress(" + ".join([*(e.name for e in base.effects), effect.name]))
        contender = Contender(ground, (*base.effects, effect))
        assert base.best is not None
        starts = []
        for scored in additions:  # where the linearized step leads, and from the base with hardly any of the effect
            there = _values(base, scored.shared)
            starts.append(Start(there.linear, (*there.values, scored.values)))
            starts.append(Start(here.linear, (*here.values, effect.faint(scored.values, 0.03))))
        contender.begin(starts, like=base.best)
        contenders.append(contender)
    advance(ground, contenders)
    return contenders


def pairs(ground: Ground, alone: list[Contender], catalogue: tuple[Effect, ...], progress: Progress) -> list[Contender]:
    """Race pairs of effects: on the best single ones, then on whatever the best pairs brought in.

    Effects that contain a simpler one wait until `generalize`.
    """
    alone = [c for c in alone if not c.effects[0].contains]
    found = extend(ground, alone[:_BASES], catalogue, progress)
    by_name = {c.effects[0].name: c for c in alone}
    fresh = [
        by_name[e.name]
        for c in found[:3]
        for e in c.effects
        if e.name in by_name and by_name[e.name] not in alone[:_BASES]
    ]
    fresh = list(dict.fromkeys(fresh))[:1]
    if fresh:
        found += extend(ground, fresh, catalogue, progress, tried=4)
        found.sort(key=lambda c: c.cost)
    return found


def generalize(
    ground: Ground, contender: Contender, catalogue: tuple[Effect, ...], progress: Progress
) -> list[Contender]:
    """Replace each effect of a combination by those that contain it, started from where it stands."""
    found: list[Contender] = []
    if contender.best is None:
        return found
    here = _values(contender, None)
    for place, inner in enumerate(contender.effects):
        for effect in catalogue:
            if inner.name not in effect.contains:
                continue
            effects = (*contender.effects[:place], effect, *contender.effects[place + 1 :])
            progress(" + ".join(e.name for e in effects))
            starts = [
                Start(here.linear, (*here.values[:place], grown, *here.values[place + 1 :]))
                for grown in effect.grow(here.values[place], ground.scales)
            ]
            grown_up = Contender(ground, effects)
            grown_up.begin(starts, like=contender.best)
            found.append(grown_up)
    advance(ground, found)
    return found


def finish(ground: Ground, contenders: list[Contender], count: int = 4) -> list[Candidate]:
    """Polish the best combinations; best evidence first."""
    return final(ground, contenders[:count], count=1, spread=0.05)


def simplify(ground: Ground, found: Candidate) -> list[Candidate]:
    """Drop each effect of a combination in turn and fit the others from where they stand; those that do no worse.

    A single effect can have been stuck where the combination was not.
    """
    optimum = found.optimum
    sim = optimum.problem.simulator
    out = []
    for dropped in range(len(found.effects)):
        shared, local = [optimum.shared[: sim.n_linear]], [optimum.local[:2]]
        at, row = sim.n_linear, 2
        for place, effect in enumerate(found.effects):
            n, q = len(effect.parameters), len(effect.run_parameters)
            if place != dropped:
                shared.append(optimum.shared[at : at + n])
                local.append(optimum.local[row : row + q])
            at, row = at + n, row + q
        rest = tuple(e for place, e in enumerate(found.effects) if place != dropped)
        problem = build(ground.records, rest)
        local.append(np.zeros((problem.simulator.law.n_states - 2, optimum.local.shape[1])))  # own states begin anew
        fewer = minimize(
            problem, np.concatenate(shared), np.concatenate(local), tolerance=ground.tolerance, iterations=20
        )
        if fewer is not None:
            simpler = candidate(ground, rest, fewer)
            if simpler.evidence < found.evidence + STRONG:
                out.append(simpler)
    return sorted(out, key=lambda c: c.evidence)
