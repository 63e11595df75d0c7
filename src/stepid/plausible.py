"""What a table's columns plainly are not: SI units by their names, meters by travel, a release beside an input."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from stepid._base import Array
from stepid.errors import InputError

FARTHEST = 100.0  # m; no teaching plant travels so far, but counts taken for meters do
NEAREST = 1e-8  # m; nor does one travel less than this
NO_COLUMN = "StepInput(level=…), in a manifest step = { level = … } (V; 0.0 for a free release)"
_UNITS = {  # SI units per unit, by what a column may be called
    "position": {"mm": "0.001", "cm": "0.01", "um": "1e-06", "µm": "1e-06"},
    "time": {"ms": "0.001", "millis": "0.001", "us": "1e-06", "µs": "1e-06", "micros": "1e-06"},
    "input": {"mV": "0.001"},
}
_SI = {
    "position": "meters per unit; negative where +V gives falling readings",
    "time": "seconds per unit",
    "input": "volts per unit",
}
_INPUT = re.compile(
    r"(?i:u|input|volts?|voltage|effort|control effort|command|drive|dac)(?![^\W_])|.*[_ (\[](?:m?V|volts?)[)\]]?$"
)


def small_unit(role: str, column: object) -> tuple[str, str] | None:
    """Return the unit that a column's name gives it and its factor to SI units, None where that is no smaller unit."""
    units = _UNITS[role]
    named = re.search(rf"(?:^|[_ (\[])({'|'.join(units)})[)\]]?$", column) if isinstance(column, str) else None
    return (named[1], units[named[1]]) if named else None


def check_scale(role: str, column: object, scale: float, where: str) -> None:
    """Refuse a scale of zero, time that runs back, and one that is not below 1 for a column called "…_mm"."""
    if scale == 0 or (scale < 0 and role == "time"):
        size = "zero" if scale == 0 else f"{scale:g}"
        raise InputError(f"{where}: {role}_scale is {size}", f"Give {_SI[role]}.")
    named = small_unit(role, column)
    if named and abs(scale) >= 1.0:
        raise InputError(
            f"{where}: the column {column!r} is in {named[0]} by its name, but {role}_scale is {scale:g}",
            f"Give {role}_scale = {named[1]} ({_SI[role]}).",
        )


def check_si(role: str, column: str) -> None:
    """Refuse a data frame's column that is not in SI units by its name."""
    if named := small_unit(role, column):
        raise InputError(
            f"the column {column!r} of the data frame is in {named[0]} by its name, and {role} is in SI units",
            f"Multiply it by {named[1]} in a column of another name, and give that.",
        )


def check_travel(meters: Array, scale: float, where: str) -> None:
    """Refuse a scale that was given where it makes of the record what no plant travels."""
    travel = float(np.ptp(meters)) if abs(scale) != 1.0 and np.isfinite(meters).all() else 0.0
    if travel > FARTHEST or 0 < travel < NEAREST:
        raise InputError(
            f"{where}: with position_scale = {scale:g} the positions span {travel:.3g} m, which is no plant's travel",
            "Give it in meters per unit of the column: 0.001 for mm, 1 / counts_per_meter for counts.",
        )


def check_release(names: Sequence[str], values: Array, used: Sequence[object], where: str) -> None:
    """Refuse to take for a free release what has an input by the name of a column that is not `used`."""
    for i, name in enumerate(names):
        if name not in used and i not in used and _INPUT.match(name) and np.any(values[:, i]):
            raise InputError(
                f"{where}: no input is named, so this would be a free release, but the column {name!r} is not zero",
                f"Give input = {name!r}, or {NO_COLUMN}.",
            )
