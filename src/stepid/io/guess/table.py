"""From a table of numbers to drafts of the runs that it holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stepid.core.base import Array
from stepid.core.words import counted
from stepid.errors import InputError
from stepid.io.guess.columns import UNKNOWN, Column, Group, called, find_columns, group_columns
from stepid.io.guess.draft import ALL, ROLES, Draft, Found, falls
from stepid.io.guess.file_names import FileName, encoder_above, mass_above, plain_name, read_name, sample_time_above
from stepid.io.guess.named import named
from stepid.io.guess.sizes import input_unit, odd_units, position_unit, time_unit
from stepid.io.guess.text import Block, find_block, needs_delimiter
from stepid.io.guess.words import COUNTS
from stepid.io.one_below import check_one_run
from stepid.io.plain_table import Places
from stepid.io.side_by_side import run_name


def from_table(
    lines: Sequence[str], file: Path, layout: dict[str, object], chosen: Mapping[str, str], *, workbook: bool = False
) -> list[Draft]:
    """Find the table among lines, and the runs in it: one, or several side by side.

    Parameters
    ----------
    lines : sequence of str
    file : pathlib.Path
    layout : dict
        What its reader has to be told already.
    chosen : mapping
        As in `stepid.io.guess.understand.draft_runs`.
    workbook : bool
        Whether the lines come from a workbook.

    Raises
    ------
    stepid.errors.InputError
        If the lines hold no table of numbers, or one that breaks off at a line in it.
    """
    where = f"{file}, sheet {layout['sheet']!r}" if "sheet" in layout else str(file)
    block = find_block(lines, where, workbook=workbook)
    delimiter = block.separator if not workbook and needs_delimiter(block, lines) else None
    layout = {**layout, **_layout_keys(block, delimiter)}
    if block.clock is not None:  # which tells the time of a column of clock times
        chosen = {role: name for role, name in chosen.items() if role != "time" or not _texts(block, name)}
    columns = find_columns(block, chosen)
    _check_numbers(columns, chosen, where)
    every = tuple((c.name or str(c.index), c.unit) for c in columns)
    groups = group_columns(columns, block, said=chosen.get("position"))
    drafts = [_from_group(group, block, file, layout, several=len(groups) > 1) for group in groups]
    for draft in drafts:
        _check_one_run(draft, block, where)
    lacking = _lacking(columns, chosen)
    if any(group.position is None for group in groups):
        lacking |= _ambiguous(columns, chosen)
    return [draft.having(every=every, lacking=lacking) for draft in drafts]


def _layout_keys(block: Block, delimiter: str | None) -> dict[str, object]:
    """What a table's reader has to be told because it takes something else by itself."""
    keys: dict[str, object] = {"delimiter": delimiter, "decimal": block.decimal, "skiprows": block.skiprows}
    usual = {"delimiter": None, "decimal": ".", "skiprows": 0}
    return {key: value for key, value in keys.items() if value != usual[key]}


def _texts(block: Block, name: str) -> bool:
    """Tell whether a column that somebody named holds texts alone."""
    mine = called(find_columns(block), name)
    return bool(mine) and not np.isfinite(block.values[:, mine]).any()


def _check_numbers(columns: Sequence[Column], chosen: Mapping[str, str], where: str) -> None:
    """Refuse a column of texts, such as clock times that tell no sample time, for any role."""
    for role, name in chosen.items():
        mine = called(columns, name)
        if mine and not np.isfinite(columns[mine[0]].values).any():
            able = ", ".join(c.name or str(c.index) for c in columns if np.isfinite(c.values).any())
            without = ", or leave it out and give sample_time=… (s)" if role == "time" else ""
            raise InputError(
                f"{where}: column {name if name.isdigit() else repr(name)} for {role} holds no numbers",
                f"Give a column of numbers ({able}){without}.",
            )


def _lacking(columns: Sequence[Column], chosen: Mapping[str, str]) -> dict[str, str]:
    """Which of the columns that were named are not there, by role, in words."""
    titles = [c.name or "(no name)" for c in columns]
    no_names = not any(c.name for c in columns)
    listed = f"no header; columns count from 0 to {len(titles) - 1}" if no_names else ", ".join(titles)
    return {
        role: f"has no column {name if name.isdigit() else repr(name)} for {role} ({listed})"
        for role, name in chosen.items()
        if (role, name) != ("position", ALL) and not called(columns, name)
    }


def _ambiguous(columns: Sequence[Column], chosen: Mapping[str, str]) -> dict[str, str]:
    """The position, in words, where several columns have the name that was given for it."""
    twice = called(columns, chosen["position"]) if "position" in chosen else []
    if len(twice) < 2:
        return {}
    numbers = ", ".join(map(str, twice))
    return {"position": f"has {len(twice)} columns {chosen['position']!r} for position ({numbers})"}


