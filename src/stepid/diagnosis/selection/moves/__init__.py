"""The moves of the search, one a file; a move of your own is a file and an entry in one of the lists below."""

from __future__ import annotations

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

EXPLORING: tuple[Move, ...] = (Add(), Generalize(), Resemble(), Deviate(), Split(), Drop())
"""Moves to sets that explain more: fitted are the most promising, if they promise to leave less than their node."""

TOGETHER: tuple[Move, ...] = (
    AddTogether(2),
    *(AddTogether(size, along=True) for size in (2, 2 + 1)),
    AddTogether(2 + 1),
)
"""Moves from the linear plant where no smaller set that was fitted first is enough, one after the other."""

CONFIRMING: tuple[Move, ...] = (Generalize(), Specialize(), Regeneralize(), Resemble(), Exchange(), Drop(), Split())
"""Moves to sets that may explain as much: rivals of an answer, fitted where they promise about what the best leaves.

A move in this list and in `EXPLORING` makes rivals in both.
"""

IN_PLACE: tuple[Move, ...] = (Instead(),)
"""Moves from an answer that leaves only noise, without one of the conditions that differ from run to run in it."""

SAME: tuple[Move, ...] = (Twin(),)
"""Moves to sets that no record of one mass tells from what was found: they stand beside it in the end."""

UNFORESEEN = frozenset({Exchange.name, Regeneralize.name})
"""Names of moves of which a linearized step tells little: the nearest are fitted whatever they promise."""

MOVES: tuple[Move, ...] = tuple({m.name: m for m in (*EXPLORING, *TOGETHER, *CONFIRMING, *IN_PLACE, *SAME)}.values())
"""All of them, each once: follows from those above."""
