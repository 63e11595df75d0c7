"""The moves of the search, one a file; a move of your own is a file and an entry in one of the lists below."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from stepid.diagnosis.selection.candidate import LEADING
from stepid.diagnosis.selection.moves.add import Add
from stepid.diagnosis.selection.moves.add_together import AddTogether
from stepid.diagnosis.selection.moves.deviate import Deviate
from stepid.diagnosis.selection.moves.drop import Drop
from stepid.diagnosis.selection.moves.exchange import Exchange
from stepid.diagnosis.selection.moves.generalize import Generalize
from stepid.diagnosis.selection.moves.instead import Instead
from stepid.diagnosis.selection.moves.regeneralize import Regeneralize
from stepid.diagnosis.selection.moves.resemble import Resemble
from stepid.diagnosis.selection.moves.specialize import Specialize
from stepid.diagnosis.selection.moves.split import Split
from stepid.diagnosis.selection.moves.twin import Twin
from stepid.diagnosis.selection.proposal import Move


@dataclass(frozen=True)
class Moves:
    """The moves of one search; a move may stand in several lists.

    Parameters
    ----------
    exploring : tuple of Move
        To sets that explain more: fitted are the most promising, if they promise to leave less than their node.
    together : tuple of Move
        From the linear plant where no smaller set that was fitted first is enough, one after the other.
    confirming : tuple of Move
        To sets that may explain as much: rivals of an answer, fitted where they promise about what the best leaves.
    in_place : tuple of Move
        From an answer that leaves only noise, without one of the conditions that differ from run to run in it.
    same : tuple of Move
        To sets that no record of one mass tells from what was found: they stand beside it in the end.
    unforeseen : frozenset of str
        Names of those of which a linearized step tells little: the nearest sets that were not fitted yet are, whatever
        they promise, where something is answered.
    """

    exploring: tuple[Move, ...] = (Add(), Generalize(), Resemble(), Deviate(), Split(), Drop())
    together: tuple[Move, ...] = (
        AddTogether(LEADING),
        *(AddTogether(size, along=True) for size in (LEADING, LEADING + 1)),
        AddTogether(LEADING + 1),
    )
    confirming: tuple[Move, ...] = (Generalize(), Specialize(), Regeneralize(), Resemble(), Exchange(), Drop(), Split())
    in_place: tuple[Move, ...] = (Instead(),)
    same: tuple[Move, ...] = (Twin(),)
    unforeseen: frozenset[str] = frozenset({Exchange.name, Regeneralize.name})

    @cached_property
    def rivals(self) -> frozenset[str]:
        """Names of the moves that make rivals."""
        return frozenset(move.name for move in self.confirming)

    @cached_property
    def at_once(self) -> frozenset[str]:
        """Names of the moves that add several effects at once."""
        return frozenset(move.name for move in self.together)

    @property
    def every(self) -> tuple[Move, ...]:
        """All of them, each once."""
        lists = (self.exploring, self.together, self.confirming, self.in_place, self.same)
        return tuple({move.name: move for some in lists for move in some}.values())


MOVES = Moves()
"""Those of every diagnosis."""
