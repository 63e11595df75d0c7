"""What a search has found so far, and which of it leads."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor, chosen_at, is_white, least_share, part_left, qbic_by
from stepid.diagnosis.free_law import FreeLaw, followed
from stepid.diagnosis.selection import order as by
from stepid.diagnosis.selection.candidate import LEADING, LINEAR, Candidate, Deviations, Key, includes
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.proposal import Node
from stepid.diagnosis.vetoes import barred, imitators
from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_floor import repeatability


class Standings:
    """Sets of effects that were fitted a little, and candidates that were fitted to all samples.

    Parameters
    ----------
    fit : FitContext
    criteria : Criteria
    effort : Effort
    """

    def __init__(self, fit: FitContext, criteria: Criteria, effort: Effort) -> None:
        self.fit, self.criteria, self.effort = fit, criteria, effort
        self.nodes: dict[Key, Node] = {}
        self.candidates: dict[Key, Candidate] = {}
        self._by_least: tuple[Optimum, Callable[..., float]] | None = None
        self.noise_limit = fit.noise_limit  # cost in the race below which nothing but noise is left, m²

    @cached_property
    def _spread(self) -> float:
        """What repeated runs differ by, m: no model of one plant takes that."""
        return repeatability(self.fit.records) or 0.0

    @property
    def root(self) -> Node:
        """The linear plant, runs alike."""
        return self.nodes[LINEAR]

    @property
    def best(self) -> Candidate:
        """The candidate of least QBIC so far."""
        return min(self.candidates.values(), key=lambda c: self.qbic(c.optimum))

    def leading(self) -> list[Candidate]:
        """The best, what would be answered, and others that leave only noise as runs may differ: they may need less.

        Where the best cannot be named, also the first that can. Where a rest remains, the best of what may lead, and a
        larger set that takes as much of it as a lead has to.
        """
        best = self.best
        if not at_floor(self.fit, self.criteria, best):
            return self._leading_beside_a_rest(best)
        no_name = barred(self.fit, self.criteria, best)
        simplest = self.simplest()
        stands = at_floor(self.fit, self.criteria, simplest)
        stands = stands and not (no_name and barred(self.fit, self.criteria, simplest))
        first = {c.key: c for c in (best, simplest) if c is best or stands}
        others = [c for c in self.candidates.values() if c.key not in first and (no_name or c.deviations)]
        others = sorted(filter(self.leaves_noise, others), key=lambda c: self.qbic(c.optimum))
        return [*first.values(), *others][: 2 if no_name else self.effort.beam]

    def _leading_beside_a_rest(self, best: Candidate) -> list[Candidate]:
        """The best of what may lead; and of all, where that is larger and takes of its rest what a lead has to."""
        few = [c for c in self.candidates.values() if len(c.effects) <= LEADING]
        able = [c for c in few if not imitators(self.fit, self.criteria, c)]
        lead = min(able, key=lambda c: self.qbic(c.optimum))
        larger = len(best.effects) > LEADING and not best.deviations
        far = best.optimum.cost < (1 - self.criteria.lead) * lead.optimum.cost  # on its way to the noise
        return [lead, best] if larger and far else [lead]

    def simplest(self) -> Candidate:
        """What would be answered where only noise is left: as `EvidenceRecord.best`, before that asks of scatter."""

        def of(some: Sequence[Candidate]) -> Candidate:
            return min(some, key=lambda c: self.qbic(c.optimum) + chosen_at(self.criteria, c))

        every = list(self.candidates.values())
        found = of([c for c in every if not imitators(self.fit, self.criteria, c)] or every)
        return found if at_floor(self.fit, self.criteria, found) else of(every)

    def qbic(self, optimum: Optimum, cost: float | None = None) -> float:
        """QBIC by the samples that are effective in what the candidate of least cost leaves; of another cost, m²."""
        least = min((c.optimum for c in self.candidates.values()), key=lambda o: o.cost)
        if self._by_least is None or self._by_least[0] is not least:
            self._by_least = least, qbic_by(self.fit, least)
        return self._by_least[1](optimum, cost)

    @property
    def tie(self) -> float:
        """Difference of cost in the race below which two candidates are not told apart, m²."""
        return self.criteria.tie * self.fit.unit

    def foreseen(self, node: Node, more: float = 0.0) -> float:
        """QBIC of a node, by what its cost in the race, or so much more [m²], tells of its cost in all samples."""
        beyond = (node.cost + more - self.fit.noise_cost) * self.fit.floor**2 / self.fit.unit
        return self.qbic(node.best, self.fit.full_noise_cost + beyond)

    def in_order(self) -> list[Node]:
        """Nodes, of least QBIC as foreseen first."""
        return sorted(self.nodes.values(), key=self.foreseen)

    def needed(self, effects: tuple[Effect, ...], deviations: Deviations) -> float:
        """Cost in the race at which a set is an answer, m²: the noise, or as little of a misfit as a lead may leave.

        The misfit is that of the linear plant with the same conditions free; of two effects, one of which leads alone,
        it is what that one leaves.
        """
        if not effects or len(effects) > LEADING:
            return self.noise_limit
        plain = self._plain(deviations)
        least = self._left_of(plain, least_share(self.criteria, len(effects)))
        inside = [n for n in self.nodes.values() if len(n.effects) == 1 < len(effects) and n.deviations == deviations]
        alone = [n.cost for n in inside if includes(effects, n.effects)]
        leading = [cost for cost in alone if cost <= self._left_of(plain, self.criteria.lead)]
        return min([least, *(self._left_of(cost, self.criteria.lead) for cost in leading)])

    def _plain(self, deviations: Deviations) -> float:
        """Cost in the race of the linear plant whose runs differ so, or are alike where that was not fitted, m²."""
        return self.nodes.get((frozenset(), deviations), self.root).cost

    def _left_of(self, cost: float, share: float) -> float:
        """What is left of a cost, m², of which a share is taken that is no noise, nor differs between repeated runs."""
        noise = self.noise_limit * max(self._spread / self.fit.floor, 1.0) ** 2
        return noise + (1 - share) * max(cost - noise, 0.0)

    def answers(self, node: Node) -> bool:
        """Tell whether a node leaves at most twice what an answer may."""
        return node.cost <= 2 * self.needed(node.effects, node.deviations)

    def answered(self) -> bool:
        """Tell whether one of the leading sets leaves only noise, or at most twice what an answer may."""
        return any(at_floor(self.fit, self.criteria, c) or self.answers(self.nodes[c.key]) for c in self.leading())

    def complete(self, best: Candidate) -> bool:
        """Tell whether the best may be named and leaves nothing that a further effect could explain."""
        return self.leaves_noise(best) and self.followed(best) is None

    def one_is_enough(self) -> bool:
        """Tell whether the best is a single effect, runs alike, that leaves nothing more to explain."""
        best = self.best
        return len(best.effects) == 1 and not best.deviations and self.complete(best)

    def leaves_noise(self, found: Candidate) -> bool:
        """Tell whether a candidate may be named and leaves as little as noise, and as white."""
        if not at_floor(self.fit, self.criteria, found) or barred(self.fit, self.criteria, found):
            return False
        return is_white(self.fit, found, self.criteria.white / 2)

    def lower_floor(self, best: Candidate) -> None:
        """Search on below what costs no more than noise may, and is not at the floor, or where the best follows a law.

        By a tie, or by what that law takes of the best.
        """
        if not best.effects:
            return
        if not at_floor(self.fit, self.criteria, best):
            self.noise_limit = min(self.noise_limit, self._least_above_noise(best) - self.tie)
            return
        law = self.followed(best)
        if law is not None:
            self.noise_limit = min(self.noise_limit, self.nodes[best.key].cost - law.power)

    def _least_above_noise(self, best: Candidate) -> float:
        """Least cost of what is not at the floor and costs no more than noise may, m²; infinite without any.

        With more in it the same rest may cost less. Where something else leaves only noise the best alone is asked.
        """
        now = [c for c in self.candidates.values() if c.effects and self.nodes[c.key].fitted.polished is not None]
        asked = [best] if any(map(self.leaves_noise, now)) else now
        costs = (self.nodes[c.key].cost for c in asked if not at_floor(self.fit, self.criteria, c))
        return min((cost for cost in costs if cost <= self.noise_limit), default=math.inf)

    def followed(self, best: Candidate) -> FreeLaw | None:
        """Law that what the best leaves follows, which may be rough by what its conditions leave it to explain."""
        part = part_left(self.root.cost, self._plain(best.deviations), self.fit.noise_cost)
        return followed(self.fit, self.criteria, best, min(part, 1.0))

    def nameable(self, order: Sequence[Node]) -> Iterator[Node]:
        """Of some nodes those that may be named where a rest remains; none where the first leaves only noise."""
        named = self.named(order)
        first = next(named, None)
        if first is not None and not (first is order[0] and first.cost <= self.noise_limit):
            yield first
            yield from named

    def least(self) -> Node:
        """The node that leaves least, of those at the noise floor one that may be named."""
        order = sorted(self.nodes.values(), key=lambda n: n.cost)
        return next(n for n in order if n.cost > self.noise_limit or any(self.named([n])))

    def named(self, nodes: Sequence[Node]) -> Iterator[Node]:
        """Those of some nodes that may be named."""
        return by.nameable(self.fit, self.criteria, nodes, self.candidates)
