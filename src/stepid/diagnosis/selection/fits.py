"""The fits of a search: a proposal is fitted a little, the best of all to all samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import islice

from stepid.diagnosis.evidence import at_floor, block_means
from stepid.diagnosis.selection import conditions as runs
from stepid.diagnosis.selection import order as by
from stepid.diagnosis.selection.candidate import LEADING, Candidate, Key
from stepid.diagnosis.selection.moves.drop import Drop
from stepid.diagnosis.selection.moves.instead import Instead
from stepid.diagnosis.selection.moves.remain import Remain
from stepid.diagnosis.selection.polish import polished
from stepid.diagnosis.selection.promote import promote
from stepid.diagnosis.selection.proposal import Node, Proposal
from stepid.diagnosis.selection.queue import Queue
from stepid.diagnosis.selection.standings import Standings
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.levenberg_marquardt import Optimum

_IN_PLACE = {Instead.name, Remain.name}
_STANDING_IN = {Drop.name, *_IN_PLACE}


class Fits:
    """Fits of proposals on one campaign; what they find goes into the standings.

    Parameters
    ----------
    standings : Standings
    queue : Queue
        Where the proposals come from.
    tell : callable
        Called before each fit of a proposal, with it.
    """

    def __init__(self, standings: Standings, queue: Queue, tell: Callable[[Proposal], None]) -> None:
        self.standings, self.queue, self._tell = standings, queue, tell
        self.fit, self.criteria, self.effort = standings.fit, standings.criteria, standings.effort
        self.count = 0
        self._begun: set[tuple[Optimum, Key]] = set()  # an end, and the set that was fitted again from it

    # ---- a little -------------------------------------------------------------------------------------------------

    def try_all(self, proposals: Sequence[Proposal], keep: int | None = None) -> None:
        """Fit proposals a little, as `attempt` does each; the promising of all sets run on."""
        for proposal in proposals:
            self.attempt(proposal, keep)
        self.promote()

    def attempt(self, proposal: Proposal, keep: int | None = None) -> None:
        """Fit a proposal a little, from so many of its starts."""
        fitted, moves = self._told(proposal), self.queue.moves
        known = self.standings.nodes.get(proposal.key)
        self._begin(fitted, proposal, keep)
        far = keep is not None and proposal.move in moves.at_once  # from a few iterations there is nothing to tell
        if known is not None or far or proposal.move in _STANDING_IN:  # what stands in for more is fitted as well
            fitted.run(iterations=self.effort.polishing if proposal.move in _IN_PLACE else self.effort.promote)
        if known is not None and proposal.move in moves.rivals and fitted.cost > known.cost > proposal.left:
            known.fitted.run(iterations=self.effort.polishing)  # its rival says that this is not its end
        if fitted.best is None:
            self.queue.fail(proposal)
        self._keep(fitted, proposal.key)

    def beside(self, base: Node) -> None:
        """Fit sets of one effect more than a base a few steps, each from its own starts; the best few run on.

        What is missing shows in these steps, where a linearized one foresees nothing.
        """
        racing: list[tuple[CandidateFit, Key]] = []
        for proposal in by.beside(self.queue.proposals, base.key):
            fitted = self._told(proposal)
            starts, iterations = list(proposal.starts), self.effort.begin
            fitted.begin(starts, like=proposal.like, keep=1, iterations=iterations, patient=True)
            racing.append((fitted, proposal.key))
        racing.sort(key=lambda pair: pair[0].cost)
        for place, (fitted, key) in enumerate(racing):
            if place < self.effort.share:
                fitted.run(iterations=self.effort.polishing)
            self._keep(fitted, key)

    def promote(self) -> None:
        """Let the promising sets run on."""
        nodes, foreseen, named = self.standings.nodes.values(), self.standings.foreseen, self.standings.named
        promote(nodes, self.fit, self.criteria.tie, self.effort, foreseen, named)

    def _told(self, proposal: Proposal) -> CandidateFit:
        """Count and tell a proposal that is about to be fitted; its fit, not begun."""
        self.count += 1
        self.queue.take(proposal)
        self._tell(proposal)
        return CandidateFit(self.fit, proposal.effects, proposal.deviations)

    def _begin(self, fitted: CandidateFit, proposal: Proposal, keep: int | None) -> None:
        """Begin a fit from the starts of its proposal, of a new set from those of others of the same set as well."""
        nodes, moves, iterations = self.standings.nodes, self.queue.moves, self.effort.begin
        new = proposal.key not in nodes
        for source in by.sources(proposal, self.queue.proposals, moves.rivals) if new else [proposal]:
            most = keep or (1 if source.move in moves.at_once else self.effort.keep + 1)  # those come near
            starts = by.starts_in_order(source, proposal.effects)
            fitted.begin(starts, like=proposal.like, keep=most, iterations=iterations)
        if proposal.move == Instead.name and (best := nodes[self.standings.best.key]).key[0] <= proposal.key[0]:
            fitted.begin([runs.from_the_best(proposal, best)], like=best.best, keep=1, iterations=iterations)

    def _keep(self, fitted: CandidateFit, key: Key) -> None:
        """Keep a fit that is the first or the best of its set.

        Moves from where it leaves less than half of what it did are made anew: what they promised was of another end.
        """
        known = self.standings.nodes.get(key)
        if fitted.best is None or (known is not None and fitted.cost >= known.cost):
            return
        near = known is not None and fitted.cost >= known.cost / 2
        self.standings.nodes[key] = Node(fitted, known.moves_made if known and near else set())
        if known and not near:
            self.queue.forget(key)

    def _anew(self) -> None:
        """Fit again what leaves more than with fewer conditions free, once from each end of that."""
        for proposal in runs.ended_elsewhere(list(self.standings.nodes.values()), self.standings.tie):
            if (proposal.like, proposal.key) not in self._begun:
                self._begun.add((proposal.like, proposal.key))
                self.attempt(proposal)

    # ---- to all samples -------------------------------------------------------------------------------------------

    def polish_best(self) -> Candidate:
        """Fit the best nodes to all samples; first those that lead the race: what they leave judges the others."""
        self._anew()
        standings = self.standings
        order = standings.in_order()
        first = [order[0], *islice(standings.nameable(order), 1)]
        new = self._polish_new(first)
        worth = self._worth()
        lowest, reach = min(order, key=lambda n: n.cost), self.effort.stuck * self.criteria.tie
        if worth[lowest.key] < min(worth.values()) + reach:
            lower = self._polish_new([lowest])  # by its rest the samples count
            new, worth = new | lower, self._worth() if lower else worth
        best = standings.nodes[min(worth, key=worth.__getitem__)]
        spread = max(self.effort.spread * best.cost, reach * self.fit.unit)
        near = max(worth[best.key] + self.criteria.tie, standings.foreseen(best, spread))
        for node in sorted(standings.nodes.values(), key=lambda n: worth[n.key]):
            asked = len(node.effects) < LEADING or standings.answers(node) or any(node is ahead for ahead in first)
            if worth[node.key] < near and asked and node.key not in new and self._may_win(node):
                self.polish(node)
        self._look_elsewhere(standings.nodes[standings.best.key])
        return standings.best

    def polish_leads(self) -> None:
        """Where a rest remains, fit what may lead to all samples: the first of each size, with runs alike, too.

        Of what the best pair and the best of all hold as well: the verdict asks whether one effect leads alone, though
        runs may differ.
        """
        standings = self.standings
        if standings.complete(standings.best):
            return
        order = standings.in_order()
        able = [n for n in standings.nameable(order) if len(n.effects) <= LEADING]
        leads = [node for alike in by.of_each_size(able) for node in alike[: self.effort.polish]]
        pairs = [*[n for n in able if len(n.effects) == LEADING][:1], standings.nodes[standings.best.key]]
        inside = [node for pair in pairs for node in by.inside(order, [pair])[: self.effort.polish]]
        for node in (*leads, *inside):
            for one in (node, standings.nodes.get((node.key[0], frozenset()), node)):
                if one.fitted.polished is None:
                    self.polish(one)

    def polish_near(self, node: Node) -> Candidate:
        """Fit a node to all samples, kept if it leaves as little as noise: none that is far may decide; the best."""
        candidates = self.standings.candidates
        known = node.key in candidates
        self.polish(node)
        self._look_elsewhere(node)
        found = candidates.get(node.key)
        if found is not None and not (known or at_floor(self.fit, self.criteria, found)):
            del candidates[node.key]
        return self.standings.best

    def polish(self, node: Node) -> None:
        """Fit a node to all samples: it is a candidate then."""
        candidates = self.standings.candidates
        optimum = polished(self.fit, node.fitted, self.effort, candidates.values())
        if optimum is not None:
            white = block_means(self.fit, optimum)
            candidates[node.key] = Candidate(node.effects, node.deviations, optimum, white)

    def _worth(self) -> dict[Key, float]:
        """QBIC of each node as foreseen, as things stand: another fit to all samples changes it."""
        return {key: self.standings.foreseen(node) for key, node in self.standings.nodes.items()}

    def _polish_new(self, nodes: Iterable[Node]) -> set[Key]:
        """Fit nodes to all samples that are not yet, and may win; the keys of those."""
        new = {n.key: n for n in nodes if n.key not in self.standings.candidates and self._may_win(n)}
        for node in new.values():
            self.polish(node)
        return set(new)

    def _may_win(self, node: Node) -> bool:
        """Tell whether a node may be an answer; one that cannot be named is fitted once: it may go on for long."""
        if node.key in self.standings.candidates and not any(self.standings.named([node])):
            return False
        return not by.no_answer(self.standings.noise_limit, node.effects, node.cost / 2)

    def _look_elsewhere(self, node: Node) -> None:
        """Fit a node anew where dry friction may have stopped the cart elsewhere, or a mode may be a stronger one."""
        found = self.standings.candidates.get(node.key)
        able = any(e.dry or (e.n_extra and not e.settled) for e in node.effects)
        if found is None or not able or self.standings.complete(found):
            return
        if node.fitted.other_valleys():
            self.polish(node)
