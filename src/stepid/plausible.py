"""What a table's columns plainly are not: meters by their name or their travel, a free release beside an input."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from stepid._base import Array
from stepid.errors import InputError

FARTHEST = 100.0  # m; no teaching plant travels so far, but counts taken for meters do
NEAREST = 1e-8  # m; nor does one travel less than this
_UNITS = {"mm": "0.001", "cm": "0.01", "um": "1e-06", "µm": "1e-06"}  # meters per unit, by what a column may be called
_INPUT = re.compile(
    r"(?i:u|input|volts?|voltage|effort|control effort|command|drive|dac)(?![^\W_])|.*[_ (\[](?:m?V|volts?)[)\]]?$"
)


def check_unit(column: object, scale: float, where: str) -> None:
    """Refuse to read a column as meters, or as more, whose name says that it is in a smaller unit."""
    named = re.search(r"[_ (\[](mm|cm|um|µm)[)\]]?$", column) if isinstance(column, str) else None
    if named and abs(scale) >= 1.0:
        unit = named[1]
        raise InputError(
            f"{where}: the column {column!r} is in {unit} by its name, but position_scale is {scale:g}",
            f"Give position_scale = {_UNITS[unit]} (meters per unit; negative where +V gives falling readings).",
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
                f"Give input = {name!r}. For a free release all the same, give StepInput(level=0.0), "
                "in a manifest step = { level = 0.0 }.",
            )
