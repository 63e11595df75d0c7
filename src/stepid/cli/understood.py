"""What stepid understood of recordings, as a table with a sparkline of each record."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from stepid.io.guess.draft import quantities_of_drafts
from stepid.io.guess.file_names import plain_name
from stepid.io.guess.sources import mass_of, sources

if TYPE_CHECKING:
    from stepid.core.base import Array
    from stepid.io.guess.draft import Draft

_BARS = "▁▂▃▄▅▆▇█"
_WIDE = 16  # characters of a sparkline


def show(screen: Console, drafts: Sequence[Draft]) -> None:
    """Print what was understood; what is not known is ``?``, what is taken by its size alone ends in ``?``."""
    columns: dict[str, list[str]] = {
        "run": [draft.name for draft in drafts],
        **sources(drafts),
        "added mass": [mass_of(draft) for draft in drafts],
        "spring": [draft.spring.value for draft in drafts],
        "damper": [draft.damper.value for draft in drafts],
        "record": [sparkline(draft.readings.get("position", np.zeros(0))) for draft in drafts],
    }
    if all(draft.name == plain_name(draft.file.stem) for draft in drafts):
        del columns["run"]
    for label in ("spring", "damper"):
        if all(getattr(draft, label).assumed for draft in drafts):
            del columns[label]
    say = quantities_of_drafts(drafts).text
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in columns:
        table.add_column(say(title), overflow="fold", no_wrap=title in ("record", "added mass"))
    for row in zip(*columns.values(), strict=True):
        table.add_row(*(Text(say(cell)) for cell in row))
    screen.print(table, soft_wrap=False)
    if any(found.assumed for draft in drafts for found in (*draft.units.values(), draft.mass) if found is not None):
        screen.print("What ends in ? no file says: it is taken by its size, or as usual. Check it.", markup=False)
    for draft in drafts:
        for doubt in draft.doubts:
            screen.print(f"{draft.named}: {doubt}", markup=False)


def sparkline(values: Array, *, width: int = _WIDE) -> str:
    """Draw readings, shape (n,), as a line of bars."""
    if values.size == 0:
        return ""
    drawn = np.array([part.mean() for part in np.array_split(values, min(width, values.size))])
    span = float(np.ptp(drawn))
    levels = np.zeros(drawn.size) if span == 0 else (drawn - drawn.min()) / span * (len(_BARS) - 1)
    return "".join(_BARS[int(level)] for level in np.rint(levels))
