"""A run as far as its file tells it, and what is still open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from stepid.core.base import Array
from stepid.core.quantities import CART, INPUT_UNITS, Quantities
from stepid.io.ecp import FEWEST
from stepid.io.guess.words import SCALES
from stepid.io.stamps import COARSE

T = TypeVar("T")
TURNS = ("deg", "rad", "mrad")
"""Units of an angle."""
ROLES = ("time", "position", "input")
ALL = "all"
"""In place of the position's column: each column of a position is a run."""


@dataclass(frozen=True)
class Found(Generic[T]):
    """A value and what it was found by: "its name", "its size", "an answer"."""

    value: T
    why: str

    @property
    def assumed(self) -> bool:
        """True where nobody said so: the value is the usual one, or the only one that fits the readings' size."""
        return self.why in ("its size", ASSUMED) or self.why.endswith(USUAL)


ASSUMED = "no other word"
USUAL = "the usual weights"


@dataclass(frozen=True)
class Draft:
    """One run of a campaign in the making.

    `columns` has the column of each role, by name or index, `readings` its numbers as they stand in the file, shape
    (n,), `units` its unit as in `SCALES`, or ``"counts"``. `scales` are SI units per count, `turn` is
    the angle of one, where no more is told of an encoder. `every` has what all columns of the file are called, each
    with its unit, None where it is not told. `doubts` are what no reader can make up for: a missing column, lines that
    are no rows; `lacking` says of roles that the column is not there that somebody named for them.
    """

    file: Path
    name: str
    format: str = "table"
    layout: Mapping[str, object] = field(default_factory=dict)  # keys of the manifest: delimiter, decimal, …
    columns: Mapping[str, str | int] = field(default_factory=dict)
    titles: Mapping[str, str] = field(default_factory=dict)  # what the columns are called in the file
    readings: Mapping[str, Array] = field(default_factory=dict)
    units: Mapping[str, Found[str]] = field(default_factory=dict)
    scales: Mapping[str, Found[float]] = field(default_factory=dict)
    turn: Found[float] | None = None  # rad per count
    mass: Found[float] | None = None  # kg
    weights: int | None = None
    spring: Found[str] = Found("spring", ASSUMED)
    damper: Found[str] = Found("damper", ASSUMED)
    sample_time: Found[float] | None = None  # s
    step: Found[tuple[float, float | None]] | None = None  # V, s; no start where the position is not known
    release: bool = False
    falling: bool = False  # the readings fall where the input rises
    doubts: tuple[str, ...] = ()
    choices: tuple[str, ...] = ()  # columns of which one is the position
    every: tuple[tuple[str, str | None], ...] = ()
    motion: Found[str] | None = None  # where somebody said it
    lacking: Mapping[str, str] = field(default_factory=dict)

    def scale(self, role: str) -> float | None:
        """SI units per unit of a column, None where it is not known."""
        if role in self.scales:
            return self.scales[role].value
        unit = self.units.get(role)
        return None if unit is None else SCALES[role].get(unit.value)

    def si(self, role: str) -> Array | None:
        """Readings of a role in SI units, None where there are none or their unit is not known."""
        scale = self.scale(role)
        return None if role not in self.readings or scale is None else self.readings[role] * scale

    @property
    def repeated(self) -> float:
        """Share of time stamps that repeat the one before: 1 where there are none, 0 where one falls."""
        if self.format == "ecp" or "time" not in self.columns:
            return 1.0
        steps = np.diff(self.readings["time"])
        return float(np.mean(steps == 0)) if steps.size and np.all(steps >= 0) else 0.0

    @property
    def has_no_clock(self) -> bool:
        """True where no column tells the sample time: there is none of the time, or it is printed too coarsely."""
        return self.repeated > COARSE

    def clock(self) -> Array | None:
        """Times of the samples, s; None where neither a sample time nor a column in a known unit tells them."""
        if self.sample_time is None or not self.repeated:
            return self.si("time")
        size, stamps = max((values.size for values in self.readings.values()), default=0), self.si("time")
        begin = 0.0 if stamps is None or not stamps.size else stamps[0]
        out: Array = begin + self.sample_time.value * np.arange(size, dtype=np.float64)
        return out

    @property
    def turns(self) -> bool:
        """True where the position is an angle, and nothing else is against a rotation."""
        if self.motion is not None:
            return self.motion.value == "rotation"
        unit, driven = self.units.get("position"), self.units.get("input")
        return unit is not None and unit.value in TURNS and (driven is None or driven.value not in ("N", "mN"))

    @property
    def named(self) -> str:
        """The file, and where it holds several, its run."""
        return self.file.name if self.name == self.file.stem else f"{self.file.name}, {self.name}"

    def having(self, **fields: object) -> Draft:
        """Return the draft with other fields."""
        return replace(self, **fields)  # type: ignore[arg-type]


def quantities_of_drafts(drafts: Sequence[Draft]) -> Quantities:
    """Return the quantities of a campaign in the making: what every run is, else those of a cart driven in V."""
    motion = "rotation" if drafts and all(draft.turns for draft in drafts) else "translation"
    units = {draft.units["input"].value.removeprefix("m") for draft in drafts if "input" in draft.units}
    unit = units.pop() if len(units) == 1 else CART.input_unit
    own = Quantities(motion, unit if unit in INPUT_UNITS else CART.input_unit)
    return own.keeping(text for draft in drafts for text in (draft.name, draft.file.name, *draft.titles.values()))


def falls(readings: Mapping[str, Array]) -> bool:
    """Say whether the position falls where the input rises: after the first change of the input, by half the motion."""
    position, volts = readings.get("position"), readings.get("input")
    if position is None or volts is None or position.size < FEWEST:
        return False
    change = np.flatnonzero(np.diff(volts))
    first = int(change[0]) + 1 if change.size else 0
    before = float(np.mean(volts[:first])) if first else 0.0
    up = float(volts[first]) - before
    later = np.flatnonzero(volts[first:] != volts[first])
    last = first + int(later[0]) if later.size else position.size
    segment = position[first:last]
    start = float(position[:first].mean()) if first else float(position[0])
    if up == 0 or segment.size < FEWEST:
        return False
    moved = float(segment.mean()) - start
    return bool(moved * up < 0 and abs(moved) > 0.25 * float(np.ptp(segment)))
