"""Two effects, then three: what is added to the best so far, and what goes with what."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stepid._base import Array
from stepid.diagnose.candidate import Candidate, at_floor, candidate
from stepid.diagnose.compete import PROMISE, WORTH, Progress, advance, final, settled
from stepid.effects.base import Effect
from stepid.engine.least_squares import minimize
from stepid.engine.problem import resonances, start_local
from stepid.engine.score import columns, promise, score
from stepid.engine.search import Contender, Ground, Scored, Start
from stepid.engine.sketch import full_residual

STRONG = 20.0  # evidence that a further effect must bring
_STARTS = 3  # of each addition: of what rings, the loudest may not be what is missing
_TRIED = 5  # additions that are raced on each
_FEW = 3  # the same on a general effect, which is slow
_SLOWER = 3.0  # times what an offer on a general effect promises to leave, as it is costly: simple ones race first
_MOST = 14  # combinations that are raced
_MODE = 2  # states of its own that make an effect a mode
_HEAVY = 2  # combinations with a mode that start anew where nothing reaches the floor
_LEADS = 0.5  # of the best cost so far, at which a combination runs on a little at once
_BEST = 4  # bases whose effects race together whatever they promise
_MORE = 3  # combinations that are raced beside one at the floor
_AS_MUCH = 1.2  # times the cost of one at the floor that they may promise to leave
_AHEAD = 0.9  # of the best simple effect's cost, at which a more general one is added to as well
_NEAR = 3.0  # times the floor's cost at which a combination runs on at once
_TWIN = 0.9  # of an effect's own gain by its score that one must gain to race in its place
_SWAPS = 2  # twins that are raced for each effect of a combination


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


class _Offer(NamedTuple):
    """A combination to race: the base it adds to, what it may leave, the starts of the effect added."""

    base: Contender
    left: float
    additions: list[Scored]

    @property
    def rank(self) -> float:
        """What it may leave, and more where it is costly to try."""
        return self.left * (_SLOWER if any(e.contains for e in self.base.effects) else 1.0)

    @property
    def names(self) -> set[str]:
        return {*self.base.names, self.additions[0].effect.name}


def _offer(base: Contender, additions: list[Scored]) -> _Offer:
    return _Offer(base, base.cost - additions[0].gain, additions[:_STARTS])


def extend(
    ground: Ground, bases: list[Contender], catalogue: tuple[Effect, ...], progress: Progress, *, tried: int = _TRIED
) -> list[Contender]:
    """Race every base with one effect more, the most promising first, until one reaches the floor; best first."""
    simple = tuple(e for e in catalogue if not e.contains)
    offers: list[_Offer] = []  # the same two effects may come from either: one way may lead where the other does not
    for base in bases:
        base.run(laps=10, tolerance=0.01 * base.excess)
        if base.best is None:
            continue
        # what rings in this base's residual may be hidden in the linear one
        left_over = full_residual(base.best, ground.linear, ground.outline)
        heard = ground.scales._replace(resonances=resonances(ground.records, left_over))
        ringing = {e for e in simple if e.starts(heard) != e.starts(ground.scales)}
        table = columns(ground, tuple(e for e in simple if e not in ringing)) + columns(ground, tuple(ringing), heard)
        own: dict[str, list[Scored]] = {}
        for scored in score(ground, base.best, table):
            if not any(_related(scored.effect, e) for e in base.effects):
                own.setdefault(scored.effect.name, []).append(scored)
        few = _FEW if any(e.contains for e in base.effects) else tried
        offers += [_offer(base, found) for found in list(own.values())[:few]]
    contenders: list[Contender] = []
    more = _MORE
    offers.sort(key=lambda o: o.rank)
    best = {e.name for b in sorted(bases, key=lambda b: b.cost)[:_BEST] for e in b.effects}
    for offer in [*offers[:_MOST], *(o for o in offers[_MOST:] if o.names <= best)]:
        if _explained(ground, contenders):  # race on with what promises as much
            if more == 0 or offer.left > max(ground.floored, _AS_MUCH * min(c.cost for c in contenders)):
                break
            if offer.names in [set(c.names) for c in contenders]:
                continue
            more -= 1
        contender = _added(ground, offer, progress)
        leads = all(contender.cost < _LEADS * c.cost for c in contenders)
        contenders.append(contender)
        if leads:
            contender.run(laps=6, tolerance=0.01 * contender.excess)
        if contender.cost < _NEAR * ground.floored:
            contender.run(laps=12)
    advance(ground, contenders)
    if not settled(ground, contenders):
        for contender in [c for c in contenders if c.effects[-1].n_extra >= _MODE][:_HEAVY]:
            _weigh(ground, contender)
        contenders.sort(key=lambda c: c.cost)
    return contenders


def _weigh(ground: Ground, contender: Contender) -> None:
    """Start a mode of its own anew, as heavy as its own guesses say: what it does is not in proportion to its mass."""
    if contender.best is not None:
        *others, own = contender.effects
        linear, values = _values(contender, None)
        starts = [Start(linear, (*values[: len(others)], guess)) for guess in own.starts(ground.scales)[-_STARTS:]]
        contender.begin(starts, like=contender.best, keep=len(starts), laps=8)
        contender.run(laps=10)


def _explained(ground: Ground, contenders: list[Contender]) -> bool:
    """Tell whether a contender leaves nothing but noise in all samples: a sketch has too few to tell for sure."""
    for contender in contenders:
        if contender.cost < ground.floored:
            contender.polish(laps=15, tolerance=ground.tolerance)
            done = contender.polished
            if done is not None and at_floor(ground, candidate(ground, contender.effects, done)):
                return True
    return False


def _added(ground: Ground, offer: _Offer, progress: Progress) -> Contender:
    """Race a base with one effect more: from where the linearized step leads, and with hardly any of it."""
    base, effect = offer.base, offer.additions[0].effect
    progress(" + ".join([*base.names, effect.name]))
    contender = Contender(ground, (*base.effects, effect))
    here = _values(base, None)
    starts, faint = [], []
    for scored in offer.additions:
        there = _values(base, scored.shared)
        starts.append(Start(there.linear, (*there.values, scored.values)))
        faint.append(Start(here.linear, (*here.values, effect.faint(scored.values, 0.03))))
    assert base.best is not None
    starts += faint[:2]
    contender.begin(starts[:1], like=base.best)  # the most promising, however far it is from the base
    if not settled(ground, [contender]):
        contender.begin(starts[1:], like=base.best, keep=len(starts) if effect.run_parameters else 4)
    return contender


def swap(ground: Ground, raced: list[Contender], catalogue: tuple[Effect, ...], progress: Progress) -> list[Contender]:
    """Race the best combination with each of its effects replaced by what may do as well, or by a simpler one inside.

    Combinations in `raced` are not raced again.
    """
    winner, known = raced[0], [set(c.names) for c in raced]
    assert winner.best is not None
    simple = tuple(e for e in catalogue if not e.contains)
    found: list[Contender] = []
    for place, effect in enumerate(winner.effects):
        base = _without(ground, winner, place)
        if base.best is None:
            continue
        offers: dict[Effect, list[Scored]] = {}
        table = columns(ground, tuple(dict.fromkeys([*simple, effect])))
        for scored in score(ground, base.best, table):
            offers.setdefault(scored.effect, []).append(scored)
        own = offers[effect][0].gain if effect in offers else 0.0
        others = [e for e in offers if e is not effect and not any(_related(e, w) for w in base.effects)]
        for other in [e for e in others if e.name in effect.contains or offers[e][0].gain > _TWIN * own][:_SWAPS]:
            offer = _offer(base, offers[other][:1])
            if offer.names not in known:
                found.append(_added(ground, offer, progress))
    advance(ground, [winner, *found])
    return found


def _without(ground: Ground, contender: Contender, place: int) -> Contender:
    """The combination with one effect dropped and all else where it stands."""
    assert contender.best is not None
    here = _values(contender, None)
    effects = (*contender.effects[:place], *contender.effects[place + 1 :])
    rest = Contender(ground, effects)
    shared = np.concatenate([here.linear, *(v for i, v in enumerate(here.values) if i != place)])
    local = start_local(rest.coarse, contender.best)
    at = 2
    rows: list[int] = []
    for i, effect in enumerate(contender.effects):
        q = len(effect.run_parameters)
        rows += range(at, at + q) if i != place else []
        at += q
    local[2 : rest.coarse.simulator.own_states.start] = contender.best.local[rows]
    rest.best = minimize(rest.coarse, shared, local, tolerance=np.inf, iterations=1)
    return rest


def pairs(ground: Ground, alone: list[Contender], catalogue: tuple[Effect, ...], progress: Progress) -> list[Contender]:
    """Race pairs of effects: what is added to each single one.

    Effects that contain a simpler one wait until `generalize`, unless they are far ahead.
    """
    simple = [c for c in alone if not c.effects[0].contains]
    best = min((c.cost for c in simple), default=np.inf)
    return extend(ground, [c for c in alone if c in simple or c.cost < _AHEAD * best], catalogue, progress)


def generalize(
    ground: Ground, contender: Contender, catalogue: tuple[Effect, ...], progress: Progress
) -> list[Contender]:
    """Replace each effect of a combination by those that contain it, started from where it stands."""
    found: list[Contender] = []
    if contender.best is None:
        return found
    here, done = _values(contender, None), settled(ground, [contender])
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
            if not effect.affine:
                least = PROMISE * ground.unit if done else WORTH * contender.excess
                starts = [s for s in starts if promise(ground, contender.best, effects, s) > least]
            if not starts:
                continue
            grown_up = Contender(ground, effects)
            grown_up.begin(starts, like=contender.best, keep=1 if done else 3)
            found.append(grown_up)
    advance(ground, [contender, *found])
    return sorted(found, key=lambda c: c.cost)


def finish(ground: Ground, contenders: list[Contender], count: int = 4) -> list[Candidate]:
    """Polish the best combinations; best evidence first."""
    return final(ground, contenders[:count], count=1, spread=0.05)
