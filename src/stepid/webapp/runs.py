"""The table of the runs: what its cells may hold, and the campaign that it makes of the records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from stepid.core.experiment import Campaign
from stepid.core.quantities import quantities_of
from stepid.errors import InputError
from stepid.io.manifest import check_value
from stepid.webapp.intake import Row

COLUMNS = ("name", "added_mass", "spring", "damper")


def edited(rows: Sequence[Row], place: int, key: str, value: object) -> tuple[Row, ...]:
    """Return the rows with another value in one cell, checked as a manifest is.

    Parameters
    ----------
    rows : sequence of Row
    place : int
        Of the row.
    key : str
        One of `COLUMNS`.
    value : object
        As it was typed; a mass may have a decimal comma.

    Returns
    -------
    tuple of Row

    Raises
    ------
    stepid.errors.InputError
        Naming the run and the key.
    """
    row = rows[place]
    who = f"run {row.name!r}"
    if key == "added_mass":
        value = _number(value, who)
    elif isinstance(value, str):
        value = value.strip()
    checked: Any = check_value(key, value, who)
    if key == "name" and any(other.name == checked for i, other in enumerate(rows) if i != place):
        raise InputError(f"the name {checked!r} is used by more than one run", "Give each run its own name.")
    return (*rows[:place], replace(row, **{key: checked}), *rows[place + 1 :])


def chosen(rows: Sequence[Row], names: Sequence[str]) -> tuple[Row, ...]:
    """Return the rows, only those of these names used; InputError where none would be."""
    if not names:
        raise InputError("a campaign has one run at least", "Leave one of them ticked.")
    return tuple(replace(row, used=row.name in names) for row in rows)


def massless(rows: Sequence[Row]) -> tuple[str, ...]:
    """Names of the runs in use whose added mass is not known."""
    return tuple(row.name for row in rows if row.used and row.added_mass is None)


def labeled(recorded: Campaign, rows: Sequence[Row], name: str) -> Campaign:
    """Return the records in use, with the labels and masses of the table, a row a run.

    Raises
    ------
    stepid.errors.InputError
        If a mass is missing, a name is used twice, or the campaign has no name.
    """
    if missing := massless(rows):
        say = quantities_of(recorded).text
        raise InputError(
            f"{say('the added mass of')} {', '.join(missing)} is not known", say("Put it into the table, in kg.")
        )
    check_value("name", name.strip(), "the campaign")
    runs = tuple(
        run.model_copy(
            update={"name": row.name, "added_mass": row.added_mass, "spring": row.spring, "damper": row.damper}
        )
        for run, row in zip(recorded, rows, strict=True)
        if row.used
    )
    if runs == recorded.experiments and name.strip() == recorded.name:
        return recorded
    fields = {field: getattr(recorded, field) for field in Campaign.model_fields}
    return Campaign(**fields | {"experiments": runs, "name": name.strip()})._bearing(recorded.provenance)


def _number(value: object, who: str) -> object:
    """A number that may have been typed as text."""
    if not isinstance(value, str):
        return value
    try:
        return float(value.replace(",", ".").removesuffix("kg"))
    except ValueError:
        raise InputError(f"{who}: added_mass is {value!r}", "Give a number of kg.") from None
