"""The characteristics of one response: what the method reads off a record (Eqs. 3, 4, 7, 8)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from html import escape
from typing import Any, Self

from pydantic import model_validator

from stepid.core.base import Finite, Label, Model, NonNegative, Positive
from stepid.core.estimate import format_value, prefixed
from stepid.core.frames import Row
from stepid.core.latex import parameter_table
from stepid.core.quantities import InputUnit, Motion
from stepid.core.tables import html_table, text_table
from stepid.identification.second_order import (
    damped_fraction,
    damped_frequency,
    damping_ratio,
    damping_ratio_slope,
    natural_frequency,
)


class CharacteristicsUncertainty(Model):
    """Standard uncertainties of `Characteristics`; None where the quantity is None.

    Parameters
    ----------
    peak_time, settling_time : float or None
        s.
    overshoot : float or None
        Decimal fraction.
    steady_state : float or None
        m.
    static_gain : float or None
        m/V.
    damping_ratio : float
    damped_frequency, natural_frequency : float
        rad/s.
    """

    peak_time: NonNegative | None = None
    overshoot: NonNegative | None = None
    steady_state: NonNegative | None = None
    damping_ratio: NonNegative = 0.0
    damped_frequency: NonNegative = 0.0
    natural_frequency: NonNegative = 0.0
    static_gain: NonNegative | None = None
    settling_time: NonNegative | None = None


class Characteristics(Model):
    """Second-order response characteristics of one run (Eqs. 3, 4, 7, 8).

    By hand, `name`, `peak_time` and `overshoot` are enough: what follows from them by Eqs. 7 and 8 is filled in,
    uncertainties too.

    Parameters
    ----------
    name, spring, damper, base : str
        The run and its labels.
    damped_frequency, natural_frequency : float
        rad/s.
    damping_ratio : float
        At least 0, below 1.
    peak_time : float or None
        s, from the sample where the input changes; None for a release.
    overshoot : float or None
        Decimal fraction M_p; None for a release.
    steady_state : float or None
        m, signed displacement from rest; None for a release.
    static_gain : float or None
        m/V; None for a release.
    settling_time : float or None
        s, into the band of 2 %; None where the record does not show it.
    uncertainty : CharacteristicsUncertainty
    correlation : float
        Correlation of the errors of `damped_frequency` and `damping_ratio`.
    peak_time_bias, overshoot_bias : float
        s, –; expected errors of a reading, as of `SampledPeak`. `ErrorsInVariables` takes them off, nothing else does.
    added_mass : float or None
        kg, known weights of the run, where known.
    start : float or None
        s, time of the step (or release) on the clock of the record.
    step : float or None
        V, signed change of the input; None for a release.
    notes : tuple of str
        What a reader should know, for example that the steady state comes from a fitted tail.
    motion, input_unit : str
        Of the campaign, see `stepid.Campaign`.

    Raises
    ------
    stepid.errors.InputError
        If a value is out of range, or two contradict Eq. 7 or 8 by more than 1 %.
    """

    name: Label
    damped_frequency: Positive
    damping_ratio: NonNegative
    natural_frequency: Positive
    peak_time: Positive | None = None
    overshoot: Positive | None = None
    steady_state: Finite | None = None
    static_gain: Finite | None = None
    settling_time: NonNegative | None = None
    uncertainty: CharacteristicsUncertainty = CharacteristicsUncertainty()
    correlation: Finite = 0.0
    peak_time_bias: Finite = 0.0
    overshoot_bias: Finite = 0.0
    spring: Label = "spring"
    damper: Label = "damper"
    base: Label = "cart"
    added_mass: NonNegative | None = None
    start: Finite | None = None
    step: Finite | None = None
    notes: tuple[str, ...] = ()
    motion: Motion = "translation"
    input_unit: InputUnit = "V"

    @model_validator(mode="before")
    @classmethod
    def _complete(cls, data: Any) -> Any:
        return _fill(dict(data)) if isinstance(data, Mapping) else data

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.damping_ratio >= 1:
            raise ValueError(f"damping_ratio {self.damping_ratio:.4g} is not below 1; Eqs. 7 and 8 need an overshoot")
        if abs(self.correlation) > 1:
            raise ValueError("correlation must lie between -1 and 1")
        pairs = [
            ("natural_frequency", self.natural_frequency, self.damped_frequency / damped_fraction(self.damping_ratio))
        ]
        if self.peak_time is not None:
            pairs.append(("damped_frequency (Eq. 7)", self.damped_frequency, damped_frequency(self.peak_time)))
        for what, given, due in pairs:
            if abs(given - due) > 0.01 * due:
                raise ValueError(f"{what} is {given:.6g} but the other values make it {due:.6g}")
        return self

    def summary(self) -> str:
        """Return a table of value ± standard uncertainty with units."""
        table = text_table(("quantity", "value", "unit"), self._rows(), title=f"Characteristics of {self.name!r}")
        return "\n".join([table, *(f"note: {note}" for note in self.notes)])

    def to_latex(self, *, caption: str | None = None, label: str | None = None) -> str:
        """Return them as a LaTeX table for siunitx, with a caption as a float; see `stepid.core.latex`."""
        given = ((field, getattr(self, field), unit) for field, unit in _UNITS.items())
        rows = [Row(f, value, getattr(self.uncertainty, f), unit) for f, value, unit in given if value is not None]
        return parameter_table(rows, caption=caption, label=label)

    def _rows(self) -> list[tuple[str, str, str]]:
        rows = []
        for field, unit in _UNITS.items():
            value = getattr(self, field)
            if value is not None:
                shown, spread, own = prefixed(value, getattr(self.uncertainty, field), unit)
                rows.append((field.replace("_", " "), format_value(shown, spread), own))
        return rows

    def __repr__(self) -> str:
        return (
            f"Characteristics({self.name!r}, damped_frequency={self.damped_frequency:.5g} rad/s, "
            f"damping_ratio={self.damping_ratio:.4g})"
        )

    __str__ = summary

    def _repr_html_(self) -> str:
        table = html_table(("quantity", "value", "unit"), self._rows(), title=f"Characteristics of {self.name!r}")
        return table + "".join(f"<p>{escape(note)}</p>" for note in self.notes)


_UNITS = {
    "peak_time": "s",
    "overshoot": "",
    "steady_state": "m",
    "static_gain": "m/V",
    "settling_time": "s",
    "damped_frequency": "rad/s",
    "damping_ratio": "",
    "natural_frequency": "rad/s",
}


def _number(data: Mapping[str, Any], key: str) -> bool:
    return isinstance(data.get(key), (int, float)) and not isinstance(data.get(key), bool)


def _fill(data: dict[str, Any]) -> dict[str, Any]:
    """Fill in what Eqs. 7 and 8 give; leave wrong types to the field checks."""
    # a before-validator turns JSON into Python objects, where strict mode wants the exact types
    if isinstance(data.get("uncertainty"), Mapping):
        data["uncertainty"] = CharacteristicsUncertainty(**data["uncertainty"])
    if isinstance(data.get("notes"), list):
        data["notes"] = tuple(data["notes"])
    given = data.get("uncertainty")
    if _number(data, "peak_time") and data.get("damped_frequency") is None and data["peak_time"] > 0:
        data["damped_frequency"] = damped_frequency(data["peak_time"])
    if _number(data, "overshoot") and data.get("damping_ratio") is None and 0 < data["overshoot"] < 1:
        data["damping_ratio"] = damping_ratio(data["overshoot"])
    known = _number(data, "damped_frequency") and _number(data, "damping_ratio") and 0 <= data["damping_ratio"] < 1
    if known and data.get("natural_frequency") is None:
        data["natural_frequency"] = natural_frequency(data["damped_frequency"], data["damping_ratio"])
    if known and isinstance(given, CharacteristicsUncertainty):
        data["uncertainty"] = _propagate(data, given)
    return data


def _propagate(data: Mapping[str, Any], given: CharacteristicsUncertainty) -> CharacteristicsUncertainty:
    fields = given.model_dump()
    w, z = data["damped_frequency"], data["damping_ratio"]
    if given.peak_time is not None and "damped_frequency" not in given.model_fields_set:
        fields["damped_frequency"] = w**2 / math.pi * given.peak_time
    if given.overshoot is not None and "damping_ratio" not in given.model_fields_set and _number(data, "overshoot"):
        fields["damping_ratio"] = abs(damping_ratio_slope(data["overshoot"], z)) * given.overshoot
    if "natural_frequency" not in given.model_fields_set:
        a, b = fields["damped_frequency"] / w, z * fields["damping_ratio"] / (1 - z**2)
        rho = data.get("correlation", 0.0) if _number(data, "correlation") else 0.0
        wn = w / damped_fraction(z)
        fields["natural_frequency"] = wn * math.sqrt(max(a * a + b * b + 2 * rho * a * b, 0.0))
    return CharacteristicsUncertainty(**fields)
