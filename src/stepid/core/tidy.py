"""The runs of a tidy data frame, one row a sample."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stepid.core.frames import column_names, constant, split_runs
from stepid.core.units import record
from stepid.errors import InputError

_OPTIONAL = ("base", "counts_per_meter", "input_before", "input_between", "starts")  # columns of a campaign's frame


def run_fields(frame: Any, scales: Mapping[str, float], where: str) -> list[dict[str, Any]]:
    """Fields of the experiment of every run; see `stepid.Campaign.from_dataframe`."""
    fields = ["added_mass", "spring", "damper"]
    needed = ["run", "time", "position", "input", *fields]
    there = column_names(frame)
    if missing := [field for field in needed if field not in there]:
        raise InputError(
            f"the data frame has no column {missing[0]!r}; there are: {', '.join(there) or 'none'}",
            f"Rename or add columns, in SI units or with their scales: {', '.join(needed)}.",
        )
    fields += [field for field in _OPTIONAL if field in there]
    whole = record(frame, {role: role for role in scales}, scales, where)
    runs = []
    for run, rows in split_runs(frame, "run").items():
        own = {field: constant(frame, field, rows, run=run) for field in fields}
        runs.append({"name": run, **{role: values[rows] for role, values in whole.items()}, **own})
    return runs
