"""The fits of a search: a proposal is fitted a little, the best of all to all samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import islice

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor, block_means
from stepid.diagnosis.selection import conditions as runs
from stepid.diagnosis.selection import order as by
from stepid.diagnosis.selection.candidate import LEADING, Candidate, Key
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.moves import Moves
from stepid.diagnosis.selection.moves.drop import Drop
from stepid.diagnosis.selection.moves.instead import Instead
from stepid.diagnosis.selection.moves.remain import Remain
from stepid.diagnosis.selection.polish import polished
from stepid.diagnosis.selection.proposal import Node, Proposal
from stepid.diagnosis.selection.standings import Standings
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext

_IN_PLACE = {Instead.name, Remain.name}
_STANDING_IN = {Drop.name, *_IN_PLACE}


class Fits(Standings):
    """Fits of proposals on one campaign, and what they have led to.

    Parameters
    ----------
    fit : FitContext
    criteria : Criteria
    effort : Effort
    moves : Moves
    tell : callable
        Called before each fit of a proposal, with it.
    """

    def __init__(
        self, fit: FitContext, criteria: Criteria, effort: Effort, moves: Moves, tell: Callable[[Proposal], None]
    ) -> None:
        super().__init__(fit, criteria, effort)
        self.moves, self._tell = moves, tell
        self.proposals: list[Proposal] = []
        self.fits = 0
        self._tried: set[tuple[Key, Key]] = set()  # base and set
        self._failed: set[tuple[Key, Key, str]] = set()  # base, set and move: no fit was found
        self._begun: set[tuple[Optimum, Key]] = set()  # an end, and the set that was fitted again from it

    def _fit(self, proposal: Proposal, keep: int | None = None) -> None:
        """Fit a proposal a little, from so many of its starts."""
        fitted = self._told(proposal)
        known = self.nodes.get(proposal.key)
        self._begin(fitted, proposal, keep)
        far = keep is not None and proposal.move in self.moves.at_once  # from a few iterations there is nothing to tell
        if known is not None or far or proposal.move in _STANDING_IN:  # what stands in for more is fitted as well
            fitted.run(iterations=self.effort.polishing if proposal.move in _IN_PLACE else self.effort.promote)
        if known is not None and proposal.move in self.moves.rivals and fitted.cost > known.cost > proposal.left:
            known.fitted.run(iterations=self.effort.polishing)  # its rival says that this is not its end
        if fitted.best is None:
            self._failed.add((proposal.base, proposal.key, proposal.move))
        self._keep(fitted, proposal.key)

    def _begin(self, fitted: CandidateFit, proposal: Proposal, keep: int | None) -> None:
        """Begin a fit from the starts of its proposal, of a new set from those of others of the same set as well."""
        new, iterations = proposal.key not in self.nodes, self.effort.begin
        for source in by.sources(proposal, self.proposals, self.moves.rivals) if new else [proposal]:
            most = keep or (1 if source.move in self.moves.at_once else self.effort.keep + 1)  # those come near
            starts = by.starts_in_order(source, proposal.effects)
            fitted.begin(starts, like=proposal.like, keep=most, iterations=iterations)
        if proposal.move == Instead.name and (best := self.nodes[self.best.key]).key[0] <= proposal.key[0]:
            fitted.begin([runs.from_the_best(proposal, best)], like=best.best, keep=1, iterations=iterations)

    def _fit_beside(self, base: Node) -> None:
        """Fit sets of one effect more than a base a few steps, each from its own starts; the best few run on.

        What is missing shows in these steps, where a linearized one foresees nothing.
        """
        racing: list[tuple[CandidateFit, Key]] = []
        for proposal in by.beside(self.proposals, base.key):
            fitted = self._told(proposal)
            starts, iterations = list(proposal.starts), self.effort.begin
            fitted.begin(starts, like=proposal.like, keep=1, iterations=iterations, patient=True)
            racing.append((fitted, proposal.key))
        racing.sort(key=lambda pair: pair[0].cost)
        for place, (fitted, key) in enumerate(racing):
            if place < self.effort.share:
                fitted.run(iterations=self.effort.polishing)
            self._keep(fitted, key)

    def _told(self, proposal: Proposal) -> CandidateFit:
        """Count and tell a proposal that is about to be fitted; its fit, not begun."""
        self.fits += 1
        self._tried.add((proposal.base, proposal.key))
        self._tell(proposal)
        return CandidateFit(self.fit, proposal.effects, proposal.deviations)

    def _keep(self, fitted: CandidateFit, key: Key) -> None:
        """Keep a fit that is the first or the best of its set.

        Moves from where it leaves less than half of what it did are made anew: what they promised was of another end.
        """
        known = self.nodes.get(key)
        if fitted.best is None or (known is not None and fitted.cost >= known.cost):
            return
        near = known is not None and fitted.cost >= known.cost / 2
        self.nodes[key] = Node(fitted, known.moves_made if known and near else set())
        if known and not near:
            self.proposals = [p for p in self.proposals if p.base != key]
            self._tried = {(base, other) for base, other in self._tried if base != key}
            self._failed = {(base, other, move) for base, other, move in self._failed if base != key}

    def _fit_anew(self) -> None:
        """Fit again what leaves more than with fewer conditions free, once from each end of that."""
        for proposal in runs.ended_elsewhere(list(self.nodes.values()), self._tie):
            if (proposal.like, proposal.key) not in self._begun:
                self._begun.add((proposal.like, proposal.key))
                self._fit(proposal)

    def _polish_best(self) -> Candidate:
        """Fit the best nodes to all samples; first those that lead the race: what they leave judges the others."""
        self._fit_anew()
        order = self._in_order()
        first = [order[0], *islice(self._nameable(order), 1)]
        new = self._polish_new(first)
        worth = self._worth()
        lowest, reach = min(order, key=lambda n: n.cost), self.effort.stuck * self.criteria.tie
        if worth[lowest.key] < min(worth.values()) + reach:
            lower = self._polish_new([lowest])  # by its rest the samples count
            new, worth = new | lower, self._worth() if lower else worth
        best = self.nodes[min(worth, key=worth.__getitem__)]
        spread = max(self.effort.spread * best.cost, reach * self.fit.unit)
        near = max(worth[best.key] + self.criteria.tie, self._foreseen(best, spread))
        for node in sorted(self.nodes.values(), key=lambda n: worth[n.key]):
            asked = len(node.effects) < LEADING or self._answers(node) or any(node is ahead for ahead in first)
            if worth[node.key] < near and asked and node.key not in new and self._may_win(node):
                self._polish(node)
        self._look_elsewhere(self.nodes[self.best.key])
        return self.best

    def _worth(self) -> dict[Key, float]:
        """QBIC of each node as foreseen, as things stand: another fit to all samples changes it."""
        return {key: self._foreseen(node) for key, node in self.nodes.items()}

    def _polish_new(self, nodes: Iterable[Node]) -> set[Key]:
        """Fit nodes to all samples that are not yet, and may win; the keys of those."""
        new = {n.key: n for n in nodes if n.key not in self.candidates and self._may_win(n)}
        for node in new.values():
            self._polish(node)
        return set(new)

    def _may_win(self, node: Node) -> bool:
        """Tell whether a node may be an answer; one that cannot be named is fitted once: it may go on for long."""
        if node.key in self.candidates and not any(self._named([node])):
            return False
        return not by.no_answer(self.noise_limit, node.effects, node.cost / 2)

    def _polish_leads(self) -> None:
        """Where a rest remains, fit what may lead to all samples: the first of each size, with runs alike, too.

        Of what the best pair and the best of all hold as well: the verdict asks whether one effect leads alone, though
        runs may differ.
        """
        if self._complete(self.best):
            return
        order = self._in_order()
        able = [n for n in self._nameable(order) if len(n.effects) <= LEADING]
        leads = [node for alike in by.of_each_size(able) for node in alike[: self.effort.polish]]
        pairs = [*[n for n in able if len(n.effects) == LEADING][:1], self.nodes[self.best.key]]
        inside = [node for pair in pairs for node in by.inside(order, [pair])[: self.effort.polish]]
        for node in (*leads, *inside):
            for one in (node, self.nodes.get((node.key[0], frozenset()), node)):
                if one.fitted.polished is None:
                    self._polish(one)

    def _polish_near(self, node: Node) -> Candidate:
        """Fit a node to all samples, kept if it leaves as little as noise: none that is far may decide; the best."""
        known = node.key in self.candidates
        self._polish(node)
        self._look_elsewhere(node)
        found = self.candidates.get(node.key)
        if found is not None and not (known or at_floor(self.fit, self.criteria, found)):
            del self.candidates[node.key]
        return self.best

    def _look_elsewhere(self, node: Node) -> None:
        """Fit a node anew where dry friction may have stopped the cart elsewhere, or a mode may be a stronger one."""
        found = self.candidates.get(node.key)
        able = any(e.dry or (e.n_extra and not e.settled) for e in node.effects)
        if found is None or not able or self._complete(found):
            return
        if node.fitted.other_valleys():
            self._polish(node)

    def _polish(self, node: Node) -> None:
        optimum = polished(self.fit, node.fitted, self.effort, self.candidates.values())
        if optimum is not None:
            white = block_means(self.fit, optimum)
            self.candidates[node.key] = Candidate(node.effects, node.deviations, optimum, white)
