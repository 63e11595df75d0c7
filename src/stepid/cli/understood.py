"""What stepid understood of recordings, as a table with a sparkline of each record."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table
from rich.text import Text

from stepid.io.guess.campaign_draft import UNSURE
from stepid.io.guess.draft import quantities_of_drafts
from stepid.io.guess.sources import doubts_of, is_unsure, understood

if TYPE_CHECKING:
    from stepid.io.guess.draft import Draft

_WORD = 24  # letters; a longer name may be broken


def show(screen: Console, drafts: Sequence[Draft], left_out: Sequence[str]) -> None:
    """Print what was understood; what is not known is ``?``, what is taken by its size alone ends in ``?``."""
    columns = understood(drafts)
    table = Table(box=None, pad_edge=False, header_style="bold")
    kept = ("record", quantities_of_drafts(drafts).text("added mass"))
    for title, cells in columns.items():
        words = max(len(word) for text in (title, *cells) for word in (text.split() or [""]))
        table.add_column(title, overflow="fold", no_wrap=title in kept, min_width=min(words, _WORD))
    for row in zip(*columns.values(), strict=True):
        table.add_row(*map(Text, row))
    screen.print(table, soft_wrap=False)
    if is_unsure(drafts):
        screen.print(UNSURE, markup=False)
    for line in doubts_of(drafts, left_out):
        screen.print(line, markup=False)
