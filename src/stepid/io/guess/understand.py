"""From files to drafts of runs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stepid.core.base import Array
from stepid.errors import InputError
from stepid.io.ecp import FULL_SCALE, VOLTS_PER_DAC_UNIT
from stepid.io.ecp_layout import EFFORT, SAMPLE, TIME, Export, parse_export
from stepid.io.guess.columns import UNKNOWN, Column, Group, find_columns, group_columns
from stepid.io.guess.draft import ASSUMED, ROLES, Draft, Found, falls
from stepid.io.guess.file_names import FileName, encoder_above, mass_above, plain_name, read_name, sample_time_above
from stepid.io.guess.sizes import input_unit, odd_units, position_unit, time_unit
from stepid.io.guess.text import Block, NoTableError, find_block, needs_delimiter, text_lines
from stepid.io.guess.words import COUNTS, RUN_WORDS
from stepid.io.sample_clock import ENOUGH, fit_sample_time
from stepid.io.side_by_side import run_name
from stepid.io.textfile import as_path, read_bytes
from stepid.io.workbook import is_workbook, sheet_names, workbook_lines

ALL = "all"


def draft_runs(files: Sequence[Path], chosen: Mapping[str, str] | None = None) -> tuple[Draft, ...]:
    """Find out what files of recordings hold.

    Parameters
    ----------
    files : sequence of pathlib.Path
        Delimited text, workbooks (``.xlsx``) and exports of the ECP program, several runs side by side or one a file.
    chosen : mapping, optional
        ``"time"``, ``"position"`` and ``"input"`` to the names of their columns, where somebody has said so; the
        position ``"all"`` says that each column of a position is a run.

    Returns
    -------
    tuple of Draft
        In the order of the files. Names are unique.

    Raises
    ------
    stepid.errors.InputError
        Naming the file: if it is missing, or holds no table of numbers.
    """
    found = [draft for file in files for draft in _file(as_path(file), chosen or {})]
    if len({draft.file.parent for draft in found}) > 1:  # a folder a run
        found = [_named(draft, read_name(draft.file.parent.name), None) for draft in found]
    twice = Counter(draft.name for draft in found)
    out: list[Draft] = []
    for draft in found:
        name = _whence(draft) if twice[draft.name] > 1 else draft.name
        first, number = name, 2
        while any(other.name == name for other in out):
            name, number = f"{first} ({number})", number + 1
        out.append(draft.having(name=name))
    return tuple(out)


def recordings(files: Sequence[Path]) -> tuple[list[Path], tuple[str, ...]]:
    """Tell files with tables from others, such as notes: the files to take, and why others are left out."""
    taken, refused = [], []
    for file in files:
        try:
            _file(as_path(file), {})
        except NoTableError as error:
            refused.append(error.cause)
        else:
            taken.append(file)
    return taken, tuple(refused)


def _whence(draft: Draft) -> str:
    """A longer name: with the file, or where the file is called like its run, that of the folder."""
    stem = plain_name(draft.file.stem)
    return plain_name(draft.file.parent.name) if stem == draft.name else f"{stem}, {draft.name}"


def _file(file: Path, chosen: Mapping[str, str]) -> list[Draft]:
    raw = read_bytes(file)
    where = str(file)
    if is_workbook(raw):
        return _workbook(raw, file, chosen)
    lines, encoding = text_lines(raw, file)
    if encoding is None and (export := _export(lines, where)) is not None:
        return [_from_export(export, file)]
    return _table(lines, file, {} if encoding is None else {"encoding": encoding}, chosen)


def _workbook(raw: bytes, file: Path, chosen: Mapping[str, str]) -> list[Draft]:
    where, out, names = str(file), [], sheet_names(raw, str(file))
    for i, name in enumerate(names):
        try:
            lines = workbook_lines(raw, where, name)
            drafts = _table(lines, file, {"sheet": name} if i else {}, chosen, workbook=True)
        except NoTableError:  # a sheet of notes or pictures
            continue
        said = read_name(name)
        out += [_named(draft, said, plain_name(name)) if len(names) > 1 else draft for draft in drafts]
    if not out:
        raise InputError(f"{where}: no sheet holds a table of numbers that stepid finds", "Save the table as CSV.")
    return out


def _table(
    lines: Sequence[str], file: Path, layout: dict[str, object], chosen: Mapping[str, str], *, workbook: bool = False
) -> list[Draft]:
    block = find_block(lines, str(file), workbook=workbook)
    if block.separator is not None and not workbook and needs_delimiter(block, _last_line(lines).strip(" ")):
        layout = {**layout, "delimiter": block.separator}
    if block.decimal != ".":
        layout = {**layout, "decimal": block.decimal}
    if block.skiprows:
        layout = {**layout, "skiprows": block.skiprows}
    groups = group_columns(find_columns(block, chosen), block, all_runs=chosen.get("position") == ALL)
    return [_from_group(group, block, file, layout, several=len(groups) > 1) for group in groups]


def _last_line(lines: Sequence[str]) -> str:
    """The line by which the table's reader tells the delimiter."""
    return next(line for line in reversed(lines) if line.strip() and not line.lstrip().startswith(("#", "%")))


