"""What data plainly are not: SI units by a name, meters by travel or speed, a release beside an input; scales."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.core.frames import numbers
from stepid.core.takes import described, number, taken
from stepid.errors import InputError

FARTHEST = 100.0  # m; no teaching plant travels so far, but counts taken for meters do
NEAREST = 1e-8  # m; nor does one travel less than this
FASTEST = 100.0  # m/s; nor does one move so fast, but the millimeters of a cart taken for meters do
_APART = 8  # samples over which speed is measured, so that noise has none; single lost readings do not count either
_CLOCK = "If the times are no seconds, give time_scale: 0.001 for milliseconds."
UNIT = "Positions are in meters, time in seconds: divide counts by counts_per_meter, or give position_scale."
NO_COLUMN = "StepInput(level=…), in a manifest step = { level = … } (V; 0.0 for a free release)"
_UNITS = {  # SI units per unit, by what a column may be called
    "position": {"mm": "0.001", "cm": "0.01", "um": "1e-06", "µm": "1e-06"}
    | {"deg": f"{math.pi / 180:.17g}", "mrad": "0.001"},
    "time": {"ms": "0.001", "millis": "0.001", "us": "1e-06", "µs": "1e-06", "micros": "1e-06"},
    "input": {"mV": "0.001", "mA": "0.001", "mN": "0.001"},
}
_SI = {
    "position": "meters per unit (radians of an angle); negative where +V gives falling readings",
    "time": "seconds per unit",
    "input": "volts per unit, or what input_unit says",
}
_INPUT = re.compile(
    r"(?i:u|input|volts?|voltage|effort|control effort|command|drive|dac)(?![^\W_])|.*[_ (\[](?:m?V|volts?)[)\]]?$"
)


def small_unit(role: str, column: object) -> tuple[str, str] | None:
    """Return the unit that a column's name gives it and its factor to SI units, None where that is no smaller unit."""
    units = _UNITS[role]
    named = re.search(rf"(?:^|[_ (\[])({'|'.join(units)})[)\]]?$", column) if isinstance(column, str) else None
    return (named[1], units[named[1]]) if named else None


def check_scale(role: str, scale: float, where: str) -> None:
    """Refuse a scale of zero, and time that runs back."""
    if scale == 0 or (scale < 0 and role == "time"):
        size = "zero" if scale == 0 else f"{scale:g}"
        raise InputError(f"{where}: {role}_scale is {size}", f"Give {_SI[role]}.")


def check_numbers(where: str, **values: object) -> None:
    """Refuse what is neither None nor a finite number."""
    for label, value in values.items():
        try:
            good = not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value)
        except OverflowError:  # an integer beyond all floats
            good = False
        if value is not None and not good:
            raise InputError(f"{where}: {label} is {described(value)}", "Give a finite number.")


def check_scales(columns: Mapping[str, object], scales: Mapping[str, float], where: str) -> None:
    """Refuse scales, by role, that are no finite numbers, or that their columns cannot have: all of these at once."""
    for role, scale in scales.items():
        taken(where, f"{role}_scale", scale, number())
    for role, scale in scales.items():
        check_scale(role, scale, where)
    wrong = {role: unit for role in scales if (unit := small_unit(role, columns[role])) and abs(scales[role]) >= 1.0}
    if wrong:
        causes = [
            f"the column {columns[role]!r} is in {unit} by its name, but {role}_scale is {scales[role]:g}"
            for role, (unit, _) in wrong.items()
        ]
        remedies = [f"{role}_scale = {factor} ({_SI[role]})" for role, (_, factor) in wrong.items()]
        raise InputError(f"{where}: {'; '.join(causes)}", f"Give {', '.join(remedies)}.")


def in_si(role: str, values: Array, scale: float, where: str) -> Array:
    """Multiply a column by its scale; refuse positions, shape (n,), that span what no plant travels then."""
    if values.dtype.kind not in "fiu":  # the model says what is wrong with what are no numbers
        return values
    with np.errstate(all="ignore"):  # an overflow is reported by the model: not finite
        scaled: Array = values.astype(np.float64) * float(scale) + 0.0
    if role == "position" and abs(scale) != 1.0 and scaled.size and np.isfinite(scaled).all():
        check_travel(
            scaled,
            f"{where}: with position_scale = {scale:g} the positions",
            "Give it in meters per unit of the column: 0.001 for mm, 1 / counts_per_meter for counts.",
        )
    return scaled


def record(frame: Any, columns: Mapping[str, str], scales: Mapping[str, float], where: str) -> dict[str, Array]:
    """Read time [s], position [m] and input [V] from the columns of these roles, with the scales of `read_table`."""
    check_scales(columns, scales, where)
    arrays = {role: numbers(frame, column, field=role) for role, column in columns.items()}
    if arrays["time"].dtype.kind in "mM":
        arrays["time"] = _seconds(arrays["time"], scales["time"], where)
    return {role: in_si(role, values, scales[role], where) for role, values in arrays.items()}


def _seconds(stamps: npt.NDArray[Any], scale: float, where: str) -> Array:
    """Seconds of durations, or since the first of clock times; their unit is known, so a scale is refused."""
    if scale != 1.0:
        raise InputError(f"{where}: time_scale = {scale:g}, but the times have a unit of their own", "Leave it out.")
    since = stamps if stamps.dtype.kind == "m" else stamps - stamps[:1]
    seconds: Array = np.where(np.isnat(since), np.nan, since / np.timedelta64(1, "s"))
    return seconds


def check_travel(meters: Array, who: str, remedy: str) -> None:
    """Refuse positions, shape (n,), that span what no plant travels; `who` says whose they are, for the error."""
    with np.errstate(over="ignore"):
        travel = float(np.ptp(meters))
    if travel > FARTHEST or 0 < travel < NEAREST:
        raise InputError(f"{who} span {travel:.3g} m, which is no plant's travel", remedy)


def check_speed(meters: Array, sample_time: float, who: str) -> None:
    """Refuse positions, shape (n,), that move as fast as no plant; `who` says whose they are, for the error."""
    with np.errstate(over="ignore"):
        moved = np.abs(meters[_APART:] - meters[:-_APART])
    if moved.size and (speed := float(np.quantile(moved, 0.99)) / (_APART * sample_time)) > FASTEST:
        raise InputError(f"{who} move at {speed:.3g} m/s, which is no plant's speed", f"{UNIT} {_CLOCK}")


def check_release(names: Sequence[str], values: Array, used: Sequence[object], where: str) -> None:
    """Refuse to take for a free release what has an input by the name of a column that is not `used`."""
    name = input_not_said(names, values, used)
    if name is not None:
        raise InputError(
            f"{where}: no input is named, so this would be a free release, but the column {name!r} is not zero",
            f"Give input = {name!r}, or {NO_COLUMN}.",
        )


def input_not_said(names: Sequence[str], values: Array, used: Sequence[object]) -> str | None:
    """Return the first column that is not `used`, is an input by its name and not zero; None where there is none."""
    for i, name in enumerate(names):
        if name not in used and i not in used and _INPUT.match(name) and np.any(values[:, i]):
            return name
    return None
