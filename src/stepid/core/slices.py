"""Stretches of a record."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from stepid.core.takes import WantedError, described, number
from stepid.errors import InputError

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

_FEWEST = 8  # samples of a record
_GAP = 0.05  # of the shorter part, that may be left out between two parts of one recording
_LABELS = ("added_mass", "spring", "damper", "base")


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


def parts_of(run: Experiment, number: int) -> list[Experiment]:
    """Equal parts of a record; those that begin while it swings freely, with no hand on the cart, start in motion."""
    from stepid.core.hand import hand
    from stepid.core.releases import split_releases

    size = run.time.size
    if size // number < _FEWEST:
        raise InputError(
            f"run {run.name!r}: of its {size} samples {number} parts have {size // number}; a part needs {_FEWEST}",
            f"Give a smaller number of parts, {size // _FEWEST} at most.",
        )
    ends = [size * k // number for k in range(number + 1)]
    parts = [run.slice(a, b, name=f"{run.name}, part {k}") for k, (a, b) in enumerate(pairwise(ends), 1)]
    if not run.is_release or len(split_releases(run)) > 1:
        return parts
    free = hand(run).first
    return [p.model_copy(update={"starts": "motion"}) if a > free else p for a, p in zip(ends, parts, strict=False)]


def of_one_recording(runs: Sequence[Experiment]) -> bool:
    """Tell whether runs are parts of one recording: by their clock each goes on where another ends."""
    parts = sorted(runs, key=lambda run: float(run.time[0]))
    return len(parts) > 1 and all(_goes_on(one, other) for one, other in pairwise(parts))


def _goes_on(one: Experiment, other: Experiment) -> bool:
    gap, shorter = float(other.time[0] - one.time[-1]), min(float(np.ptp(run.time)) for run in (one, other))
    alike = all(getattr(one, name) == getattr(other, name) for name in _LABELS)
    return alike and 0.0 < gap <= max(_GAP * shorter, 2.5 * one.sample_time)
