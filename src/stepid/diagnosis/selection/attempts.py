"""What a search still tries where no set of effects is enough."""

from __future__ import annotations

from stepid.diagnosis.selection import order as by
from stepid.diagnosis.selection.candidate import LEADING, Key
from stepid.diagnosis.selection.fits import Fits
from stepid.diagnosis.selection.moves.exchange import Exchange
from stepid.diagnosis.selection.moves.generalize import Generalize
from stepid.diagnosis.selection.proposal import Node
from stepid.fitting.candidate_fit import is_short
from stepid.simulation.records import mass_span


class Attempts:
    """Attempts at a campaign that the sets which were fitted so far do not explain.

    Parameters
    ----------
    fits : Fits
    """

    def __init__(self, fits: Fits) -> None:
        self.fits, self.queue, self.standings = fits, fits.queue, fits.standings
        self.fit, self.effort = fits.fit, fits.effort

    def modes(self) -> bool:
        """Fit a mode beside the best single effect and the best pair, where none was: a step tells nothing of it.

        True where one takes enough, as in `larger`.
        """
        least = self._least
        if least <= self.standings.noise_limit:
            return False
        leads = self._leads()
        for node in leads:
            self.queue.expand(node, self.queue.moves.exploring)
        self.fits.try_all(by.modes(self.queue.proposals, self.standings.nodes, [node.key for node in leads]))
        return self._takes_enough(least)

    def resting(self) -> None:
        """Where no single effect is enough, fit alone those that let runs begin where they stuck: no step tells it.

        To their end: conditions that differ from run to run can leave only noise long before.
        """
        if self.standings.one_is_enough():
            return
        alone, nodes = by.resting(self.queue.proposals), self.standings.nodes
        self.fits.try_all([p for p in alone if (p.base, p.key) not in self.queue.tried])  # from where it starts alone
        for node in (nodes[p.key] for p in alone if p.key in nodes):
            node.fitted.run(iterations=self.effort.polishing)
        self.fits.polish_best()

    def larger(self) -> bool:
        """Where no set that may lead is enough, try larger ones: far from linear, a step promises too little of them.

        True where one leaves only noise, or takes as much of what the best of those leaves as a lead has to.
        """
        least = self._least
        if least <= self.standings.noise_limit:
            return False
        nodes, together = self.standings.nodes, self.queue.moves.together
        base = by.largest_lead(nodes.values())
        if base is not None:
            self.queue.expand(base, self.queue.moves.exploring)
        self.queue.expand(self.standings.root, together)
        self.fits.try_all(by.larger(self.queue.able(), nodes, base, self.effort.share, together), keep=1)
        return self._takes_enough(least)

    def beside(self) -> bool:
        """Where no set is enough, fit further effects beside the best that may lead: a step promises little of some.

        Only where a fit is as short as most are: of long records with fast laws these would take a minute. True where
        one takes enough, as in `larger`.
        """
        least, nodes = self._least, self.standings.nodes
        work = sum(node.fitted.work for node in nodes.values())
        if least <= self.standings.noise_limit or not is_short(work / len(nodes)):
            return False
        for base in by.apart(nodes.values(), LEADING, self.effort.beam):
            if not self._enough():
                self.queue.expand(base, self.queue.moves.exploring)
                self.fits.beside(base)
        self.fits.promote()
        return self._takes_enough(least)

    def exchanges(self) -> None:
        """Where the best larger set leaves a rest, exchange its effects, and those of what that leads to.

        Others take their place, or more general laws from where they stand by now.
        """
        aside: set[Key] = set()
        nodes = self.standings.nodes
        for _ in range(self.effort.beam):
            base = by.largest_beyond(nodes.values(), aside)
            if base is None or self._enough() or self.standings.complete(self.fits.polish_near(base)):
                return
            self.queue.add(base, Generalize(), Exchange())
            exchanges = by.generals(self.queue.proposals, nodes, base)
            exchanges += by.exchanges(self.queue.proposals, nodes, base, self.effort.width)
            aside = nodes.keys() - {p.key for p in exchanges}
            self.fits.try_all(exchanges)
            self.fits.polish_best()

    def twins(self) -> None:
        """Where all runs have one mass, fit what no motion tells from each candidate: it is as good an answer.

        What the one fit found is the other's, too: the better of both goes to both. What does not lead and costs more
        than twice the best is no answer, and needs none beside it.
        """
        if mass_span(self.fit.records) > 0:
            return
        nodes, candidates, same = self.standings.nodes, self.standings.candidates, self.queue.moves.same
        for _ in range(2):
            order = sorted(candidates.values(), key=lambda c: c.optimum.cost)
            leading = self.standings.leading()
            for found in (c for c in order if c in leading or c.optimum.cost <= 2 * order[0].optimum.cost):
                for proposal in [p for move in same for p in move.propose(nodes[found.key], self.queue.context)]:
                    known = candidates.get(proposal.key)
                    if known is None or known.optimum.cost > found.optimum.cost + self.fit.tolerance:
                        self.fits.attempt(proposal)
                        if proposal.key in nodes:
                            self.fits.polish(nodes[proposal.key])

    def _leads(self) -> list[Node]:
        """The best single effect and the best pair."""
        leads: dict[int, Node] = {}
        for node in self.standings.nameable(self.standings.in_order()):
            if len(node.effects) <= LEADING:
                leads.setdefault(len(node.effects), node)
        return list(leads.values())

    @property
    def _least(self) -> float:
        """What the best so far leaves in the race, m²."""
        return self.standings.least().cost

    def _enough(self) -> bool:
        """Tell whether a set that may be named leaves only noise in the race."""
        return self._least <= self.standings.noise_limit

    def _takes_enough(self, least: float) -> bool:
        """Tell whether a set takes as much of what the best so far left [m²] as a lead has to, or leaves only noise."""
        return self._least < max((1 - self.standings.criteria.lead) * least, self.standings.noise_limit)