def _check_one_run(draft: Draft, block: Block, where: str) -> None:
    """Refuse a table of several runs one below the other: as one record it could not be read."""
    time, unit = draft.readings.get("time"), draft.units.get("time")
    if time is not None and time.size:
        places = Places([(where, block.lines[: time.size])])
        check_one_run(time, places, unit="" if unit is None else f" {unit.value}")


def _from_group(group: Group, block: Block, file: Path, layout: dict[str, object], *, several: bool) -> Draft:
    columns = {role: column for role in ROLES if (column := getattr(group, role)) is not None}
    readings, doubts = _readings(columns)
    doubts += _doubts(group)
    rows = block.values.shape[0]
    ends = _ends(columns) if several else rows
    if block.unread or ends < rows:
        layout = {**layout, "stop": ends}  # not all names of columns tell the reader that another run goes on
    if block.unread:
        doubts.append(f"{counted(block.unread, 'line')} below the rows {'is' if block.unread == 1 else 'are'} left out")
    draft = Draft(
        file=file,
        name=_label(group, file) if several else plain_name(file.stem),
        layout=layout,
        columns={role: c.name if block.by_name and c.name else c.index for role, c in columns.items()},
        titles={role: c.name or f"column {c.index}" for role, c in columns.items()},
        readings=readings,
        units={role: unit for role, c in columns.items() if (unit := _unit(role, c, readings[role])) is not None},
        falling=falls(readings),
        doubts=tuple(doubts),
        choices=group.choices,
    )
    draft, said = named(draft.having(doubts=draft.doubts + odd_units(draft)), group.said, None), read_name(file.stem)
    draft = named(draft, FileName(None, None, said.spring, said.damper, said.release) if several else said, None)
    draft = _counted(_timed(draft, block), encoder_above(block.above))
    return draft if several else _weighed(draft, mass_above(block.above))


def _doubts(group: Group) -> list[str]:
    """What is not clear about a run's columns."""
    out = []
    if group.others and group.input is not None:
        taken = group.input.name or f"column {group.input.index}"
        out.append(f"{', '.join(group.others)} may be the input, too; {taken} is taken: say input=…")
    return [*out, group.doubt] if group.doubt else out


def _readings(columns: Mapping[str, Column]) -> tuple[dict[str, Array], list[str]]:
    """Readings of each column, up to the first that is no number, and what that leaves in doubt."""
    rows = _ends(columns)
    doubts, end = [], rows
    for role, column in columns.items():
        missing = np.flatnonzero(~np.isfinite(column.values[:rows]))
        if missing.size:
            doubts.append(f"the {role} is no number in row {int(missing[0]) + 1} of the table")
            end = min(end, int(missing[0]))
    return {role: column.values[:end] for role, column in columns.items()}, doubts


def _timed(draft: Draft, block: Block) -> Draft:
    """Take the sample time from clock times, or from the lines above, where no column tells it."""
    if not draft.has_no_clock:
        return draft
    if block.clock is not None:
        return draft.having(sample_time=Found(block.clock, "the clock times of its rows"))
    period = sample_time_above(block.above)
    return draft if period is None else draft.having(sample_time=Found(period, "the lines above"))


def _weighed(draft: Draft, above: float | None) -> Draft:
    """Take the added mass from the lines above where the name says none; another one there is a doubt."""
    if above is None:
        return draft
    if draft.mass is None:
        return draft.having(mass=Found(above, "the lines above"))
    if abs(above - draft.mass.value) <= 1e-9:
        return draft
    words = f"its name says {draft.mass.value:g} kg, the lines above {above:g} kg; the name is taken"
    return draft.having(doubts=(*draft.doubts, words))


def _counted(draft: Draft, told: tuple[float, bool] | None) -> Draft:
    """Take what one count of the encoder is; an angle is kept apart, as it may be that of a wheel on a rail."""
    unit = draft.units.get("position")
    if told is None or unit is None or unit.value != COUNTS:
        return draft
    found = Found(told[0], "the lines above")
    return draft.having(turn=found) if told[1] else draft.having(scales={**draft.scales, "position": found})


def _ends(columns: Mapping[str, Column]) -> int:
    """Rows until the record ends; beside a longer one its cells are empty from there on."""
    own = [column for role, column in columns.items() if role != "time"] or list(columns.values())
    return max((int(np.flatnonzero(np.isfinite(c.values))[-1]) + 1 for c in own), default=0)


def _label(group: Group, file: Path) -> str:
    words = group.label.lower().split()
    if len(words) == 1:
        return run_name(words[0])
    return group.label or plain_name(file.stem)


def _unit(role: str, column: Column, readings: Array) -> Found[str] | None:
    if column.unit is not None:
        return Found(column.unit, column.why)
    if readings.size < 2 or column.why == UNKNOWN:
        return None
    by_size = {"time": time_unit, "position": position_unit, "input": input_unit}[role](readings)
    return None if by_size is None else Found(by_size, "its size")
