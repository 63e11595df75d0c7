"""The search: best first over sets of effects. Moves propose, the most promising proposals are fitted a little."""

from __future__ import annotations

from collections.abc import Callable

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor
from stepid.diagnosis.selection import conditions as runs
from stepid.diagnosis.selection.attempts import Attempts
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.fits import Fits
from stepid.diagnosis.selection.moves import MOVES, Moves
from stepid.diagnosis.selection.moves.deviate import Deviate
from stepid.diagnosis.selection.moves.drop import Drop
from stepid.diagnosis.selection.proposal import Node, Proposal
from stepid.diagnosis.selection.queue import Queue
from stepid.diagnosis.selection.standings import Standings
from stepid.effects.base import Effect
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.multistart import FitContext

Tell = Callable[["Search", Proposal], None]


class Search:
    """One search on one campaign: what was found, what may be fitted next, and the fits.

    Parameters
    ----------
    fit : FitContext
    catalogue : tuple of Effect
    criteria : Criteria
    effort : Effort
    moves : Moves
    tell : callable
        Called with the search before each fit of a proposal, and the proposal.

    Attributes
    ----------
    standings : Standings
        Sets that were fitted a little, candidates that were fitted to all samples, and which of them leads.
    queue : Queue
        Proposals of the moves, and which of them have a turn.
    fits : Fits
        Fits of both kinds, and their count.
    """

    def __init__(
        self,
        fit: FitContext,
        catalogue: tuple[Effect, ...],
        *,
        criteria: Criteria,
        effort: Effort,
        moves: Moves = MOVES,
        tell: Tell = lambda search, proposal: None,
    ) -> None:
        self.fit, self.criteria, self.effort, self.moves = fit, criteria, effort, moves
        self.standings = Standings(fit, criteria, effort)
        self.queue = Queue(self.standings, catalogue, moves)
        self.fits = Fits(self.standings, self.queue, lambda proposal: tell(self, proposal))
        self._attempts = Attempts(self.fits)
        linear = CandidateFit(fit, ())
        linear.best, linear.polished = fit.coarse_linear, fit.linear
        root = Node(linear)
        self.standings.nodes[root.key] = root
        self.fits.polish(root)

    def run(self) -> list[Candidate]:
        """Search until nothing promises more or the effort is used up; candidates, least cost first."""
        self._explore(self.effort.fits)
        self._attempts.resting()
        if self._attempts.modes():
            self._go_on()
        if self._attempts.larger():
            self._go_on()
        self._attempts.exchanges()
        if self._attempts.beside():
            self._go_on()
            self._attempts.exchanges()
        self._confirm()
        if self._simplify():
            self._confirm()
        self._attempts.twins()
        return sorted(self.standings.candidates.values(), key=lambda c: c.optimum.cost)

    def _explore(self, most: int) -> None:
        """Go on to sets that explain more, until one leaves only noise, none promises more or `most` are fitted."""
        queue, root = self.queue, self.standings.root
        queue.expand(root, self.moves.exploring)
        for _ in range(self.effort.rounds):
            batch = queue.promising()[: max(most - self.fits.count, 0)]
            for proposal in batch:
                if not queue.idle(proposal):
                    self.fits.attempt(proposal)
            if batch:
                self.fits.promote()
            best = self.fits.polish_best()
            if self.standings.complete(best):
                break
            self.standings.lower_floor(best)
            untried = [m for m in self.moves.together if m.name not in root.moves_made]
            together = queue.expand(root, untried[:1])
            if not (queue.expand_best(self.moves.exploring) or together or batch):
                break

    def _go_on(self) -> None:
        """Explore on from what an attempt found."""
        self._explore(self.fits.count + self.effort.width)

    def _confirm(self) -> None:
        """Look for rivals of the best: simpler and more general laws, other effects in the place of one."""
        for _ in range(self.effort.rounds):
            self.fits.polish_leads()
            asked = self._asked()
            if not asked:
                break
            self.fits.try_all(asked)
            self.fits.polish_best()

    def _asked(self) -> list[Proposal]:
        """Rivals of what leads, of single effects beside which runs may differ, and in the place of a condition."""
        standings, queue, best = self.standings, self.queue, self.standings.best
        nodes = standings.nodes
        bases = [nodes[c.key] for c in standings.leading()]
        made = [queue.expand(node, self.moves.confirming) for node in bases]
        steady = runs.singles(nodes.values(), best)
        made += [queue.expand(node, (Deviate(),)) for node in steady]
        steady = runs.first_of(steady, queue.proposals, Deviate.name, self.effort.beam)
        calmer = runs.calmer(nodes.values(), best) if at_floor(self.fit, self.criteria, best) else []
        made += [queue.expand(node, (*self.moves.in_place, Deviate())) for node in calmer]
        steady += calmer  # another condition may be what differs
        remain = queue.remaining(calmer)
        steady += [nodes[p.base] for p in remain]
        made += [queue.expand(nodes[p.base], (Deviate(),)) for p in remain]
        keys = {node.key for node in (*bases, *steady)}
        if not any(made):  # what the rounds before had no room for
            return [*queue.rivals(keys, most=nodes[best.key].size), *remain]
        return [*queue.rivals(keys, unforeseen=queue.unforeseen()), *queue.instead(calmer), *remain]

    def _simplify(self) -> bool:
        """Drop what the answer does not need: a round of rivals may have added it that was the last; True if it did.

        Where a rest remains, what the runs differ by: that may be what an effect did that was added since.
        """
        standings, queue = self.standings, self.queue
        before = found = standings.simplest()
        for _ in range(self.effort.rounds):
            complete = at_floor(self.fit, self.criteria, found)
            if not (complete or found.deviations):
                break
            queue.expand(standings.nodes[found.key], (Drop(),))
            drops = [p for p in queue.rivals({found.key}) if p.move == Drop.name]
            asked = [p for p in drops if complete or p.key[0] == found.key[0]]
            if not asked:
                break
            self.fits.try_all(asked)
            self.fits.polish_best()
            found = standings.simplest()
        return found.key != before.key
