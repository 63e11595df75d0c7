"""Two effects, then three: what is added to the best so far, and what goes with what."""

from __future__ import annotations

import numpy as np

from stepid.diagnosis.selection.candidate import Candidate, at_floor, candidate
from stepid.diagnosis.selection.proposals import Entry, Offer, make_offer, n_parameters, offers_on, related, standing
from stepid.diagnosis.selection.racing import PROMISE, WORTH, Progress, advance, final, grow, settled
from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.multistart import Contender, FitContext, Scored, Start
from stepid.fitting.problem import start_local
from stepid.fitting.score_test import columns, promises, score

STRONG = 20.0  # evidence that a further effect must bring
_MOST = 18  # combinations that are raced
_FIRST = 6  # combinations that are raced before all single effects are
_HEAVY = 2  # combinations with a mode that start anew where nothing reaches the floor
_LOST = 30.0  # times the floor's cost above which three effects are not raced from other starts
_LEADS = 0.5  # of the best cost so far, at which a combination runs on a little at once
_BEST = 4  # bases whose effects race together whatever they promise
_MORE = 3  # combinations that are raced beside one at the floor
_AS_MUCH = 1.2  # times the cost of one at the floor that they may promise to leave
_FEWER = 4.0  # the same for those with fewer parameters: a sine comes near many a simple law
_AHEAD = 0.9  # of the best simple effect's cost, at which a more general one is added to as well
_FAR = 0.1  # of the best cost of others, below which a combination is judged in all samples, at the floor or near it
_NEAR = 3.0  # times the floor's cost at which a combination runs on at once
_TWIN = 0.9  # of an effect's own gain by its score that one must gain to race in its place
_SIMPLER = 0.5  # the same for one with fewer parameters
_HOPELESS = 3.0  # times the floor's cost above which such a twin does not race on
_ADAPTED = 6  # steps in which what remains adapts to the loss of an effect
_SWAPS = 2  # twins that are raced for each effect of a combination
_SIMPLER_SWAPS = 5  # the same of those with fewer parameters, grown with the catalogue: 4 of 20, 5 of 23


def extend(
    context: FitContext,
    bases: list[Contender],
    catalogue: tuple[Effect, ...],
    progress: Progress,
    race: Race | None = None,
) -> list[Contender]:
    """Race every base with one effect more, the most promising first, until one reaches the floor; best first.

    All begin from the start that promises most; where none reaches the floor, from others, three effects only where one
    comes near. A `race` goes on.
    """
    race = race or Race(context)
    if not race.explained():
        offers = offers_on(context, bases, catalogue)
        best = {e.name for b in sorted(bases, key=lambda b: b.cost)[:_BEST] for e in b.effects}
        race.try_all([*offers[:_MOST], *(o for o in offers[_MOST:] if o.names <= best)], progress)
    ranked = race.ranked()
    if ranked and race.ahead(ranked[0].contender) and race.explained():
        return [e.contender for e in race.ranked()]
    advance(context, race.contenders, laps=(5, 10, 10))
    least = min((c.cost for c in race.contenders), default=np.inf)
    if least > _LOST * context.floored and all(len(b.effects) > 1 for b in bases):
        return [e.contender for e in race.ranked()]
    for entry in race.entries:
        if race.over(entry.offer):
            continue
        if not settled(context, [entry.contender]):
            entry.again()
            race.lead(entry.contender)
    advance(context, race.contenders)
    if not settled(context, race.contenders):
        for entry in [e for e in race.ranked() if e.is_mode][:_HEAVY]:
            entry.weigh()
    return [e.contender for e in race.ranked()]


class Race:
    """The combinations that race so far; it is over some further tries after one explains all."""

    def __init__(self, context: FitContext) -> None:
        self.context, self.entries, self.more = context, list[Entry](), _MORE

    @property
    def contenders(self) -> list[Contender]:
        """Those of the entries, in the order of their entry."""
        return [e.contender for e in self.entries]

    def ranked(self) -> list[Entry]:
        """Entries by their cost, the least first."""
        return sorted(self.entries, key=lambda e: e.contender.cost)

    def try_all(self, offers: list[Offer], progress: Progress, first: int | None = None) -> None:
        """Enter offers that are not in the race, until it is over; no more where the `first` few do not explain all."""
        known = {(id(e.offer.base), e.effect) for e in self.entries}
        for place, offer in enumerate(offers):
            if first is not None and place >= first and not self.explained():
                return
            if (id(offer.base), offer.additions[0].effect) not in known and not self.over(offer):
                entry = Entry(self.context, offer, progress)
                self.entries.append(entry)
                self.lead(entry.contender)

    def lead(self, contender: Contender) -> None:
        """Let a contender run on where it leads, or is near the floor."""
        if all(contender.cost < _LEADS * c.cost for c in self.contenders if c is not contender):
            contender.run(laps=6, tolerance=0.01 * contender.excess)
        if contender.cost < _NEAR * self.context.floored:
            contender.run(laps=12)

    def ahead(self, contender: Contender) -> bool:
        """Tell whether a contender is far ahead of every other combination, and of what they add to."""
        others = [c.cost for c in self.contenders if set(c.names) != set(contender.names)]
        return contender.cost < _FAR * min([*others, *(e.offer.base.cost for e in self.entries)])

    def explained(self) -> bool:
        """Tell whether a combination leaves nothing but noise in all samples: a sketch has too few to tell for sure."""
        for contender in self.contenders:
            least = _NEAR if self.ahead(contender) else 1.0
            if contender.cost < least * self.context.floored:
                contender.polish(laps=15, tolerance=self.context.tolerance)
                done = contender.polished
                if done is not None and at_floor(self.context, candidate(self.context, contender.effects, done)):
                    return True
        return False

    def over(self, offer: Offer) -> bool:
        """Tell whether a combination explains all, and this offer does not promise as much."""
        if not self.explained():
            return False
        best = min(self.contenders, key=lambda c: c.cost)
        if offer.names == set(best.names):
            return True  # from its other effect
        few = offer.n_parameters < sum(map(n_parameters, best.effects))
        if offer.left > max(self.context.floored, (_FEWER if few else _AS_MUCH) * best.cost):
            return True
        if offer.names not in [e.offer.names for e in self.entries]:
            self.more -= 1
        return self.more < 0


