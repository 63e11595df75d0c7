"""What a search still tries where no set of effects is enough."""

from __future__ import annotations

from collections.abc import Sequence

from stepid.diagnosis.selection import order as by
from stepid.diagnosis.selection.candidate import LEADING, Key
from stepid.diagnosis.selection.fits import Fits
from stepid.diagnosis.selection.moves.exchange import Exchange
from stepid.diagnosis.selection.moves.generalize import Generalize
from stepid.diagnosis.selection.promote import promote
from stepid.diagnosis.selection.proposal import Move, Node, Proposal, SearchContext
from stepid.fitting.candidate_fit import is_short
from stepid.simulation.records import mass_span


class Attempts(Fits):
    """Attempts of a search at a campaign that the sets which it has fitted so far do not explain.

    `root` is the linear plant, `context` what moves may use.
    """

    root: Node
    context: SearchContext

    def _try_modes(self) -> bool:
        """Fit a mode beside the best single effect and the best pair, where none was: a step tells nothing of it.

        True where one takes enough, as in `_try_larger`.
        """
        least = self._least().cost
        if least <= self.noise_limit:
            return False
        leads: dict[int, Node] = {}
        for node in self._nameable(self._in_order()):
            if len(node.effects) <= LEADING:
                leads.setdefault(len(node.effects), node)
        for node in leads.values():
            self._expand(node, self.moves.exploring)
        self._fit_all(by.modes(self.proposals, self.nodes, [node.key for node in leads.values()]))
        return self._takes_enough(least)

    def _try_resting(self) -> None:
        """Where no single effect is enough, fit alone those that let runs begin where they stuck: no step tells it.

        To their end: conditions that differ from run to run can leave only noise long before.
        """
        if self._one_is_enough():
            return
        alone = by.resting(self.proposals)
        self._fit_all([p for p in alone if (p.base, p.key) not in self._tried])  # from where it starts alone
        for node in (self.nodes[p.key] for p in alone if p.key in self.nodes):
            node.fitted.run(iterations=self.effort.polishing)
        self._polish_best()

    def _try_larger(self) -> bool:
        """Where no set that may lead is enough, try larger ones: far from linear, a step promises too little of them.

        True where one leaves only noise, or takes as much of what the best of those leaves as a lead has to.
        """
        least = self._least().cost
        if least <= self.noise_limit:
            return False
        base = by.largest_lead(self.nodes.values())
        if base is not None:
            self._expand(base, self.moves.exploring)
        self._expand(self.root, self.moves.together)
        self._fit_all(by.larger(self._able(), self.nodes, base, self.effort.share, self.moves.together), keep=1)
        return self._takes_enough(least)

    def _try_beside(self) -> bool:
        """Where no set is enough, fit further effects beside the best that may lead: a step promises little of some.

        Only where a fit is as short as most are: of long records with fast laws these would take a minute. True where
        one takes enough, as in `_try_larger`.
        """
        least = self._least().cost
        work = sum(node.fitted.work for node in self.nodes.values())
        if least <= self.noise_limit or not is_short(work / len(self.nodes)):
            return False
        for base in by.apart(self.nodes.values(), LEADING, self.effort.beam):
            if self._least().cost > self.noise_limit:
                self._expand(base, self.moves.exploring)
                self._fit_beside(base)
        self._promote()
        return self._takes_enough(least)

    def _try_exchanges(self) -> None:
        """Where the best larger set leaves a rest, exchange its effects, and those of what that leads to.

        Others take their place, or more general laws from where they stand by now.
        """
        aside: set[Key] = set()
        for _ in range(self.effort.beam):
            base = by.largest_beyond(self.nodes.values(), aside)
            if base is None or self._least().cost <= self.noise_limit or self._complete(self._polish_near(base)):
                return
            for move in (Generalize(), Exchange()):
                self.proposals += move.propose(base, self.context)
            exchanges = by.generals(self.proposals, self.nodes, base)
            exchanges += by.exchanges(self.proposals, self.nodes, base, self.effort.width)
            aside = self.nodes.keys() - {p.key for p in exchanges}
            self._fit_all(exchanges)
            self._polish_best()

    def _add_twins(self) -> None:
        """Where all runs have one mass, fit what no motion tells from each candidate: it is as good an answer.

        What the one fit found is the other's, too: the better of both goes to both. What does not lead and costs more
        than twice the best is no answer, and needs none beside it.
        """
        if mass_span(self.fit.records) > 0:
            return
        for _ in range(2):
            order = sorted(self.candidates.values(), key=lambda c: c.optimum.cost)
            leading = self._leading()
            for found in (c for c in order if c in leading or c.optimum.cost <= 2 * order[0].optimum.cost):
                node = self.nodes[found.key]
                for proposal in [p for move in self.moves.same for p in move.propose(node, self.context)]:
                    known = self.candidates.get(proposal.key)
                    if known is None or known.optimum.cost > found.optimum.cost + self.fit.tolerance:
                        self._fit(proposal)
                        if proposal.key in self.nodes:
                            self._polish(self.nodes[proposal.key])

    def _takes_enough(self, least: float) -> bool:
        """Tell whether a set takes as much of what the best so far left [m²] as a lead has to, or leaves only noise."""
        return self._least().cost < max((1 - self.criteria.lead) * least, self.noise_limit)

    def _expand(self, node: Node, moves: Sequence[Move]) -> bool:
        """Make the moves not made yet from a node; True where one was made."""
        new = [m for m in moves if m.name not in node.moves_made]
        for move in new:
            node.moves_made.add(move.name)
            self.proposals += move.propose(node, self.context)
        return bool(new)

    def _fit_all(self, proposals: Sequence[Proposal], keep: int | None = None) -> None:
        """Fit proposals a little, as `_fit` does each; the promising of all sets run on."""
        for proposal in proposals:
            self._fit(proposal, keep)
        self._promote()

    def _promote(self) -> None:
        """Let the promising sets run on."""
        promote(self.nodes.values(), self.fit, self.criteria.tie, self.effort, self._foreseen, self._named)

    def _able(self) -> list[Proposal]:
        """Proposals of which a fit may be found: others have their turn where none was."""
        return [p for p in self.proposals if (p.base, p.key, p.move) not in self._failed]
