"""Tables that hold several runs side by side."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from stepid.core.experiment import Experiment
from stepid.core.recorded import recorded
from stepid.core.takes import described, each, taken, text
from stepid.errors import InputError
from stepid.io.delimited import header
from stepid.io.side_by_side import columns_of_runs, run_name
from stepid.io.step_input import InputValues
from stepid.io.table import as_files, read_table
from stepid.io.table_layout import Layout

T = TypeVar("T")


@recorded()
def read_tables(
    paths: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    position: str,
    time: str | None = None,
    input: str | InputValues | None = None,
    runs: Sequence[str] | None = None,
    name: str | None = None,
    added_mass: float | Mapping[str, float] = 0.0,
    spring: str | Mapping[str, str] = "spring",
    damper: str | Mapping[str, str] = "damper",
    base: str | Mapping[str, str] = "cart",
    delimiter: str | None = None,
    decimal: str = ".",
    skiprows: int = 0,
    encoding: str | None = None,
    sheet: str | None = None,
    **shared: Any,
) -> tuple[Experiment, ...]:
    """Read all runs of a table that holds several side by side, told apart by the names of its columns.

    Parameters
    ----------
    paths : path-like or sequence of path-like
        One file with a header, or several that continue each other.
    position, time, input : str
        What the columns of a role have in common: ``position="x"`` for ``x1``, ``x2``; ``"position"`` for
        ``position run 1`` or ``case 4 position [mm]``. What is before or after it is the run. A column that is called
        so exactly, such as ``time``, is shared by all runs. `input` may be a `StepInput`, for all runs.
    runs : sequence of str, optional
        Which to read, as the columns call them; all by default.
    name : str, optional
        Of the run, where one is read. By default a run is called as in the columns, a mere number "run 1".
    added_mass : float or mapping
        kg, of all runs, or by the name of the run.
    spring, damper, base : str or mapping
        Labels of all runs, or by the name of the run.
    delimiter, decimal, skiprows, encoding, sheet
        As in `read_table`.
    **shared
        All else that `read_table` takes: ``position_scale``, ``sample_time``, ….

    Returns
    -------
    tuple of Experiment
        In the order of the columns. A run whose cells are empty from some row on ends there.

    Raises
    ------
    stepid.errors.InputError
        Naming the columns, where they do not tell which run they are of, and for all that `read_table` refuses.
    """
    files = as_files(paths)
    where = str(files[0])
    layout = Layout(delimiter, decimal, skiprows, (), encoding, sheet)
    layout.check(where)
    stems = {"position": position, "time": time, "input": input if isinstance(input, str) else None}
    for role, stem in stems.items():
        _check_stem(role, stem, where)
    if runs is not None:
        runs = taken("read_tables", "runs", runs, each(text(), 'names of runs, as ("1", "2")', least=1))
    names = header(files[0], layout)
    if not names:
        raise InputError(
            f"{where}: has no header that would tell its runs apart",
            "Read each run by the indices of its columns: read_table(…, position=1), ….",
        )
    found = columns_of_runs(names, stems, where, runs=runs)
    titles = [run_name(columns.run) for columns in found]
    if name is not None and len(found) > 1:
        raise InputError(f"{where}: one name is given for {len(found)} runs", "Leave name out.")
    by_run: dict[str, Any] = {"added_mass": added_mass, "spring": spring, "damper": damper, "base": base}
    return tuple(
        read_table(
            files,
            position=columns.position,
            time=columns.time,
            input=columns.input if isinstance(input, str) else input,
            name=title if name is None else name,
            delimiter=delimiter,
            decimal=decimal,
            skiprows=skiprows,
            encoding=encoding,
            sheet=sheet,
            **{field: _of(given, title, titles, field, where) for field, given in by_run.items()},
            **shared,
        )
        for columns, title in zip(found, titles, strict=True)
    )


def _check_stem(role: str, stem: object, where: str) -> None:
    if (stem is None and role != "position") or (isinstance(stem, str) and stem.strip()):
        return
    raise InputError(
        f"{where}: {role} is {described(stem)}", 'Give what the columns have in common: "x" for x1, x2, ….'
    )


def _of(given: T | Mapping[str, T], run: str, runs: Sequence[str], field: str, where: str) -> T:
    """What is given for one run; InputError where a mapping has other names."""
    if not isinstance(given, Mapping):
        return given
    if odd := [key for key in given if key not in runs]:
        raise InputError(f"{where}: {field} names {odd[0]!r}, which is no run", f"The runs are {', '.join(runs)}.")
    if run not in given:
        raise InputError(f"{where}: {field} is missing for run {run!r}", f"Add it, or give one {field} for all.")
    return given[run]
