"""What may be added to a set of effects: scored by one linearized step, with the starts that it leads to."""

from __future__ import annotations

from typing import NamedTuple

from stepid.core.base import Array
from stepid.diagnosis.selection.racing import Progress
from stepid.effects.base import Effect
from stepid.fitting.decimation import full_residual
from stepid.fitting.multistart import Contender, FitContext, Scored, Start
from stepid.fitting.score_test import columns, score
from stepid.fitting.spectrum import resonances

_TRIED = 5  # additions to each base; to the best simple one, all
_FEW = 3  # the same to a general effect, which is slow
_SLOWER = 3.0  # times what an offer on a general effect promises to leave, as it is costly: simple ones race first
_PRICE = 0.25  # share of what is left that a further parameter counts as, in the order of the race
_KEPT = 4  # starts that are run after the first, where the simulated ones can be told apart
_MODE = 2  # states of its own that make an effect a mode
_GUESSES = 3  # of its own that a mode starts anew from
_FAINT = 0.03  # share of an effect at which hardly any of it is there


def related(one: Effect, other: Effect) -> bool:
    """Tell whether two effects are the same, or one contains the other."""
    return one.name == other.name or one.name in other.contains or other.name in one.contains


def standing(contender: Contender, shared: Array | None) -> Start:
    """Where a contender stands (or where `shared` says), as a start."""
    assert contender.best is not None
    of = contender.best.problem.layout
    shared = contender.best.shared if shared is None else shared
    return Start(shared[of.linear], tuple(tuple(float(v) for v in shared[place]) for place in of.values))


class Offer(NamedTuple):
    """A combination to race: the base it adds to, what it may leave, the starts of the effect added."""

    base: Contender
    left: float
    additions: list[Scored]

    @property
    def rank(self) -> float:
        """What it may leave, and more where it is costly to try, or has many parameters to explain it with."""
        freedom = 1.0 + _PRICE * (n_parameters(self.additions[0].effect) - 1)
        return self.left * freedom * (_SLOWER if any(e.contains for e in self.base.effects) else 1.0)

    @property
    def n_parameters(self) -> int:
        """Parameters of all its effects."""
        return sum(n_parameters(e) for e in (*self.base.effects, self.additions[0].effect))

    @property
    def names(self) -> set[str]:
        """Canonical names of the combination."""
        return {*self.base.names, self.additions[0].effect.name}


def n_parameters(effect: Effect) -> int:
    """Count an effect's parameters, those of a run once."""
    return len(effect.parameters) + len(effect.run_parameters)


def make_offer(base: Contender, additions: list[Scored]) -> Offer:
    """An offer to add an effect by its best scores."""
    return Offer(base, base.cost - additions[0].gain, additions)


def offers_on(context: FitContext, bases: list[Contender], catalogue: tuple[Effect, ...]) -> list[Offer]:
    """What may be added to each base, the most promising first.

    The same two effects may come from either: one way may lead where the other does not.
    """
    simple = tuple(e for e in catalogue if not e.contains)
    offers: list[Offer] = []
    plain = [b for b in bases if len(b.effects) == 1 and not b.effects[0].contains]
    best = min(plain, key=lambda b: b.cost, default=None)
    for base in bases:
        base.run(laps=10, tolerance=0.01 * base.excess)
        if base.best is None:
            continue
        # what rings in this base's residual may be hidden in the linear one
        left_over = full_residual(base.best, context.linear, context.outline)
        heard = context.scales._replace(resonances=resonances(context.records, left_over))
        ringing = {e for e in simple if e.starts(heard) != e.starts(context.scales)}
        table = columns(context, tuple(e for e in simple if e not in ringing)) + columns(context, tuple(ringing), heard)
        own: dict[str, list[Scored]] = {}
        for scored in score(context, base.best, table):
            if not any(related(scored.effect, e) for e in base.effects):
                own.setdefault(scored.effect.name, []).append(scored)
        few = _FEW if any(e.contains for e in base.effects) else len(own) if base is best else _TRIED
        offers += [make_offer(base, found) for found in list(own.values())[:few]]
    return sorted(offers, key=lambda o: o.rank)


class Entry:
    """An offer in the race: its contender, begun from the start that promises most, and the starts not yet tried."""

    def __init__(self, context: FitContext, offer: Offer, progress: Progress) -> None:
        self.context, self.offer = context, offer
        base, self.effect = offer.base, offer.additions[0].effect
        progress(" + ".join([*base.names, self.effect.name]))
        self.contender = Contender(context, (*base.effects, self.effect))
        here = standing(base, None)
        starts, faint = [], []
        for scored in offer.additions:
            there = standing(base, scored.shared)
            starts.append(Start(there.linear, (*there.values, scored.values)))
            faint.append(Start(here.linear, (*here.values, self.effect.faint(scored.values, _FAINT))))
        assert base.best is not None
        first = len(starts) if self.effect.run_parameters else 1
        self.contender.begin(starts[:first], like=base.best, keep=1)  # however far it is from the base
        self.starts = [*starts[1:], *faint[:2]]

    @property
    def is_mode(self) -> bool:
        """Tell whether the effect added swings by itself."""
        return self.effect.n_extra >= _MODE

    def again(self) -> None:
        """Try the other starts, those with hardly any of the effect among them."""
        base = self.offer.base
        assert base.best is not None
        keep = len(self.starts) + 1 if self.effect.run_parameters else _KEPT
        self.contender.begin(self.starts, like=base.best, keep=keep)

    def weigh(self) -> None:
        """Start a mode of its own as heavy as its own guesses say: what it does is not in proportion to its mass."""
        if self.contender.best is None:
            return
        linear, values, _ = standing(self.contender, None)
        guesses = self.effect.starts(self.context.scales)[-_GUESSES:]
        starts = [Start(linear, (*values[:-1], guess)) for guess in guesses]
        self.contender.begin(starts, like=self.contender.best, keep=len(starts), laps=8)
        self.contender.run(laps=10)
