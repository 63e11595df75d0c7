"""Delimited tables of numbers: one file or several that continue each other."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stepid._base import Array
from stepid.ecp import FEWEST, check_number
from stepid.errors import InputError
from stepid.experiment import Experiment
from stepid.plausible import NO_COLUMN, check_release, check_scale, check_travel
from stepid.step_input import InputValues, sample_input
from stepid.textfile import as_path, common_width, is_name, is_number, parse_numbers, read_lines

Column = str | int
_REPAIR = (
    "Restore the line, or remove it if it holds no readings: one line of names may come first; comments start with #."
)


@dataclass(frozen=True)
class _Table:
    names: tuple[str, ...]  # empty without a header
    values: Array
    places: Sequence[str]  # "file, line n" of each row

    @property
    def listed(self) -> str:
        width = self.values.shape[1]
        return ", ".join(self.names) if self.names else f"no header; columns count from 0 to {width - 1}"

    def column(self, which: object, role: str, where: str) -> Array:
        width = self.values.shape[1]
        if isinstance(which, str) and which in self.names:
            index = self.names.index(which)
        elif isinstance(which, int) and not isinstance(which, bool) and 0 <= which < width:
            index = which
        else:
            remedy = f"Correct {role}=…{', or give ' + NO_COLUMN if role == 'input' else ''}."
            raise InputError(f"{where}: has no column {which!r} for {role} ({self.listed})", remedy)
        values: Array = self.values[:, index]
        return values


def read_table(
    paths: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    position: Column | None = None,
    time: Column | None = None,
    input: Column | InputValues | None = None,
    position_scale: float = 1.0,
    time_scale: float = 1.0,
    input_scale: float = 1.0,
    sample_time: float | None = None,
    name: str | None = None,
    added_mass: float = 0.0,
    spring: str = "spring",
    damper: str = "damper",
    base: str = "cart",
    counts_per_meter: float | None = None,
    input_before: float = 0.0,
    delimiter: str | None = None,
    start: int = 0,
    stop: int | None = None,
) -> Experiment:
    """Read a record from delimited text.

    Lines that start with ``#`` or ``%`` are comments. A first line that holds anything but numbers names the columns.

    Parameters
    ----------
    paths : path-like or sequence of path-like
        One file, or several that continue each other, joined in order.
    position : str or int
        Column of the position, by name or by index from 0. Must be given; the error without it lists the columns.
    time : str or int, optional
        Column of the time, s. Without it, `sample_time` says how far rows are apart.
    input : str, int, StepInput or array, shape (n,), optional
        Column of the input (V), or the input itself over the rows kept. Without it the record is a free release,
        zeros; refused where another column is an input by its name and not zero (``StepInput(level=0.0)`` says that
        it is a release all the same).
    position_scale : float
        m per unit of the position column, negative where +V gives falling values.
    time_scale : float
        s per unit of the time column; of the column only, all other times are in s.
    input_scale : float
        V per unit of the input column; of the column only.
    sample_time : float, optional
        s. With `time` too, rows are put at multiples of it after the first, and `time` is checked to agree within
        half a sample: for times that are printed rounded.
    name : str, optional
        Of the run; the first file's stem by default.
    added_mass : float
        kg, known weights on the cart.
    spring, damper, base : str
        Labels of what the run shares with others.
    counts_per_meter : float, optional
        Of the encoder behind the position, for its resolution; does not scale the column.
    input_before : float
        V, before the first sample.
    delimiter : str, optional
        What separates columns; by default a tab, semicolon, comma or blanks, whichever is found first in this order.
    start, stop : int
        Rows to keep, counted from 0 over the joined files, `stop` not included: for stretches in which the plant
        was switched off.

    Returns
    -------
    Experiment
        Time in s on the record's own clock, position in m, input in V.

    Raises
    ------
    stepid.errors.InputError
        Naming file, line and column: if a file is missing, empty, not text or holds what is not a number, rows differ
        in length, a column is missing, time is not uniform, or `position_scale` gives a travel of less than 10 nm or
        more than 100 m.
    """
    files = _files(paths)
    where = str(files[0]) if len(files) == 1 else f"{files[0]} … {files[-1].name}"
    for label, number in (
        ("position_scale", position_scale),
        ("time_scale", time_scale),
        ("input_scale", input_scale),
        ("sample_time", sample_time),
        ("counts_per_meter", counts_per_meter),
        ("input_before", input_before),
    ):
        check_number(label, number, where)
    check_scale("position", position, position_scale, where)
    check_scale("time", time, time_scale, where)
    check_scale("input", input, input_scale, where)
    if delimiter is not None and (not isinstance(delimiter, str) or not delimiter):
        raise InputError(f"{where}: delimiter is {delimiter!r}", "Give the text that separates columns.")
    table = _join([_parse(file, delimiter, (time, position, input)) for file in files], where)
    kept = _stretch(start, stop, len(table.places), where)
    table = _Table(table.names, table.values[kept], table.places[kept])
    if position is None:
        raise InputError(f"{where}: nothing says which column is the position ({table.listed})", "Give position=….")
    clock = _time(table, time, time_scale, sample_time, start, where)
    if input is None:
        check_release(table.names, table.values, (time, position), where)
    volts = _input(table, input, input_scale, clock, input_before, where)
    with np.errstate(all="ignore"):  # an overflow is reported by the model: not finite
        meters = table.column(position, "position", where) * float(position_scale) + 0.0
    if abs(position_scale) != 1.0 and np.isfinite(meters).all():
        check_travel(
            meters,
            f"{where}: with position_scale = {position_scale:g} the positions",
            "Give it in meters per unit of the column: 0.001 for mm, 1 / counts_per_meter for counts.",
        )
    try:
        return Experiment(
            name=files[0].stem if name is None else name,
            time=clock,
            position=meters,
            input=volts,
            added_mass=added_mass,
            spring=spring,
            damper=damper,
            counts_per_meter=counts_per_meter,
            input_before=input_before,
            base=base,
        )
    except InputError as error:
        raise InputError(f"{where}: {error.cause}", error.remedy) from None


def _files(paths: object) -> list[Path]:
    if isinstance(paths, str | os.PathLike):
        return [as_path(paths)]
    if not isinstance(paths, Sequence) or isinstance(paths, bytes) or not paths:
        raise InputError(f"paths is {paths!r}", "Give one path, or a sequence of paths in order.")
    return [as_path(path) for path in paths]


def _parse(file: Path, delimiter: str | None, used: Sequence[object]) -> _Table:
    where = str(file)
    kept = [(i + 1, text) for i, line in enumerate(read_lines(file)) if (text := line.strip(" ")) and text.strip()]
    body = [(i, text) for i, text in kept if not text.lstrip().startswith(("#", "%"))]
    if not body:
        raise InputError(f"{where}: holds no rows of numbers", "Export the record again.")
    separator = _sniff(body[-1][1]) if delimiter is None else delimiter
    rows = [_cells(text, separator) for _, text in body]
    names: tuple[str, ...] = ()
    if all(map(is_name, rows[0])):
        names, rows, body = tuple(rows[0]), rows[1:], body[1:]
    if not rows:
        raise InputError(f"{where}: holds a header and no rows", "Export the record again.")
    labels = names
    if not names or not any(len(row) == len(names) for row in rows):
        width = common_width(rows)
        if names:
            raise InputError(
                f"{where}, line {body[0][0]}: rows hold {width} values under a header of {len(names)} names", _REPAIR
            )
        labels = tuple(str(i) for i in range(width))
    if len(set(names)) < len(names):
        raise InputError(f"{where}: its header names a column twice ({', '.join(names)})", "Rename one of them.")
    lines = [i for i, _ in body]
    for i, (name, first) in enumerate(zip(labels, rows[0], strict=False)):
        if not is_number(first) and not any(isinstance(c, str | int) and c in (i, name) for c in used):
            rows = [[*row[:i], "0", *row[i + 1 :]] if i < len(row) else row for row in rows]  # text beside the readings
    values = parse_numbers(rows, lines=lines, columns=labels, where=where, remedy=_REPAIR)
    return _Table(names, values, [f"{where}, line {i}" for i in lines])


def _sniff(text: str) -> str | None:
    return next((mark for mark in "\t;," if mark in text), None)


def _cells(text: str, separator: str | None) -> list[str]:
    return [cell.strip().strip("\"'") for cell in text.split(None if separator in (None, " ") else separator)]


def _join(tables: Sequence[_Table], where: str) -> _Table:
    first = tables[0]
    for table in tables[1:]:
        if table.names != first.names or table.values.shape[1] != first.values.shape[1]:
            raise InputError(
                f"{table.places[0]}: has other columns than {first.places[0]}", "Join files of one layout only."
            )
    return _Table(
        first.names, np.concatenate([t.values for t in tables]), [place for t in tables for place in t.places]
    )


def _stretch(start: int, stop: int | None, rows: int, where: str) -> slice:
    last = rows if stop is None else stop
    for label, value in (("start", start), ("stop", last)):
        if type(value) is not int or not 0 <= value <= rows:
            raise InputError(
                f"{where}: {label} is {value!r}; the record has {rows} rows", "Count rows from 0 over all files."
            )
    if last - start < FEWEST:
        raise InputError(
            f"{where}: keeps {max(last - start, 0)} of {rows} rows; a record needs at least {FEWEST}",
            "Give the whole record.",
        )
    return slice(start, last)


def _time(
    table: _Table, column: Column | None, scale: float, sample_time: float | None, start: int, where: str
) -> Array:
    index = np.arange(len(table.places), dtype=np.float64)
    if sample_time is not None and not sample_time > 0:
        raise InputError(f"{where}: sample_time is {sample_time:g} s", "Give a positive sample time in seconds.")
    if column is None:
        if sample_time is None:
            raise InputError(f"{where}: nothing says when the rows were taken", "Give time=… or sample_time=… (s).")
        return (start + index) * sample_time
    with np.errstate(all="ignore"):
        time = table.column(column, "time", where) * float(scale)
        mean = float((time[-1] - time[0]) / (time.size - 1))
        step = mean if sample_time is None else sample_time
        uniform = _follows(time, index, mean, 0.01)
        good = mean > 0 and (uniform if sample_time is None else _follows(time, index, step, 0.5))
        steps = np.diff(time)
        usual = float(np.median(steps))
        odd = np.abs(steps - usual) > 0.02 * abs(usual)
    if good:
        return time if sample_time is None else time[0] + index * step
    if sample_time is not None and uniform:
        raise InputError(
            f"{where}: sample_time is given as {sample_time:g} s, but rows are {mean:.8g} s apart",
            "Leave sample_time out, or correct it.",
        )
    row = int(np.argmax(odd)) + 1
    raise InputError(
        f"{table.places[row]}: {time[row]:.10g} s after {time[row - 1]:.10g} s, where rows are about {usual:.6g} s "
        "apart: a gap, two different sample times, jitter or rounded times",
        "Give sample_time=… (s) if only the times are uneven; leave time out if each file starts a clock of its own.",
    )


def _follows(time: Array, index: Array, step: float, tolerance: float) -> bool:
    return bool(np.all(np.abs(time - time[0] - step * index) / step <= tolerance))


def _input(
    table: _Table, given: Column | InputValues | None, scale: float, time: Array, before: float, where: str
) -> Array:
    if given is None:
        return np.zeros(time.size)
    if isinstance(given, str | int):
        with np.errstate(all="ignore"):
            return table.column(given, "input", where) * float(scale) + 0.0
    return sample_input(given, time, before=before, where=where)
