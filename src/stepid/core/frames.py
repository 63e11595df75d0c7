"""The bridge to pandas: the only module that imports it, and only when called."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stepid.core.estimate import Estimate
from stepid.core.quantities import spoken_now
from stepid.core.takes import described
from stepid.errors import InputError, MissingPackageError

if TYPE_CHECKING:
    from pandas import DataFrame as DataFrame

    from stepid.core.base import Array

_MOST, _LETTERS = 50, 60  # columns that a message lists, and letters of each


class Row(NamedTuple):
    """One parameter: name, value, standard uncertainty (None where undetermined), unit; see `Estimate.one_sided`."""

    name: str
    value: float
    uncertainty: float | None
    unit: str
    one_sided: tuple[str, float] | None = None


def rows_of(parameters: Mapping[str, Estimate]) -> list[Row]:
    """Rows of a table of estimates."""
    return [Row(name, e.value, e.uncertainty, e.unit, e.one_sided) for name, e in parameters.items()]


def make_frame(columns: Mapping[str, Any]) -> DataFrame:
    """Make a DataFrame of columns of one length.

    Parameters
    ----------
    columns : mapping
        Column name to values.

    Returns
    -------
    pandas.DataFrame

    Raises
    ------
    stepid.errors.MissingPackageError
        If pandas is not installed.
    """
    try:
        import pandas as pd
    except ImportError:
        raise MissingPackageError(
            "data frames need the package 'pandas', which is not installed",
            "Install it with: pip install 'stepid[pandas]'.",
        ) from None
    return pd.DataFrame(dict(columns))


def tidy_frame(runs: Sequence[Any]) -> DataFrame:
    """Make one frame of all records, one row a sample; see `stepid.Campaign.to_dataframe`."""
    sizes = [e.time.size for e in runs]
    columns: dict[str, Any] = {"run": np.repeat(np.array([e.name for e in runs], dtype=object), sizes)}
    for field in ("time", "position", "input"):
        columns[field] = np.concatenate([getattr(e, field) for e in runs])
    for field in ("added_mass", "counts_per_meter", "input_before"):
        values = [getattr(e, field) for e in runs]
        columns[field] = np.repeat([np.nan if value is None else float(value) for value in values], sizes)
    for field in ("spring", "damper", "base", "input_between", "starts"):
        columns[field] = np.repeat(np.array([getattr(e, field) for e in runs], dtype=object), sizes)
    return make_frame(columns)


def parameter_frame(rows: Iterable[Row]) -> DataFrame:
    """Make a table of parameters: index `parameter`, columns `value`, `uncertainty` (NaN: undetermined), `unit`."""
    given = list(rows)
    frame = make_frame(
        {
            "parameter": [row.name for row in given],
            "value": [float(row.value) for row in given],
            "uncertainty": [np.nan if row.uncertainty is None else float(row.uncertainty) for row in given],
            "unit": [spoken_now().unit(row.unit) for row in given],
        }
    )
    return frame.set_index("parameter")


def numbers(frame: Any, column: str, *, field: str) -> Array:
    """Read a numeric column; InputError names it and the columns there are, or what it holds instead of numbers."""
    values = column_of(frame, column, field=field)
    dtype = getattr(values, "dtype", None)
    if getattr(dtype, "kind", "O") in "mM":  # times, which have a unit of their own
        return np.asarray(values.to_numpy("datetime64[ns]") if hasattr(dtype, "tz") else values)
    if isinstance(dtype, np.dtype) or getattr(dtype, "kind", "O") not in "fiu":
        return np.asarray(values)  # the model says what is wrong with what are no numbers
    missing = np.flatnonzero(np.asarray(values.isna()))  # pandas' nullable numbers
    if missing.size:
        raise InputError(
            f"column {column!r} of the data frame has {missing.size} missing value(s), the first in row {missing[0]}",
            "Leave those rows out.",
        )
    out: Array = values.to_numpy(dtype=np.float64)
    return out


def column_of(frame: Any, column: str, *, field: str) -> Any:
    """Return a column; InputError names it and the columns there are."""
    names = column_names(frame)
    try:
        values = frame[column]
    except (KeyError, IndexError, ValueError, TypeError):
        there = ", ".join(name[:_LETTERS] for name in names[:_MOST]) or "none"
        raise InputError(
            f"the data frame has no column {described(column)} for {field}",
            f"Name the column with {field}=…; there are: {there}.",
        ) from None
    if isinstance(values, np.ma.MaskedArray):
        raise InputError(f"column {described(column)} for {field} is a masked array", "Leave out what is masked.")
    return values


def column_names(frame: Any) -> tuple[str, ...]:
    """Names of the columns of a data frame, or of anything indexed by them; InputError where it is none."""
    if hasattr(frame, "keys") or (hasattr(frame, "__getitem__") and hasattr(frame, "columns")):
        return tuple(map(str, frame))
    raise InputError(f"a data frame is needed, not {described(frame)}", "Give one, or a mapping of columns.")


def split_runs(frame: Any, column: str) -> dict[str, Any]:
    """Row numbers of every run, in the order in which the runs first occur.

    Raises
    ------
    stepid.errors.InputError
        If the column is missing or a row names no run.
    """
    names = np.asarray(column_of(frame, column, field="run"), dtype=object)
    rows: dict[str, list[int]] = {}
    for row, name in enumerate(names):
        if not (isinstance(name, str) and name):
            raise InputError(
                f"row {row} of the data frame names no run in column {column!r}, but {name!r}",
                "Give every row the name of its run, as text.",
            )
        rows.setdefault(name, []).append(row)
    return {name: np.array(own) for name, own in rows.items()}


def constant(frame: Any, column: str, rows: Any, *, run: str) -> Any:
    """Read a value that all rows of a run share, None where it is missing; InputError says where it changes."""
    values = np.asarray(column_of(frame, column, field=column), dtype=object)[rows]
    plain = [None if _missing(value) else value for value in values]
    odd = next((i for i, value in enumerate(plain) if value != plain[0]), None)
    if odd is not None:
        raise InputError(
            f"run {run!r}: column {column!r} changes within the run, from {plain[0]!r} to {plain[odd]!r} "
            f"in row {rows[odd]}",
            "Give all rows of a run the same value, or another run name.",
        )
    return plain[0]


def _missing(value: Any) -> bool:
    return value is None or (isinstance(value, float) and np.isnan(value)) or type(value).__name__ == "NAType"
