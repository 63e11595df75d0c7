"""What a search may fit next: the proposals of its moves, and which of them have a turn."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence

from stepid.diagnosis.selection import conditions as runs
from stepid.diagnosis.selection import order as by
from stepid.diagnosis.selection.candidate import Key
from stepid.diagnosis.selection.moves import Moves
from stepid.diagnosis.selection.moves.deviate import Deviate
from stepid.diagnosis.selection.moves.drop import Drop
from stepid.diagnosis.selection.moves.exchange import Exchange
from stepid.diagnosis.selection.moves.remain import Remain
from stepid.diagnosis.selection.proposal import Move, Node, Proposal, SearchContext, is_mode
from stepid.diagnosis.selection.standings import Standings
from stepid.effects.base import Effect
from stepid.fitting.deviations import conditions


class Queue:
    """Proposals of one search.

    Parameters
    ----------
    standings : Standings
        What was fitted so far: by it a proposal is worth a fit or not.
    catalogue : tuple of Effect
    moves : Moves
    """

    def __init__(self, standings: Standings, catalogue: tuple[Effect, ...], moves: Moves) -> None:
        self.standings, self.moves, self.effort = standings, moves, standings.effort
        self.context = SearchContext(standings.fit, catalogue, standings.effort)
        self.proposals: list[Proposal] = []
        self.tried: set[tuple[Key, Key]] = set()  # base and set
        self._failed: set[tuple[Key, Key, str]] = set()  # base, set and move: no fit was found

    @property
    def left(self) -> int:
        """Proposals that are not fitted yet."""
        return len({p.key for p in self.proposals} - self.standings.nodes.keys())

    @property
    def promise(self) -> float:
        """Largest share of what the best leaves that one of them promises to take."""
        nodes = self.standings.nodes
        least = min(node.cost for node in nodes.values())
        open_ = [p.left for p in self.proposals if p.key not in nodes]
        return max(1.0 - min(open_) / least, 0.0) if open_ and least > 0 else 0.0

    # ---- what comes in, and goes ----------------------------------------------------------------------------------

    def expand(self, node: Node, moves: Sequence[Move]) -> bool:
        """Make the moves not made yet from a node; True where one was made."""
        new = [m for m in moves if m.name not in node.moves_made]
        for move in new:
            node.moves_made.add(move.name)
            self.add(node, move)
        return bool(new)

    def add(self, node: Node, *moves: Move) -> None:
        """Add what moves propose from where a node stands now."""
        for move in moves:
            self.proposals += move.propose(node, self.context)

    def expand_best(self, moves: Sequence[Move]) -> bool:
        """Expand the best nodes of those not expanded yet, one for each set of effects, and the best nameable one."""
        order: list[Node] = []
        for node in self.standings.in_order():
            if node.key[0] not in [other.key[0] for other in order]:  # other conditions of it stand for it
                order.append(node)
        beam = order[: self.effort.beam]
        named = next(self.standings.nameable(order), None)
        if named is not None and not any(named is other for other in beam):
            beam.append(named)
        return sum(self.expand(node, moves) for node in beam) > 0

    def take(self, proposal: Proposal) -> None:
        """Note that a proposal has its turn now."""
        self.tried.add((proposal.base, proposal.key))

    def fail(self, proposal: Proposal) -> None:
        """Note that no fit was found of a proposal that had its turn."""
        self._failed.add((proposal.base, proposal.key, proposal.move))

    def forget(self, base: Key) -> None:
        """Take what was proposed from a node out: it has moved far."""
        self.proposals = [p for p in self.proposals if p.base != base]
        self.tried = {(other, key) for other, key in self.tried if other != base}
        self._failed = {(other, key, move) for other, key, move in self._failed if other != base}

    # ---- whose turn it is -----------------------------------------------------------------------------------------

    def promising(self) -> list[Proposal]:
        """The proposals to fit next: the smallest sets first, of these the most promising; a few larger ones.

        Of those with a further condition that differs from run to run the most promising one.
        """
        found = self._gaining(self._worthy(lambda p: p.move not in self.moves.at_once))
        together = by.first_together(self.able(), self.standings.nodes, self.effort.share, self.moves.together)
        sets = {p.key for p in together}
        found = [p for p in found if p.key not in sets]
        smallest = min((p.size for p in found), default=0)
        first = [p for p in found if p.size == smallest][: self.effort.width]
        larger = [p for p in found if p.size > smallest]
        alike = [p for p in larger if not p.deviations][: self.effort.share]
        apart = [p for p in larger if conditions(p.deviations - p.base[1]) == 1][:1]  # all together promise everything
        return sorted([*first, *together, *alike, *apart], key=lambda p: p.size)  # what needs less is asked first

    def rivals(
        self, bases: Collection[Key], *, unforeseen: Collection[str] = (), most: float = math.inf
    ) -> list[Proposal]:
        """Rivals to fit next, of those proposed on some bases; of some moves a few that no step foresees, too.

        Sets of a `Proposal.size` of at most `most`.
        """
        moves = self.moves.rivals | {Deviate.name}
        new = self._worthy(lambda p: p.base in bases and p.move in moves and p.size <= most)
        found = self._gaining(new)
        beside = [p for p in new if p.move in unforeseen and p not in found][: self.effort.share]
        if not self.standings.answered():  # no rivals, where nothing is named
            found, beside = [p for p in found if self._may_answer(p)], []
        found.sort(key=lambda p: p.move not in (Drop.name, Deviate.name))  # what needs less is asked first
        return [*found, *beside][: self.effort.width]

    def unforeseen(self) -> frozenset[str]:
        """Moves whose proposals are asked whatever a step promises: beside one effect that leaves noise few are left.

        In its place every other was scored on the linear plant already.
        """
        names = self.moves.unforeseen
        return names - {Exchange.name} if self.standings.one_is_enough() else names

    def remaining(self, calmer: Sequence[Node]) -> list[Proposal]:
        """Effects in the place of a condition of the best, with all its conditions again, of those not tried yet."""
        best = self.standings.nodes[self.standings.best.key]
        found = runs.in_place(self.standings.nodes.values(), calmer, best, self.standings.tie)
        every = [p for node in found for p in Remain(best.deviations).propose(node, self.context)]
        return [p for p in every if (p.base, p.key) not in self.tried]

    def instead(self, calmer: Sequence[Node]) -> list[Proposal]:
        """The first few effects in the place of a condition of the best, of those not tried yet."""
        return runs.instead(self.proposals, self.tried, {node.key for node in calmer}, self.effort.share)

    def able(self) -> list[Proposal]:
        """Proposals of which a fit may be found: others have their turn where none was."""
        return [p for p in self.proposals if (p.base, p.key, p.move) not in self._failed]

    def idle(self, proposal: Proposal) -> bool:
        """Tell whether a set is no answer by what its parts left, or promises far less than one at the noise floor."""
        standings, limit = self.standings, self.standings.noise_limit
        least = standings.least()
        if least.cost > limit:
            hoped = by.hoped_of_parts(proposal, self.proposals, standings.nodes, self.effort)
            return by.no_answer(limit, proposal.effects, hoped)
        return by.outdone(proposal, least, standings.root, self.proposals, self.effort, standings.tie)

    def refusal(self, proposal: Proposal) -> str:
        """Say why a proposal has no turn as things stand; '' where it has one as soon as there is room."""
        if (proposal.base, proposal.key) in self.tried:
            return "it was fitted"
        if not self._new(proposal):
            return "its set was fitted, and it does not promise so much less than that left"
        rival, at_once = (proposal.move in some for some in (self.moves.rivals, self.moves.at_once))
        if not at_once and proposal not in self._worthy(lambda p: p.move not in self.moves.at_once):
            return "another proposal of its set, or others of its node, promise more"
        gains = at_once or bool(self._gaining([proposal]))
        if rival and not self.standings.answered():
            return "" if gains and self._may_answer(proposal) else "nothing is answered, and it promises no answer"
        asked = gains or (rival and proposal.move in self.unforeseen())
        return "" if asked else "it promises to leave no less than what it is to better or to rival"

    # ---- the gates ------------------------------------------------------------------------------------------------

    def _worthy(self, able: Callable[[Proposal], bool]) -> list[Proposal]:
        """Of some proposals the best of each set that is new, those of each node that promise most of it."""
        best: dict[Key, Proposal] = {}
        for p in filter(able, self.proposals):
            if (p.base, p.key) not in self.tried and (p.key not in best or p.rank < best[p.key].rank):
                best[p.key] = p
        order = sorted(best.values(), key=lambda p: p.rank)
        worthy = by.worthy(order, self.standings.nodes, self.effort, self.moves.rivals)
        return [p for p in worthy if self._new(p)]

    def _gaining(self, proposals: Sequence[Proposal]) -> list[Proposal]:
        """Those that may better the best so far."""
        nodes = sorted(self.standings.nodes.values(), key=lambda n: n.cost)
        named = next(self.standings.nameable(nodes), nodes[0])
        return [p for p in proposals if self._gains(named, p)]

    def _new(self, proposal: Proposal) -> bool:
        """Tell whether a set has not been fitted yet, or only to an end that its rival shows to be a poor one."""
        standings = self.standings
        if proposal.key not in standings.nodes:
            return True
        if proposal.move not in self.moves.rivals or (proposal.base, proposal.key) in self.tried:
            return False
        known = standings.nodes[proposal.key].cost
        if proposal.move == Drop.name and proposal.base == standings.best.key and proposal.left > known:
            return True  # a step that leaves more than what is known tells nothing
        # an effect that a set does without for nothing: no matter what others leave; of conditions a step tells nothing
        dropped = proposal.move == Drop.name and proposal.key[0] != proposal.base[0]
        least = standings.nodes[proposal.base].cost if dropped else min(n.cost for n in standings.nodes.values())
        return by.promises_more(proposal, known, least, self.effort, standings.fit, standings.criteria)

    def _gains(self, named: Node, proposal: Proposal) -> bool:
        """Tell whether a proposal may better the best that may be named, or rival it or the best of its size."""
        standings, slack = self.standings, self.standings.tie
        if proposal.move == Drop.name:
            return True  # it may have been stuck, or never tried
        hoped = by.hoped(proposal, self.effort)
        if proposal.move in self.moves.rivals:
            no_answer = by.no_answer(standings.fit.noise_limit, proposal.effects, hoped / 2)  # the best may lie above
            alike = min(node.cost for node in standings.nodes.values() if node.size <= proposal.size)
            alike = max(alike, named.cost) if named.effects else alike  # sets that may not be named are no measure
            return not no_answer and proposal.left < alike + self.effort.stuck * slack + self.effort.worth * alike
        if by.no_answer(standings.noise_limit, proposal.effects, hoped):
            return False
        better = proposal.base == standings.root.key or hoped <= named.cost
        return better and proposal.left < proposal.like.cost - slack

    def _may_answer(self, proposal: Proposal) -> bool:
        """Tell whether a set may leave so little that it is an answer, by what a step promises of it, or a new mode."""
        if any(is_mode(e) for e in proposal.effects if e.name not in proposal.base[0]):
            return True  # a step tells nothing of it
        return by.hoped(proposal, self.effort) <= self.standings.needed(proposal.effects, proposal.deviations)
