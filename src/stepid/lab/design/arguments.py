"""Arguments of `stepid.plan`: checked, or refused by name."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from stepid.core.takes import described
from stepid.errors import InputError

_USUAL = 0.02
_MOST = 2000  # designs: more are no trade that one can look at


@dataclass(frozen=True)
class Asked:
    """What the rig can do and how well it is known; units as in `stepid.plan`."""

    noise: float
    masses: tuple[float, ...]
    levels: tuple[float, ...]
    sample_times: tuple[float, ...]
    runs: tuple[int, ...]
    duration: float | None
    travel: float | None
    noise_time: float
    weight_uncertainty: float

    def variance(self, sample_time: float) -> float:
        """Variance of white noise that would tell as much at this sample time, m²."""
        return white_variance(self.noise, self.noise_time, sample_time)


def white_variance(noise: float, noise_time: float, sample_time: float) -> float:
    """Variance of the white noise that tells as much as noise [m] with a correlation time [s], m²."""
    kept = math.exp(-sample_time / noise_time) if noise_time else 0.0
    return noise**2 * (1 + kept) / (1 - kept)


def checked(
    noise: float,
    masses: Iterable[float],
    levels: Iterable[float],
    sample_times: Iterable[float],
    runs: Iterable[int],
    duration: float | None,
    travel: float | None,
    noise_time: float,
    weight_uncertainty: float,
) -> Asked:
    """Return the arguments in one piece.

    Raises
    ------
    stepid.errors.InputError
        If one is of the wrong kind or size.
    """
    asked = Asked(
        noise=number("noise", noise, "m, for example 20e-6"),
        masses=numbers("masses", masses, "kg, for example (0.0, 0.5, 1.0)"),
        levels=numbers("levels", levels, "V, for example (0.5, -0.5)"),
        sample_times=numbers("sample_times", sample_times, "s, for example (0.005, 0.01)"),
        runs=_counts(runs),
        duration=None if duration is None else number("duration", duration, "s"),
        travel=None if travel is None else number("travel", travel, "m"),
        noise_time=number("noise_time", noise_time, "s, 0 for white noise", least=0.0),
        weight_uncertainty=number("weight_uncertainty", weight_uncertainty, "kg, 0 for exact weights", least=0.0),
    )
    if len(asked.masses) < 2 or min(asked.masses) < 0:
        raise InputError(
            "masses: needs two different added masses, none negative", "Without a difference no mass can be known."
        )
    for name, bad, remedy in (
        ("levels", 0.0 in asked.levels, "A step of 0 V moves nothing: leave it out."),
        ("sample_times", min(asked.sample_times) <= 0, "Give them in s, above 0."),
        ("runs", min(asked.runs) < 2, "One run cannot show the mass: give 2 or more."),
    ):
        if bad:
            raise InputError(f"{name}: {getattr(asked, name)} cannot be", remedy)
    count = len(asked.runs) * 4 * (len(asked.levels) * (len(asked.levels) + 1) // 2) * len(asked.sample_times)
    if count > _MOST:
        raise InputError(
            f"levels, sample_times and runs make {count} designs, more than {_MOST}", "Give fewer of each."
        )
    return asked


def number(name: str, given: object, unit: str, *, least: float | None = None) -> float:
    """A positive number, or one that is not below `least`."""
    value = _finite(given)
    if value is not None and (value > 0 or (least is not None and value >= least)):
        return value
    limit = "above 0" if least is None else f"of {least:g} or above"
    raise InputError(f"{name} = {described(given)} cannot be", f"Give a number {limit}: {unit}.")


def numbers(name: str, given: object, unit: str) -> tuple[float, ...]:
    """Different finite numbers, one at least, in the order given."""
    try:
        several = list(given) if isinstance(given, Iterable) and not isinstance(given, (str, bytes, Mapping)) else []
    except TypeError:  # an array without dimension
        several = []
    good = [value for value in map(_finite, several) if value is not None]
    if not several or len(good) < len(several):
        raise InputError(f"{name} = {described(given)} is not a list of numbers", f"Give {unit}.")
    return tuple(dict.fromkeys(good))


def _counts(given: object) -> tuple[int, ...]:
    """How many runs: whole numbers."""
    several = numbers("runs", given, "how many runs, for example (2, 4, 8)")
    if not all(one.is_integer() for one in several):
        raise InputError(f"runs = {described(given)} are not whole numbers", "Give how many runs: (2, 4, 8).")
    return tuple(map(int, several))


def _finite(given: object) -> float | None:
    if isinstance(given, (bool, np.bool_)) or not isinstance(given, (int, float, np.integer, np.floating)):
        return None
    try:
        return float(given) if math.isfinite(given) else None
    except OverflowError:  # an integer beyond all floats
        return None


def wants(given: Mapping[str, float] | None, names: Iterable[str]) -> dict[str, float]:
    """Largest relative standard uncertainty by full name of the parameter.

    Raises
    ------
    stepid.errors.InputError
        If there is no such parameter.
    """
    known = list(names)
    if given is None:
        given = dict.fromkeys(("base_mass", "stiffness", "damping"), _USUAL)
    if not isinstance(given, Mapping):
        raise InputError(
            f"wanted = {described(given)} is no mapping", 'Give for example {"base_mass": 0.02}, which is 2 %.'
        )
    out = {}
    for name, share in given.items():
        full = [one for one in known if name in (one, one.partition("[")[0])]
        if not full:
            raise InputError(f"wanted: there is no parameter {name!r}", f"There are: {', '.join(known)}.")
        out[full[0]] = number(f"wanted[{name!r}]", share, "0.02 is 2 %")
    return out