def swap(
    context: FitContext, raced: list[Contender], catalogue: tuple[Effect, ...], progress: Progress
) -> list[Contender]:
    """Race the best combination with each of its effects replaced by what may do as well, or by a simpler one inside.

    Combinations in `raced` are not raced again where they came near: one may have begun where it got stuck.
    """
    winner = raced[0]
    known = [set(c.names) for c in raced if c.cost < _HOPELESS * context.floored]
    assert winner.best is not None
    simple = tuple(e for e in catalogue if not e.contains)
    found: list[Contender] = []
    for place, effect in enumerate(winner.effects):
        base = _without(context, winner, place)
        if base.best is None:
            continue
        offers: dict[Effect, list[Scored]] = {}
        table = columns(context, tuple(dict.fromkeys([*simple, effect])))
        for scored in score(context, base.best, table):
            offers.setdefault(scored.effect, []).append(scored)
        own = offers[effect][0].gain if effect in offers else 0.0
        others = [e for e in offers if e is not effect and not any(related(e, w) for w in base.effects)]
        others = [e for e in others if {*base.names, e.name} not in known]
        few = [e for e in others if n_parameters(e) < n_parameters(effect) and offers[e][0].gain > _SIMPLER * own]
        alike = [e for e in others if e.name in effect.contains or offers[e][0].gain > _TWIN * own]
        for other in dict.fromkeys([*few[:_SIMPLER_SWAPS], *alike[:_SWAPS]]):
            entry = Entry(context, make_offer(base, offers[other][:1]), progress)
            if context.floored <= entry.contender.cost < _HOPELESS * context.floored:
                entry.again()
            found.append(entry.contender)
    advance(context, [winner, *(c for c in found if c.cost < _HOPELESS * context.floored)])
    return found


def _without(context: FitContext, contender: Contender, place: int) -> Contender:
    """The combination with one effect dropped, all else adapted a little from where it stands."""
    assert contender.best is not None
    here = standing(contender, None)
    effects = (*contender.effects[:place], *contender.effects[place + 1 :])
    rest = Contender(context, effects)
    shared = np.concatenate([here.linear, *(v for i, v in enumerate(here.values) if i != place)])
    local = start_local(rest.coarse, contender.best)
    at = 2
    rows: list[int] = []
    for i, effect in enumerate(contender.effects):
        q = len(effect.run_parameters)
        rows += range(at, at + q) if i != place else []
        at += q
    local[2 : rest.coarse.layout.own_states.start] = contender.best.local[rows]
    rest.best = minimize(rest.coarse, shared, local, tolerance=context.unit, iterations=_ADAPTED)
    return rest


def first_pairs(context: FitContext, alone: list[Contender], catalogue: tuple[Effect, ...], progress: Progress) -> Race:
    """Race the few most promising pairs; go on with `pairs` where they do not explain all."""
    race = Race(context)
    race.try_all(offers_on(context, _bases(alone), catalogue), progress, first=_FIRST)
    return race


def pairs(
    context: FitContext,
    alone: list[Contender],
    catalogue: tuple[Effect, ...],
    progress: Progress,
    race: Race | None = None,
) -> list[Contender]:
    """Race pairs of effects: what is added to each single one."""
    return extend(context, _bases(alone), catalogue, progress, race)


def _bases(alone: list[Contender]) -> list[Contender]:
    """Effects to add to; those that contain a simpler one wait until `generalize`, unless they are far ahead."""
    simple = [c for c in alone if not c.effects[0].contains]
    best = min((c.cost for c in simple), default=np.inf)
    return [c for c in alone if c in simple or c.cost < _AHEAD * best]


def generalize(
    context: FitContext, contender: Contender, catalogue: tuple[Effect, ...], progress: Progress
) -> list[Contender]:
    """Replace each effect of a combination by those that contain it, started from where it stands."""
    found: list[Contender] = []
    if contender.best is None:
        return found
    here, done = standing(contender, None), settled(context, [contender])
    for place, inner in enumerate(contender.effects):
        for effect in catalogue:
            if inner.name not in effect.contains:
                continue
            effects = (*contender.effects[:place], effect, *contender.effects[place + 1 :])
            progress(" + ".join(e.name for e in effects))
            starts = [
                Start(here.linear, (*here.values[:place], grown, *here.values[place + 1 :]))
                for grown in grow(context, effect, here.values[place])
            ]
            if not effect.affine:
                least = PROMISE * context.unit if done else WORTH * contender.excess
                gains = promises(context, contender.best, effects, starts)
                starts = [s for s, gain in zip(starts, gains, strict=True) if gain > least]
            if not starts:
                continue
            grown_up = Contender(context, effects)
            grown_up.begin(starts, like=contender.best, keep=1 if done else 3)
            found.append(grown_up)
    advance(context, [contender, *found])
    return sorted(found, key=lambda c: c.cost)


def finish(context: FitContext, contenders: list[Contender], count: int = 4) -> list[Candidate]:
    """Polish the best combinations, each once whatever the order of its effects; best evidence first."""
    once: dict[frozenset[str], Contender] = {}
    for contender in contenders:
        once.setdefault(frozenset(contender.names), contender)
    return final(context, list(once.values())[:count], count=1, spread=0.05)
