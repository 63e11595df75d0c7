"""Stretches of a record."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stepid.core.takes import WantedError, described, number
from stepid.errors import InputError

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

_FEWEST = 8  # samples of a record


def segment(
    run: Experiment,
    first: int | None,
    last: int | None,
    *,
    after: float | None = None,
    until: float | None = None,
    name: str | None = None,
) -> dict[str, Any]:
    """Fields of a segment of a record; see `stepid.Experiment.slice`."""
    who = f"run {run.name!r}"
    for index, moment, names in ((first, after, ("first", "after")), (last, until, ("last", "until"))):
        if index is not None and moment is not None:
            raise InputError(f"{who}: both {names[0]} and {names[1]} are given", "Give one: a sample or a time.")
        if index is not None and (isinstance(index, bool) or not isinstance(index, int | np.integer)):
            raise InputError(
                f"{who}: {names[0]} is {described(index)}", f"Give a whole number, or a time with {names[1]}=…."
            )
        if moment is not None:
            try:
                number()(moment)
            except WantedError:
                remedy = "Give a time in s on the record's clock."
                raise InputError(f"{who}: {names[1]} is {described(moment)}", remedy) from None
    if after is not None:
        first = int(np.searchsorted(run.time, after))
    if until is not None:
        last = int(np.searchsorted(run.time, until, side="right"))
    begin, end, _ = slice(first, last).indices(run.time.size)
    if end - begin < _FEWEST:
        raise InputError(
            f"{who}: samples {begin} to {end} of {run.time.size} are {max(end - begin, 0)}; "
            f"a record needs at least {_FEWEST}",
            f"Its times are {run.time[0]:g} s to {run.time[-1]:g} s.",
        )
    fields = {field: getattr(run, field) for field in type(run).model_fields}
    fields |= {field: fields[field][begin:end] for field in ("time", "position", "input")}
    if begin:
        fields["input_before"] = float(run.input[begin - 1])
        fields["starts"] = "auto" if run.is_release and run.starts != "motion" else "motion"
    return fields if name is None else fields | {"name": name}
