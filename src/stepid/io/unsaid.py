"""What nobody said of a table, all of it in one error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from stepid.core.units import NO_COLUMN, input_not_said
from stepid.errors import InputError
from stepid.io.delimited import Table
from stepid.io.guess.words import SCALES, read_title

_QUESTIONS = {
    "position": "which column is the position",
    "time": "when the rows were taken",
    "input": "what the input is",
}
_REMEDIES = {
    "position": "position=…",
    "time": "time=… or sample_time=… (s)",
    "input": f"input=… or {NO_COLUMN}",
}


def check_said(
    table: Table, columns: Mapping[str, object], *, scales: Mapping[str, float], sample_time: float | None, where: str
) -> None:
    """Refuse a table of which nobody said which column is the position, or when its rows were taken.

    The error names all that is missing, with what the names of the columns suggest.

    Parameters
    ----------
    table : Table
    columns, scales : mapping
        By role: "position", "time" and "input".
    sample_time : float or None
        s.
    where : str
        For the error.
    """
    missing = [role for role in ("position", "time") if columns[role] is None]
    if sample_time is not None and "time" in missing:
        missing.remove("time")
    if not missing:
        return
    used = [columns["time"], columns["position"]]
    if columns["input"] is None and input_not_said(table.names, table.values, used) is not None:
        missing.append("input")
    asked = ", nor ".join(_QUESTIONS[role] for role in missing)
    wanted = [_REMEDIES[role] for role in missing]
    remedy = f"Give {_listed(wanted)}."
    if told := _suggested(table.names, missing, columns, scales):
        remedy += f" By the names of the columns: {', '.join(told)}."
    raise InputError(f"{where}: nothing says {asked} ({table.listed})", remedy)


def _suggested(
    names: Sequence[str], missing: Sequence[str], columns: Mapping[str, object], scales: Mapping[str, float]
) -> list[str]:
    """Arguments of `read_table` that names suggest, where one column alone is called so."""
    taken = [name for i, name in enumerate(names) if name in columns.values() or i in columns.values()]
    told = []
    for role in missing:
        titles = {name: title for name in names if name not in taken and (title := read_title(name)).role == role}
        if len(titles) != 1:
            continue
        ((name, title),) = titles.items()
        told.append(f"{role}={name!r}")
        scale = SCALES[role].get(title.unit or "", 1.0)
        if scale != 1.0 and scales[role] == 1.0:
            told.append(f"{role}_scale={scale:.6g}")
    return told


def _listed(parts: Sequence[str]) -> str:
    return ", and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)
