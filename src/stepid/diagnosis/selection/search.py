"""The search: best first over sets of effects. Moves propose, the most promising proposals are fitted a little."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor
from stepid.diagnosis.selection import conditions as runs
from stepid.diagnosis.selection import order as by
from stepid.diagnosis.selection.attempts import Attempts
from stepid.diagnosis.selection.candidate import Candidate, Key
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.moves import MOVES, Moves
from stepid.diagnosis.selection.moves.deviate import Deviate
from stepid.diagnosis.selection.moves.drop import Drop
from stepid.diagnosis.selection.moves.exchange import Exchange
from stepid.diagnosis.selection.moves.remain import Remain
from stepid.diagnosis.selection.proposal import Move, Node, Proposal, SearchContext, is_mode
from stepid.effects.base import Effect
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.deviations import conditions
from stepid.fitting.multistart import FitContext

Tell = Callable[["Search", Proposal], None]


class Search(Attempts):
    """One search on one campaign.

    Parameters
    ----------
    fit : FitContext
    catalogue : tuple of Effect
    criteria : Criteria
    effort : Effort
    moves : Moves
    tell : callable
        Called with the search before each fit of a proposal, and the proposal.
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
        super().__init__(fit, criteria, effort, moves, lambda proposal: tell(self, proposal))
        self.context = SearchContext(fit, catalogue, effort)
        root = CandidateFit(fit, ())
        root.best, root.polished = fit.coarse_linear, fit.linear
        self.root = Node(root)
        self.nodes[self.root.key] = self.root
        self._polish(self.root)

    # ---- the loop -------------------------------------------------------------------------------------------------

    def run(self) -> list[Candidate]:
        """Search until nothing promises more or the effort is used up; candidates, least cost first."""
        self._explore(self.effort.fits)
        self._try_resting()
        if self._try_modes():
            self._explore(self.fits + self.effort.width)
        if self._try_larger():
            self._explore(self.fits + self.effort.width)
        self._try_exchanges()
        if self._try_beside():
            self._explore(self.fits + self.effort.width)
            self._try_exchanges()
        self._confirm()
        if self._simplify():
            self._confirm()
        self._add_twins()
        return sorted(self.candidates.values(), key=lambda c: c.optimum.cost)

    def _explore(self, most: int) -> None:
        """Go on to sets that explain more, until one leaves only noise, none promises more or `most` are fitted."""
        self._expand(self.root, self.moves.exploring)
        for _ in range(self.effort.rounds):
            batch = self._promising()[: max(most - self.fits, 0)]
            for proposal in batch:
                if not self._idle(proposal):
                    self._fit(proposal)
            if batch:
                self._promote()
            best = self._polish_best()
            if self._complete(best):
                break
            self._lower_floor(best)
            untried = [m for m in self.moves.together if m.name not in self.root.moves_made]
            together = self._expand(self.root, untried[:1])
            if not (self._expand_best(self.moves.exploring) or together or batch):
                break

    def _confirm(self) -> None:
        """Look for rivals of the best: simpler and more general laws, other effects in the place of one."""
        for _ in range(self.effort.rounds):
            self._polish_leads()
            bases = [self.nodes[c.key] for c in self._leading()]
            made = [self._expand(node, self.moves.confirming) for node in bases]
            steady = runs.singles(self.nodes.values(), self.best)
            made += [self._expand(node, (Deviate(),)) for node in steady]
            steady = runs.first_of(steady, self.proposals, Deviate.name, self.effort.beam)
            calmer = runs.calmer(self.nodes.values(), self.best) if at_floor(self.fit, self.criteria, self.best) else []
            made += [self._expand(node, (*self.moves.in_place, Deviate())) for node in calmer]
            steady += calmer  # another condition may be what differs
            remain = self._remaining(calmer)
            steady += [self.nodes[p.base] for p in remain]
            made += [self._expand(self.nodes[p.base], (Deviate(),)) for p in remain]
            keys = {node.key for node in (*bases, *steady)}
            if any(made):
                asked = self._rivals(keys, unforeseen=self._unforeseen())
                asked += runs.instead(self.proposals, self._tried, {node.key for node in calmer}, self.effort.share)
            else:  # what the rounds before had no room for
                asked = self._rivals(keys, most=self.nodes[self.best.key].size)
            asked += remain
            if not asked:
                break
            self._fit_all(asked)
            self._polish_best()

    def _remaining(self, calmer: Sequence[Node]) -> list[Proposal]:
        """Effects in the place of a condition of the best, with all its conditions again, of those not tried yet."""
        best, slack = self.nodes[self.best.key], self._tie
        found = runs.in_place(self.nodes.values(), calmer, best, slack)
        every = [p for node in found for p in Remain(best.deviations).propose(node, self.context)]
        return [p for p in every if (p.base, p.key) not in self._tried]

    def _simplify(self) -> bool:
        """Drop what the answer does not need: a round of rivals may have added it that was the last; True if it did.

        Where a rest remains, what the runs differ by: that may be what an effect did that was added since.
        """
        before = found = self._simplest()
        for _ in range(self.effort.rounds):
            complete = at_floor(self.fit, self.criteria, found)
            if not (complete or found.deviations):
                break
            self._expand(self.nodes[found.key], (Drop(),))
            drops = [p for p in self._rivals({found.key}) if p.move == Drop.name]
            asked = [p for p in drops if complete or p.key[0] == found.key[0]]
            if not asked:
                break
            self._fit_all(asked)
            self._polish_best()
            found = self._simplest()
        return found.key != before.key

    @property
    def left(self) -> int:
        """Proposals that are not fitted yet."""
        return len({p.key for p in self.proposals} - self.nodes.keys())

    @property
    def promise(self) -> float:
        """Largest share of what the best leaves that one of them promises to take."""
        least = min(node.cost for node in self.nodes.values())
        open_ = [p.left for p in self.proposals if p.key not in self.nodes]
        return max(1.0 - min(open_) / least, 0.0) if open_ and least > 0 else 0.0

    def refusal(self, proposal: Proposal) -> str:
        """Say why a proposal has no turn as things stand; '' where it has one as soon as there is room."""
        if (proposal.base, proposal.key) in self._tried:
            return "it was fitted"
        if not self._new(proposal):
            return "its set was fitted, and it does not promise so much less than that left"
        rival, at_once = (proposal.move in some for some in (self.moves.rivals, self.moves.at_once))
        if not at_once and proposal not in self._worthy(lambda p: p.move not in self.moves.at_once):
            return "another proposal of its set, or others of its node, promise more"
        gains = at_once or bool(self._gaining([proposal]))
        if rival and not self._answered():
            return "" if gains and self._may_answer(proposal) else "nothing is answered, and it promises no answer"
        asked = gains or (rival and proposal.move in self._unforeseen())
        return "" if asked else "it promises to leave no less than what it is to better or to rival"

    # ---- proposals ------------------------------------------------------------------------------------------------

    def _expand_best(self, moves: Sequence[Move]) -> bool:
        """Expand the best nodes of those not expanded yet, one for each set of effects, and the best nameable one."""
        order: list[Node] = []
        for node in self._in_order():
            if node.key[0] not in [other.key[0] for other in order]:  # other conditions of it stand for it
                order.append(node)
        beam = order[: self.effort.beam]
        named = next(self._nameable(order), None)
        if named is not None and not any(named is other for other in beam):
            beam.append(named)
        return sum(self._expand(node, moves) for node in beam) > 0

    def _promising(self) -> list[Proposal]:
        """The proposals to fit next: the smallest sets first, of these the most promising; a few larger ones.

        Of those with a further condition that differs from run to run the most promising one.
        """
        found = self._gaining(self._worthy(lambda p: p.move not in self.moves.at_once))
        together = by.first_together(self._able(), self.nodes, self.effort.share, self.moves.together)
        sets = {p.key for p in together}
        found = [p for p in found if p.key not in sets]
        smallest = min((p.size for p in found), default=0)
        first = [p for p in found if p.size == smallest][: self.effort.width]
        larger = [p for p in found if p.size > smallest]
        alike = [p for p in larger if not p.deviations][: self.effort.share]
        apart = [p for p in larger if conditions(p.deviations - p.base[1]) == 1][:1]  # all together promise everything
        return sorted([*first, *together, *alike, *apart], key=lambda p: p.size)  # what needs less is asked first

    def _unforeseen(self) -> frozenset[str]:
        """Moves whose proposals are asked whatever a step promises: beside one effect that leaves noise few are left.

        In its place every other was scored on the linear plant already.
        """
        names = self.moves.unforeseen
        return names - {Exchange.name} if self._one_is_enough() else names

    def _rivals(
        self, bases: Collection[Key], *, unforeseen: Collection[str] = (), most: float = math.inf
    ) -> list[Proposal]:
        """Rivals to fit next, of those proposed on some bases; of some moves a few that no step foresees, too.

        Sets of a `Proposal.size` of at most `most`.
        """
        moves = self.moves.rivals | {Deviate.name}
        new = self._worthy(lambda p: p.base in bases and p.move in moves and p.size <= most)
        found = self._gaining(new)
        beside = [p for p in new if p.move in unforeseen and p not in found][: self.effort.share]
        if not self._answered():  # no rivals, where nothing is named
            found, beside = [p for p in found if self._may_answer(p)], []
        found.sort(key=lambda p: p.move not in (Drop.name, Deviate.name))  # what needs less is asked first
        return [*found, *beside][: self.effort.width]

    def _worthy(self, able: Callable[[Proposal], bool]) -> list[Proposal]:
        """Of some proposals the best of each set that is new, those of each node that promise most of it."""
        best: dict[Key, Proposal] = {}
        for p in filter(able, self.proposals):
            if (p.base, p.key) not in self._tried and (p.key not in best or p.rank < best[p.key].rank):
                best[p.key] = p
        order = sorted(best.values(), key=lambda p: p.rank)
        return [p for p in by.worthy(order, self.nodes, self.effort, self.moves.rivals) if self._new(p)]

    def _gaining(self, proposals: Sequence[Proposal]) -> list[Proposal]:
        """Those that may better the best so far."""
        nodes = sorted(self.nodes.values(), key=lambda n: n.cost)
        named = next(self._nameable(nodes), nodes[0])
        return [p for p in proposals if self._gains(named, p)]

    def _idle(self, proposal: Proposal) -> bool:
        """Tell whether a set is no answer by what its parts left, or promises far less than one at the noise floor."""
        least = self._least()
        if least.cost > self.noise_limit:
            hoped = by.hoped_of_parts(proposal, self.proposals, self.nodes, self.effort)
            return by.no_answer(self.noise_limit, proposal.effects, hoped)
        return by.outdone(proposal, least, self.root, self.proposals, self.effort, self._tie)

    def _new(self, proposal: Proposal) -> bool:
        """Tell whether a set has not been fitted yet, or only to an end that its rival shows to be a poor one."""
        if proposal.key not in self.nodes:
            return True
        if proposal.move not in self.moves.rivals or (proposal.base, proposal.key) in self._tried:
            return False
        known = self.nodes[proposal.key].cost
        if proposal.move == Drop.name and proposal.base == self.best.key and proposal.left > known:
            return True  # a step that leaves more than what is known tells nothing
        # an effect that a set does without for nothing: no matter what others leave; of conditions a step tells nothing
        dropped = proposal.move == Drop.name and proposal.key[0] != proposal.base[0]
        least = self.nodes[proposal.base].cost if dropped else min(node.cost for node in self.nodes.values())
        return by.promises_more(proposal, known, least, self.effort, self.fit, self.criteria)

    def _gains(self, named: Node, proposal: Proposal) -> bool:
        """Tell whether a proposal may better the best that may be named, or rival it or the best of its size."""
        slack = self._tie
        if proposal.move == Drop.name:
            return True  # it may have been stuck, or never tried
        hoped = by.hoped(proposal, self.effort)
        if proposal.move in self.moves.rivals:
            no_answer = by.no_answer(self.fit.noise_limit, proposal.effects, hoped / 2)  # the best may lie above it
            alike = min(node.cost for node in self.nodes.values() if node.size <= proposal.size)
            alike = max(alike, named.cost) if named.effects else alike  # sets that may not be named are no measure
            return not no_answer and proposal.left < alike + self.effort.stuck * slack + self.effort.worth * alike
        if by.no_answer(self.noise_limit, proposal.effects, hoped):
            return False
        return (proposal.base == self.root.key or hoped <= named.cost) and proposal.left < proposal.like.cost - slack

    def _may_answer(self, proposal: Proposal) -> bool:
        """Tell whether a set may leave so little that it is an answer, by what a step promises of it, or a new mode."""
        if any(is_mode(e) for e in proposal.effects if e.name not in proposal.base[0]):
            return True  # a step tells nothing of it
        return by.hoped(proposal, self.effort) <= self._needed(proposal.effects, proposal.deviations)
