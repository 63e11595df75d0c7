"""Several runs side by side in one table: which column is whose, by its name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from stepid.errors import InputError

_UNIT = re.compile(r"\s*[\[(][^\])]*[\])]\s*$|[_ ](?:mm|cm|m|um|µm|s|ms|us|µs|V|mV|counts)$")
_WITHIN = re.compile(
    r"\s*[\[(](?:mm|cm|m|um|µm|in|deg|degrees|°|mrad|rad|s|ms|us|µs|min|V|mV|N|mN|A|mA|N·m|counts)[\])]"
)
_BETWEEN = " _.:-"  # what may stand between a run and the name of a column
_SHOWN = 12  # columns that a message lists


class RunColumns(NamedTuple):
    """The columns of one run, None where it has none of a role."""

    run: str
    position: str
    time: str | None
    input: str | None


def columns_of_runs(
    names: Sequence[str], roles: Mapping[str, str | None], where: str, *, runs: Sequence[str] | None = None
) -> tuple[RunColumns, ...]:
    """Find the columns of each run, told apart by their names.

    A column is of a role and a run if its name is that of the role with the run before or after it; units do not
    count: of "position", the columns "position 1", "case 4 position [mm]" and "Position_left" are those of the runs
    "1", "case 4" and "left".

    Parameters
    ----------
    names : sequence of str
        Of all columns.
    roles : mapping
        ``"position"``, ``"time"`` and ``"input"`` to what their columns have in common, None where there is none. A
        column called so exactly is shared by all runs.
    where : str
        The table, for messages.
    runs : sequence of str, optional
        Which to take; all by default.

    Returns
    -------
    tuple of RunColumns
        In the order of their positions.

    Raises
    ------
    stepid.errors.InputError
        Naming the columns: if no run is found, two columns are one run's, or a run lacks one that others have.
    """
    found = {role: _labeled(names, stem, role, where) for role, stem in roles.items() if stem is not None}
    positions = found["position"]
    listed = ", ".join(names[:_SHOWN]) + (", …" if len(names) > _SHOWN else "")
    if not positions:
        raise InputError(
            f"{where}: no column is a run's {roles['position']!r} ({listed})",
            'Give position = what the columns have in common: "x" for x1, x2, ….',
        )
    wanted = list(positions) if runs is None else [_known(run, positions, where) for run in runs]
    return tuple(
        RunColumns(
            run,
            positions[run],
            _partner(run, "time", found, names, roles, positions[run], where),
            _partner(run, "input", found, names, roles, positions[run], where),
        )
        for run in wanted
    )


def run_name(run: str) -> str:
    """Return what a run is called of which the columns tell only `run`: "run 1" for "1"."""
    return f"run {run}" if run.isdigit() else run


def _labeled(names: Sequence[str], stem: str, role: str, where: str) -> dict[str, str]:
    """Columns of a role by their run; InputError where two are one run's."""
    out: dict[str, str] = {}
    for name in names:
        run = _run_of(name, stem)
        if not run:
            continue
        if run in out:
            raise InputError(
                f"{where}: the columns {out[run]!r} and {name!r} are both the {role} of run {run!r}",
                f"Rename one of them, or give {role} = a longer part of the name.",
            )
        out[run] = name
    return out


def _run_of(name: str, stem: str) -> str | None:
    """Which run a column is of: its name without a unit and without `stem`, which stands at either end, or between."""
    bare, part = _without_unit(name), _without_unit(stem)
    at = [m.start() for m in re.finditer(re.escape(part), bare, re.IGNORECASE)]
    for i in at:
        before, after = bare[:i], bare[i + len(part) :]
        apart = (not before or not before[-1].isalpha()) and (not after or not after[0].isalpha())
        if apart and not (before and after):
            return (before or after).strip(_BETWEEN)
    return None


def _without_unit(name: str) -> str:
    """A name without the unit at its end, or else one within it: beside "[mm]" an "(A)" is a run."""
    bare, at_end = _UNIT.subn("", name)
    return (bare if at_end else _WITHIN.sub("", name)).strip()


def _known(run: str, positions: Mapping[str, str], where: str) -> str:
    for label in positions:
        if run in (label, run_name(label)):
            return label
    listed = ", ".join(f"{label!r} ({column})" for label, column in positions.items())
    raise InputError(f"{where}: has no run {run!r}", f"Its runs are {listed}.")


def _partner(
    run: str,
    role: str,
    found: Mapping[str, Mapping[str, str]],
    names: Sequence[str],
    roles: Mapping[str, str | None],
    position: str,
    where: str,
) -> str | None:
    stem = roles[role]
    if stem is None:
        return None
    own = found[role].get(run)
    if own is not None and stem in names:
        raise InputError(
            f"{where}: the {role} of run {run!r} may be the column {own!r} or {stem!r}, which all runs would share",
            f"Rename one of them, or give {role} = the part of the name that the right ones have in common.",
        )
    if own is not None:
        return own
    if stem in names:
        return stem
    others = ", ".join(repr(column) for column in found[role].values())
    raise InputError(
        f"{where}: the column {position!r} is the position of run {run!r}, but no column is its {role}"
        + (f" (those of others: {others})" if others else ""),
        f"Correct {role}=…, rename the column, or give runs = those that are complete.",
    )
