"""Delimited tables of numbers: one file or several that continue each other."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.recorded import recorded
from stepid.core.samples import InputBetween, Starts
from stepid.core.takes import described
from stepid.core.units import check_numbers, check_release, check_scales, in_si
from stepid.errors import InputError, naming
from stepid.io.delimited import Table, join_tables, parse_table
from stepid.io.ecp import FEWEST
from stepid.io.one_below import check_one_run
from stepid.io.stamps import clocked, stamped
from stepid.io.step_input import InputValues, sample_input
from stepid.io.table_layout import Layout
from stepid.io.textfile import as_path
from stepid.io.unsaid import check_said

Column = str | int


@recorded()
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
    input_between: InputBetween = "held",
    starts: Starts = "auto",
    delimiter: str | None = None,
    decimal: str = ".",
    skiprows: int = 0,
    encoding: str | None = None,
    sheet: str | None = None,
    start: int = 0,
    stop: int | None = None,
) -> Experiment:
    """Read a record from delimited text, or from a sheet of a workbook.

    Lines that start with ``#`` or ``%`` are comments. A first line that holds anything but numbers names the columns.

    Parameters
    ----------
    paths : path-like or sequence of path-like
        One file, or several that continue each other, joined in order.
    position : str or int
        Column of the position, by name or by index from 0. Must be given; the error without it lists the columns.
        Where several runs stand side by side, a run ends where its cells are empty from there on; where time goes on
        and no other column is called as a run's position, that is refused.
    time : str or int, optional
        Column of the time, s, uneven or not. Without it, `sample_time` says how far rows are apart.
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
        half a sample, or within its resolution where stamps repeat: for times that are printed rounded.
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
    input_between : "held", "lines" or "smooth"
        What the input does between two rows, as in `Experiment`.
    starts : "auto", "rest" or "motion"
        How the record starts, as in `Experiment`.
    delimiter : str, optional
        What separates columns; by default a tab, semicolon, comma or blanks, whichever is found first in this order.
    decimal : str
        The decimal mark, ``"."`` or ``","``, as pandas has it.
    skiprows : int
        Lines to leave out at the start of each file, above its header or first row.
    encoding : str, optional
        Of the text, as Python names it: ``"utf-16"``, ``"cp1252"``; UTF-8 by default.
    sheet : str, optional
        Of a workbook (``.xlsx``), the first by default. Its cells are read as they are stored: decimal marks do not
        matter.
    start, stop : int
        Rows to keep, counted from 0 over the joined files, `stop` not included: for segments in which the plant
        was switched off.

    Returns
    -------
    Experiment
        Time in s on the record's own clock, position in m, input in V.

    Raises
    ------
    stepid.errors.InputError
        Naming file, line and column: if a file is missing, empty, not text or holds what is not a number, rows differ
        in length, a column is missing, time does not increase, or `position_scale` gives a travel of less than 10 nm or
        more than 100 m.
    """
    files = as_files(paths)
    where = str(files[0]) if len(files) == 1 else f"{files[0]} … {files[-1].name}"
    check_numbers(where, sample_time=sample_time, counts_per_meter=counts_per_meter, input_before=input_before)
    scales = {"position": position_scale, "time": time_scale, "input": input_scale}
    columns = {"position": position, "time": time, "input": input}
    check_scales(columns, scales, where)
    layout = Layout(delimiter, decimal, skiprows, (time, position, input), encoding, sheet)
    layout.check(where)
    table = _kept(files, layout, start, stop, where)
    check_said(table, columns, scales=scales, sample_time=sample_time, where=where)
    clock = _time(table, time, time_scale, sample_time, start, where)
    if input is None:
        check_release(table.names, table.values, (time, position), where)
    volts = _input(table, input, input_scale, clock, input_before, where)
    meters = in_si("position", table.column(position, "position", where), position_scale, where)
    with naming(where):
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
            input_between=input_between,
            starts=starts,
        )


def as_files(paths: object) -> list[Path]:
    """Return one path or several as a list; InputError where they are none."""
    if isinstance(paths, str | os.PathLike):
        return [as_path(paths)]
    if not isinstance(paths, Sequence) or isinstance(paths, bytes) or not paths:
        raise InputError(f"paths is {described(paths)}", "Give one path, or a sequence of paths in order.")
    return [as_path(path) for path in paths]


def _kept(files: Sequence[Path], layout: Layout, start: int, stop: int | None, where: str) -> Table:
    """Read the rows to keep of all files, joined."""
    if len(files) == 1 and type(stop) is int:  # below the last row that is kept there may be anything
        layout = replace(layout, stop=stop)
    table = join_tables([parse_table(file, layout) for file in files])
    kept = _stretch(start, stop, len(table.places), where)
    return Table(table.names, table.values[kept], table.places[kept])


def _stretch(start: int, stop: int | None, rows: int, where: str) -> slice:
    last = rows if stop is None else stop
    for label, value in (("start", start), ("stop", last)):
        if type(value) is not int or not 0 <= value <= rows:
            raise InputError(
                f"{where}: {label} is {described(value)}; the record has {rows} rows",
                "Count rows from 0 over all files.",
            )
    if last - start < FEWEST:
        raise InputError(
            f"{where}: keeps {max(last - start, 0)} of {rows} rows; a record needs at least {FEWEST}",
            "Give the whole record.",
        )
    return slice(start, last)


def _time(
    table: Table, column: Column | None, scale: float, sample_time: float | None, start: int, where: str
) -> Array:
    if sample_time is not None and not sample_time > 0:
        raise InputError(f"{where}: sample_time is {sample_time:g} s", "Give a positive sample time in seconds.")
    if column is None:
        if sample_time is None:
            raise InputError(f"{where}: nothing says when the rows were taken", "Give time=… or sample_time=… (s).")
        return (start + np.arange(len(table.places), dtype=np.float64)) * sample_time
    time = in_si("time", table.column(column, "time", where), scale, where)
    check_one_run(time, table.places, start=start)
    return stamped(time, table.places) if sample_time is None else clocked(time, sample_time, table.places, where)


def _input(
    table: Table, given: Column | InputValues | None, scale: float, time: Array, before: float, where: str
) -> Array:
    if given is None:
        return np.zeros(time.size)
    if isinstance(given, str | int):
        return in_si("input", table.column(given, "input", where), scale, where)
    return sample_input(given, time, before=before, where=where)
