"""What was understood of recordings, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stepid.core.base import Array
from stepid.io.guess.draft import Draft, quantities_of_drafts
from stepid.io.guess.file_names import plain_name

_BARS = "▁▂▃▄▅▆▇█"
_WIDE = 16  # characters of a sparkline


def understood(drafts: Sequence[Draft]) -> dict[str, list[str]]:
    """Columns of a table in the words of the plant, a row a draft; what all runs have by default is left out."""
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
    return {say(title): list(map(say, cells)) for title, cells in columns.items()}


def is_unsure(drafts: Sequence[Draft]) -> bool:
    """Say whether anything is taken by its size alone, or as usual: it ends in ``?``."""
    return any(found.assumed for draft in drafts for found in (*draft.units.values(), draft.mass) if found is not None)


def doubts_of(drafts: Sequence[Draft], left_out: Sequence[str] = ()) -> list[str]:
    """What stepid doubts of each run, and which files it does not take, a sentence each."""
    doubts = [f"{draft.named}: {doubt}" for draft in drafts for doubt in draft.doubts]
    return [*doubts, *(f"{refusal}; left out" for refusal in left_out)]


def sparkline(values: Array, *, width: int = _WIDE) -> str:
    """Draw readings, shape (n,), as a line of bars."""
    if values.size == 0:
        return ""
    drawn = np.array([part.mean() for part in np.array_split(values, min(width, values.size))])
    span = float(np.ptp(drawn))
    levels = np.zeros(drawn.size) if span == 0 else (drawn - drawn.min()) / span * (len(_BARS) - 1)
    return "".join(_BARS[int(level)] for level in np.rint(levels))


def sources(drafts: Sequence[Draft]) -> dict[str, list[str]]:
    """Columns of a table, a row a draft: where its time, position and input are from, and in which unit.

    What is not known is ``?``, what is taken by its size alone ends in ``?``.
    """
    return {
        "from": [_file(draft) for draft in drafts],
        "time": [_time(draft) for draft in drafts],
        "position": [_column(draft, "position") for draft in drafts],
        "input": [_input(draft) for draft in drafts],
    }


def _file(draft: Draft) -> str:
    layout = draft.layout
    extra = [str(layout[key]) for key in ("encoding", "sheet") if key in layout]
    if layout.get("decimal") == ",":
        extra.append("decimal ,")
    return draft.file.name + (f" ({', '.join(extra)})" if extra else "")


def _time(draft: Draft) -> str:
    seconds = draft.clock()
    if seconds is not None and seconds.size > 1:
        coarse = draft.has_no_clock and draft.sample_time is None
        step = float(np.mean(np.diff(seconds)) if coarse else np.median(np.diff(seconds)))
    else:
        return _column(draft, "time") if "time" in draft.columns else "?"
    size = max((values.size for values in draft.readings.values()), default=0)
    unit = draft.units.get("time")
    sure = "?" if coarse or (unit is not None and unit.assumed) else ""
    return f"{size} × {1000 * step:.4g} ms{sure}"


def _column(draft: Draft, role: str) -> str:
    if role not in draft.columns:
        return "?"
    unit, scale = draft.units.get(role), draft.scale(role)
    named = "?" if unit is None and scale is None else f"{scale:g} per unit" if unit is None else unit.value
    sure = "?" if unit is not None and unit.assumed and role not in draft.scales else ""
    sign = ", falling" if role == "position" and draft.falling else ""
    return f"{draft.titles[role]} in {named}{sure}{sign}"


def _input(draft: Draft) -> str:
    if "input" in draft.columns:
        return _column(draft, "input")
    if draft.step is not None:
        return f"step {draft.step.value[0]:g} V" if draft.step.value[0] else "release"
    return "release" if draft.release else "?"


def mass_of(draft: Draft) -> str:
    """The added mass."""
    if draft.mass is not None:
        return f"{draft.mass.value:g} kg{'?' if draft.mass.assumed else ''}"
    return "?" if draft.weights is None else f"{draft.weights} × ? kg"
