"""Checks of the values that a manifest may hold: each returns the value, or says what it must be."""

from __future__ import annotations

import math
from collections.abc import Callable

from stepid.core.quantities import INPUT_UNITS, MOTIONS, middle_dot
from stepid.core.samples import STARTS, WAYS
from stepid.core.takes import WantedError
from stepid.io.step_input import StepInput

Check = Callable[[object], object]


def check_text(value: object) -> str:
    """Text that is not empty."""
    if not (isinstance(value, str) and value):
        raise WantedError("text that is not empty")
    return value


def check_number(value: object) -> float:
    """A finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise WantedError("a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise WantedError("a finite number")
    return number


def check_positive(value: object) -> float:
    """A number above zero."""
    number = check_number(value)
    if number <= 0:
        raise WantedError("above zero")
    return number


def check_mass(value: object) -> float:
    """A mass in kg."""
    number = check_number(value)
    if number < 0:
        raise WantedError("the mass in kg that was added, 0 or more")
    return number


def check_share(value: object) -> float:
    """A share, 0 or more."""
    number = check_number(value)
    if number < 0:
        raise WantedError("0 or more")
    return number


def check_scale(value: object) -> float:
    """A number other than zero."""
    number = check_number(value)
    if number == 0:
        raise WantedError("a number other than zero")
    return number


def check_whole(value: object) -> int:
    """A whole number."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise WantedError("a whole number")
    return value


def check_column(value: object) -> str | int:
    """A column of a table."""
    if isinstance(value, bool) or not isinstance(value, str | int):
        raise WantedError("a column's name or its index from 0")
    return value


def check_texts(value: object) -> tuple[str, ...]:
    """A list of texts."""
    if not (isinstance(value, list) and value and all(isinstance(v, str) and v for v in value)):
        raise WantedError("a list of texts")
    return tuple(value)


def check_decimal(value: object) -> str:
    """A decimal mark."""
    if value not in (".", ","):
        raise WantedError('"." (the default) or ","')
    return str(value)


def check_step(value: object) -> StepInput:
    """A step of the input."""
    if not isinstance(value, dict) or "level" not in value or not value.keys() <= {"level", "start", "end"}:
        raise WantedError("a table like { level = 0.5, start = 0.0 }, in V and s (end is optional)")
    try:
        numbers = {key: check_number(v) for key, v in value.items()}
    except WantedError:
        raise WantedError("a table of numbers like { level = 0.5, start = 0.0 }") from None
    return StepInput(**numbers)


def check_between(value: object) -> str:
    """What an input does between two samples."""
    if value not in WAYS:
        raise WantedError('"held" (the default), "lines" (joined by straight lines) or "smooth" (a cubic spline)')
    return str(value)


def check_motion(value: object) -> str:
    """How a plant moves."""
    if value not in MOTIONS:
        raise WantedError('"translation" (the default) or "rotation" (kg·m², N·m/rad, rad)')
    return str(value)


def check_input_unit(value: object) -> str:
    """Unit of an input."""
    unit = middle_dot(value)
    if unit not in INPUT_UNITS:
        raise WantedError('"V" (the default), "A", "N" or "N·m"')
    return str(unit)


def check_starts(value: object) -> str:
    """How a record starts."""
    if value not in STARTS:
        raise WantedError('"auto" (the default: as the data show), "rest" or "motion"')
    return str(value)