def _from_group(group: Group, block: Block, file: Path, layout: dict[str, object], *, several: bool) -> Draft:
    columns = {role: column for role in ROLES if (column := getattr(group, role)) is not None}
    readings, doubts = _readings(columns)
    doubts += [group.doubt] if group.doubt else []
    if block.unread:
        layout = {**layout, "stop": block.values.shape[0]}
        doubts.append(f"{block.unread} line(s) below the rows are left out")
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
    draft, said = _named(draft.having(doubts=draft.doubts + odd_units(draft)), group.said, None), read_name(file.stem)
    draft = _named(draft, FileName(None, None, said.spring, said.damper, said.release) if several else said, None)
    draft = _counted(_timed(draft, block), encoder_above(block.above))
    return draft if several else _weighed(draft, mass_above(block.above))


def _readings(columns: Mapping[str, Column]) -> tuple[dict[str, Array], list[str]]:
    """Readings of each column, up to the first that is no number, and what that leaves in doubt."""
    rows = _rows(list(columns.values()), own=[c for role, c in columns.items() if role != "time"])
    doubts, end = [], rows
    for role, column in columns.items():
        missing = np.flatnonzero(~np.isfinite(column.values[:rows]))
        if missing.size:
            doubts.append(f"the {role} is no number in row {int(missing[0]) + 1} of the table")
            end = min(end, int(missing[0]))
    return {role: column.values[:end] for role, column in columns.items()}, doubts


def _timed(draft: Draft, block: Block) -> Draft:
    """Take the sample time from clock times, or from the lines above, where no column has the time."""
    if "time" in draft.columns:
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


def _rows(columns: Sequence[Column], own: Sequence[Column]) -> int:
    """Rows until the record ends; beside a longer one its cells are empty from there on."""
    ends = [int(np.flatnonzero(np.isfinite(c.values))[-1]) + 1 for c in own or columns]
    return max(ends, default=0)


def _label(group: Group, file: Path) -> str:
    words = group.label.lower().split()
    if len(words) == 1:
        return run_name(words[0])
    return (
        group.label
        if words and (RUN_WORDS & set(words) or group.said.mass is not None)
        else (group.label or plain_name(file.stem))
    )


def _unit(role: str, column: Column, readings: Array) -> Found[str] | None:
    if column.unit is not None:
        return Found(column.unit, column.why)
    if readings.size < 2 or column.why == UNKNOWN:
        return None
    by_size = {"time": time_unit, "position": position_unit, "input": input_unit}[role](readings)
    return None if by_size is None else Found(by_size, "its size")


def _named(draft: Draft, said: FileName, prefix: str | None) -> Draft:
    """Add what a name tells where nothing better has."""
    if draft.mass is None and draft.weights is None:
        mass = None if said.mass is None else Found(said.mass, "the name")
        draft = draft.having(mass=mass, weights=said.weights)
    if said.spring is not None and draft.spring.why == ASSUMED:
        draft = draft.having(spring=Found(said.spring, "the name"))
    if said.damper is not None and draft.damper.why == ASSUMED:
        draft = draft.having(damper=Found(said.damper, "the name"))
    if said.release and "input" not in draft.columns:
        draft = draft.having(release=True)
    if prefix is not None:
        single = draft.name == plain_name(draft.file.stem)
        draft = draft.having(name=prefix if single else f"{prefix}, {draft.name}")
    return draft


def _export(lines: Sequence[str], where: str) -> Export | None:
    """Parse an export of the ECP program, None where the lines are none."""
    try:
        export = parse_export(lines, columns=None, where=where)
    except InputError:
        if any("encoder" in line.lower() and "pos" in line.lower() for line in lines[:40]) and any(
            line.lstrip().startswith("[") for line in lines
        ):
            raise
        return None
    return export if any(name.startswith("Encoder ") for name in export.columns) else None


def _from_export(export: Export, file: Path) -> Draft:
    encoders = [name for name in export.columns if name.startswith("Encoder ")]
    moved = [name for name in encoders if np.ptp(export[name]) > 0]
    encoder = (moved or encoders)[0]
    readings = {"position": export[encoder]}
    layout: dict[str, object] = {}
    if encoder != "Encoder 1 Pos":
        layout["encoder"] = int(encoder.split()[1])
    scales, doubts = {}, []
    if EFFORT in export:
        readings["input"] = export[EFFORT]
        largest = float(np.abs(export[EFFORT]).max())
        if export.tabbed:
            scales["input"] = Found(VOLTS_PER_DAC_UNIT, "the program's DAC units")
            if 0 < largest < FULL_SCALE:
                doubts.append("Control Effort may be in volts or DAC units; say which by effort_scale")
        elif largest > FULL_SCALE:
            doubts.append("Control Effort is too large for volts; say its scale by effort_scale")
    time, sample = export.get(TIME), export.get(SAMPLE)
    sample = np.arange(len(export.lines), dtype=np.float64) if sample is None else sample
    known = None
    if time is not None and time.size > 1:
        step, spread = fit_sample_time(sample, time, resolution=export.time_resolution)
        readings["time"] = sample * step
        known = Found(step, "the columns Sample and Time") if spread <= ENOUGH * step else None
    draft = Draft(
        file=file,
        name=plain_name(file.stem),
        format="ecp",
        layout=layout,
        columns={role: role for role in readings},
        titles={"position": encoder, "input": EFFORT, "time": TIME},
        readings=readings,
        units={"position": Found(COUNTS, "the program"), "time": Found("s", "the program")}
        | ({"input": Found("V", "the program")} if EFFORT in export else {}),
        scales=scales,
        sample_time=known,
        falling=falls(readings),
        doubts=tuple(doubts),
    )
    return _named(draft, read_name(file.stem), None)
