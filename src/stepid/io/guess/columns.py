"""Which column of a table is whose: time, position and input of each run, by names, units and content."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stepid.core.base import Array
from stepid.io.guess.content import counts_rows, kind, rises_evenly
from stepid.io.guess.draft import ALL
from stepid.io.guess.file_names import FileName, read_name
from stepid.io.guess.inputs import others, without_triggers
from stepid.io.guess.motion import alike, copies, moves
from stepid.io.guess.run_names import is_within, runs_of, sensors_of, without_run
from stepid.io.guess.text import Block
from stepid.io.guess.words import RUN_WORDS, Role, read_title, role_of, tokens, unit_for

UNKNOWN = "a unit that stepid does not know"
_SENSORS = {"enc", "encoder", "sensor", "cart", "mass", "wagen", "masse", "laser"}


@dataclass(frozen=True)
class Column:
    """One column: its role, its unit and where both are from, its readings, shape (n,), NaN where there is none."""

    index: int
    name: str
    role: Role | None
    unit: str | None
    why: str
    rest: str
    values: Array


@dataclass(frozen=True)
class Group:
    """The columns of one run; `label` tells it from others of the table, `doubt` what is not clear.

    `others` may be the input as well as the one that is taken.
    """

    time: Column | None
    position: Column | None
    input: Column | None
    label: str
    said: FileName
    doubt: str = ""
    choices: tuple[str, ...] = ()
    others: tuple[str, ...] = ()


def find_columns(block: Block, chosen: Mapping[str, str] | None = None) -> tuple[Column, ...]:
    """Give each column of a table its role and unit; what a name leaves open its content may tell.

    `chosen` names the column of a role, or gives its number from 0, where somebody has said so.
    """
    chosen = chosen or {}
    columns: Sequence[Column] = _in_known_units([_titled(block, j) for j in range(block.values.shape[1])])
    told = {role for role, name in chosen.items() if called(columns, name)}
    if "position" in told:  # else an abscissa called x is one of the other positions
        columns = _abscissa_as_time(columns)
    return _by_content(_from_preamble(_as_chosen(columns, chosen), block.above), told)


def _titled(block: Block, index: int) -> Column:
    """A column as its titles tell it: its name, and the line of units below."""
    name, values = block.names[index], block.values[:, index]
    title = read_title(name)
    column = Column(index, name, title.role, title.unit, UNKNOWN if title.doubtful else "its name", title.rest, values)
    if title.role != "other":
        column = _in_units(column, block.units[index])
    return column if np.isfinite(values).any() else replace(column, role="other")


def _in_units(column: Column, below: str) -> Column:
    """Take the unit that the line of units tells, and the role where only one has such a unit."""
    roles: Sequence[Role] = (column.role,) if column.role else ("time", "position", "input")
    known: dict[Role, str] = {role: unit for role in roles if (unit := unit_for(below, role)) is not None}
    if not known:
        return column
    only = next(iter(known)) if len(known) == 1 else None
    return replace(column, role=only, unit=next(iter(known.values())), why="the line of units")


def _in_known_units(columns: Sequence[Column]) -> list[Column]:
    """Take no column of an unknown unit for a position where another has a known one, and moves."""
    sure = any(c.role == "position" and c.unit is not None and moves(c.values) for c in columns)
    return [replace(c, role="other") if sure and c.role == "position" and c.why == UNKNOWN else c for c in columns]


def group_columns(columns: Sequence[Column], block: Block, *, said: str | None = None) -> tuple[Group, ...]:
    """Put the columns of a table together to runs; `said` names that of the position, with `ALL` each is one."""
    times, positions, inputs = ([c for c in columns if c.role == role] for role in ("time", "position", "input"))
    inputs = without_triggers(inputs)
    sure = said is not None and (said == ALL or bool(called(columns, said)))
    if not sure and (doubt := _unclear(times, positions, columns, block)):
        return (_open(doubt, times, inputs, columns),)
    if len(positions) < 2:
        return (_lone(positions, times, inputs, columns, block),)
    labels = _labels(positions, block)
    if said != ALL and not _several_runs(positions, times, inputs, labels, block):
        choices = sensors_of(_called(positions)) or _names(positions, columns)
        doubt = f"several columns may be the position: {', '.join(choices)}" + _said_of_copies(positions, columns)
        return (_open(doubt, times, inputs, columns, *choices),)
    time_labels, input_labels = _labels(times, block), _labels(inputs, block)
    return tuple(
        Group(
            _own(i, positions, labels, times, time_labels),
            position,
            _own(i, positions, labels, inputs, input_labels),
            labels[i],
            read_name(f"{block.groups[position.index]} {position.rest}"),
        )
        for i, position in enumerate(positions)
    )


def _lone(
    positions: Sequence[Column],
    times: Sequence[Column],
    inputs: Sequence[Column],
    columns: Sequence[Column],
    block: Block,
) -> Group:
    """The only run of a table: of one position, with a time and an input that name its run, or of none."""
    if not positions:
        return _open("no column is the position by its name, unit or content", times, inputs, columns)
    (position,) = positions
    label, run = block.groups[position.index], runs_of([position.name])
    times, inputs = ([c for c in others if run and runs_of([c.name]) == run] or others for others in (times, inputs))
    more = _names(others(inputs), columns)
    return Group(_best_time(times), position, next(iter(inputs), None), label, read_name(label), others=more)


def _open(
    doubt: str, times: Sequence[Column], inputs: Sequence[Column], columns: Sequence[Column], *choices: str
) -> Group:
    """A run of which some columns may be the position, any but the time where no choices are given."""
    choices = choices or _names([c for c in columns if c.role != "time"], columns)
    more = _names(others(inputs), columns)
    return Group(_best_time(times), None, next(iter(inputs), None), "", read_name(""), doubt, choices, more)


def _unclear(
    times: Sequence[Column], positions: Sequence[Column], columns: Sequence[Column], block: Block
) -> str | None:
    """Why a column called a position cannot be taken for it without a question."""
    width = block.values.shape[1]
    if block.unmatched:
        names = f"{len(block.unmatched)} columns ({', '.join(block.unmatched)})"
        return f"the header names {names} above rows of {width}: say by number from 0 which is which"
    clock = next((c for c in positions if rises_evenly(c.values)), None)
    if clock is None or times or block.clock is not None:
        return None
    (name,) = _names([clock], columns)
    return f"column {name!r} rises evenly from row to row, as a time does, and no other is the time"


def _called(columns: Sequence[Column]) -> list[str]:
    return [c.name for c in columns]


def _names(columns: Sequence[Column], every: Sequence[Column]) -> tuple[str, ...]:
    """What columns can be called by: their names, or their numbers from 0 where they have none, or others the same."""
    names = _called(every)
    return tuple(c.name if c.name and names.count(c.name) == 1 else str(c.index) for c in columns)


def called(columns: Sequence[Column], name: str) -> list[int]:
    """Indices of the columns of a name, in whichever run; of those with numbers if any has; else the number from 0."""
    for called_so in (
        [c for c in columns if name in (c.name, c.rest)],
        [c for c in columns if name == str(c.index)],
        [c for c in columns if name and name == without_run(c.name)],
    ):
        filled = [c.index for c in called_so if np.isfinite(c.values).any()]
        if called_so:
            return filled or [c.index for c in called_so]
    return []


def _as_chosen(columns: Sequence[Column], chosen: Mapping[str, str]) -> list[Column]:
    """Give the columns that somebody named their roles, and no other column these."""
    out = list(columns)
    for role, name in chosen.items():
        if mine := called(columns, name):
            out = [
                replace(c, role=role) if c.index in mine else replace(c, role="other") if c.role == role else c  # type: ignore[arg-type]
                for c in out
            ]
    return out


def _from_preamble(columns: Sequence[Column], above: Sequence[str]) -> list[Column]:
    """Take units that lines above the header tell: "position: mm", "Time unit: ms"."""
    told: dict[str, str] = {}
    for line in above:
        match = re.fullmatch(r"\W*(.*?)\s*(?:[:=;,\t]|\s-\s)\s*\W?([^\s\d\])]{1,12})\W*", line.strip())
        role = role_of(re.sub(r"(?i)\b(units?|einheit|unité)\b", "", match[1])) if match else None
        if match and role in ("time", "position", "input") and (unit := unit_for(match[2], str(role))):
            told.setdefault(str(role), unit)
    return [
        Column(c.index, c.name, c.role, told[c.role], "the lines above", c.rest, c.values)
        if c.unit is None and c.why != UNKNOWN and c.role in told
        else c
        for c in columns
    ]


def _by_content(columns: Sequence[Column], told: Collection[str]) -> tuple[Column, ...]:
    """Roles of columns whose names tell none; a role that somebody `told` has its column already."""
    columns = _abscissa_as_time(columns)
    found = {c.role for c in columns}
    rests = "position" in found and not any(moves(c.values) for c in columns if c.role == "position")
    if rests:  # another that moves may be the position, too
        found.remove("position")
    named = any(c.name for c in columns)
    if not named:
        found &= {"time"}  # without names, several columns may be positions or inputs
    taken: set[str | None] = {*told, *found}
    out = []
    for c in columns:
        if c.role is None:
            looks = "other" if named and not c.name and counts_rows(c.values) else kind(c.values, c.index)
            still = rests and looks == "position" and not moves(c.values)
            c = replace(c, role="other" if still or looks in taken else looks)
            if looks == "time":  # another that rises evenly is none
                taken.add("time")
        out.append(c)
    return tuple(out)


def _abscissa_as_time(columns: Sequence[Column]) -> Sequence[Column]:
    """Of several columns called x, the first that rises evenly is the abscissa, where none is called time."""
    positions = [c for c in columns if c.role == "position"]
    if len(positions) < 2 or any(c.role == "time" for c in columns):
        return columns
    abscissa = next((c for c in positions if c.unit is None and kind(c.values, c.index) == "time"), None)
    return [replace(c, role="time") if c is abscissa else c for c in columns]


def _best_time(times: Sequence[Column]) -> Column | None:
    return next((c for c in times if c.unit), times[0] if times else None)


def _labels(columns: Sequence[Column], block: Block) -> list[str]:
    """What tells columns of one role apart: their names without what they have in common."""
    names = [f"{block.groups[c.index]} {c.rest}" if block.groups[c.index] else c.rest for c in columns]
    split = [re.findall(r"\d+(?:[.,]\d+)?|[^\W\d_]+", name) for name in names]
    if len(split) < 2:
        return ["" for _ in split]
    common = set.intersection(*(({word.lower() for word in words}) for words in split))
    kept = [[w for w in words if w.lower() not in common or w.lower() in RUN_WORDS] for words in split]
    runs = runs_of(_called(columns))
    one = len({without_run(c.name) for c in columns}) == 1 and len(set(runs)) == len(columns)  # "Ch 1+2 Run #1", "… #2"
    return runs if one else [" ".join(words) for words in kept]


def _several_runs(
    positions: Sequence[Column],
    times: Sequence[Column],
    inputs: Sequence[Column],
    labels: Sequence[str],
    block: Block,
) -> bool:
    """Say whether columns of positions are runs, and not sensors of one run."""
    if len(set(labels)) < len(labels) or sensors_of(_called(positions)):
        return False
    ends = {int(np.flatnonzero(np.isfinite(c.values))[-1]) for c in positions}
    if len(ends) > 1 or any(block.groups) or any(read_name(f"{c.rest}").mass is not None for c in positions):
        return True
    words = {word for c in positions for word in tokens(c.rest)}
    if len(times) == len(positions) or (words & RUN_WORDS and not words & _SENSORS):
        return True
    if len(inputs) != len(positions):
        return False
    # of a linear plant runs are alike to scale, too, but then their inputs are by as much
    found = copies([c.values for c in positions])
    return not found or alike(*([positions[i].values, inputs[i].values] for i in found))


def _said_of_copies(positions: Sequence[Column], every: Sequence[Column]) -> str:
    pair = _names([positions[i] for i in copies([c.values for c in positions])], every)
    return f"; {' and '.join(pair)} are one motion, to scale" if pair else ""


def _own(
    i: int, positions: Sequence[Column], labels: Sequence[str], others: Sequence[Column], other_labels: Sequence[str]
) -> Column | None:
    """The column of another role that belongs to a run: of its label, or the only one, or the nearest."""
    if len(others) < 2:
        return others[0] if others else None
    if len(others) == len(positions):
        same = [c for c, label in zip(others, other_labels, strict=True) if label.lower() == labels[i].lower()]
        return same[0] if len(same) == 1 else others[i]
    same = [c for c, label in zip(others, other_labels, strict=True) if label and is_within(label, labels[i])]
    return same[0] if len(same) == 1 else None
