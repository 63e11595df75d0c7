"""The result of the paper's method: the identified parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Self

import numpy as np
from pydantic import Field, model_validator

from stepid.core.base import Finite, Label, Matrix, Model, NonNegative, Positive
from stepid.core.estimate import Estimate, format_value
from stepid.core.frames import Row, parameter_frame
from stepid.core.latex import parameter_table
from stepid.core.quantities import InputUnit, Motion, in_own_quantities
from stepid.core.tables import html_table, text_table
from stepid.core.takes import described
from stepid.errors import InputError
from stepid.identification.stacked_system import StackedSystem as StackedSystem

if TYPE_CHECKING:
    from stepid.core.frames import DataFrame


class ParameterUncertainty(Model):
    """Standard uncertainties of `IdentifiedParameters`, same names, keys and units."""

    masses: Mapping[str, NonNegative] = Field(default_factory=dict)
    stiffness: Mapping[str, NonNegative] = Field(default_factory=dict)
    damping: Mapping[str, NonNegative] = Field(default_factory=dict)
    damping_from_stiffness: Mapping[str, NonNegative] = Field(default_factory=dict)
    pooled_damping: Mapping[str, NonNegative] = Field(default_factory=dict)
    static_gain: Mapping[str, NonNegative] = Field(default_factory=dict)
    base_mass: Mapping[str, NonNegative] = Field(default_factory=dict)


class IdentifiedParameters(Model):
    """What the paper's method finds.

    Parameters
    ----------
    masses : mapping
        Run name to moving mass, kg.
    stiffness : mapping
        Spring label to stiffness, N/m.
    damping, damping_from_stiffness : mapping
        Run name to damping constant, N·s/m, by c = 2ζmω_d/√(1 − ζ²) and by c = 2ζk√(1 − ζ²)/ω_d.
    pooled_damping : mapping
        Damper label to damping constant, N·s/m: its runs' values pooled.
    static_gain : mapping
        Run name to static gain, m/V; runs without a step are absent.
    base_mass : mapping
        Base label to the mass of the base without the added weights, kg; absent where added masses are not known.
    springs, dampers, bases : mapping
        Run name to its label.
    excluded : mapping
        Run name to the reason why it was left out.
    uncertainty : ParameterUncertainty
        Standard uncertainties.
    covariance : array, shape (q, q) or None
        Covariance of the errors of all values, in the order of `covariance_labels`
        (``"masses[case 4]"``, ``"stiffness[medium]"``, …).
    covariance_labels : tuple of str
    solver : str
        The solver that found them, as text.
    misfit : float or None
        Of the weighted solve: root mean square of its rows over what their uncertainties allow. About 1 where plant and
        labels are as assumed; much more says that the plant is not linear or a label or weight is wrong.
    notes : tuple of str
        That more than noise is left of the runs, where it is; whether a joint fit would be tighter by much.
    motion, input_unit : str
        Of the campaign, see `stepid.Campaign`.
    """

    masses: Mapping[str, Positive]
    stiffness: Mapping[str, Positive]
    damping: Mapping[str, NonNegative]
    static_gain: Mapping[str, Finite] = Field(default_factory=dict)
    damping_from_stiffness: Mapping[str, NonNegative] = Field(default_factory=dict)
    pooled_damping: Mapping[str, NonNegative] = Field(default_factory=dict)
    base_mass: Mapping[str, Finite] = Field(default_factory=dict)
    springs: Mapping[str, Label]
    dampers: Mapping[str, Label] = Field(default_factory=dict)
    bases: Mapping[str, Label] = Field(default_factory=dict)
    excluded: Mapping[str, str] = Field(default_factory=dict)
    uncertainty: ParameterUncertainty = ParameterUncertainty()
    covariance: Matrix | None = None
    covariance_labels: tuple[str, ...] = ()
    solver: str = ""
    misfit: NonNegative | None = None
    notes: tuple[str, ...] = ()
    motion: Motion = "translation"
    input_unit: InputUnit = "V"

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for name in self.masses:
            spring = self.springs.get(name)
            if spring not in self.stiffness:
                raise ValueError(f"run {name!r} has spring {spring!r}, which is not among the stiffnesses")
            if name not in self.damping:
                raise ValueError(f"run {name!r} has a mass but no damping")
        if self.covariance is not None and self.covariance.shape != (len(self.covariance_labels),) * 2:
            raise ValueError("covariance and covariance_labels differ in size")
        return self

    def run_stiffness(self, name: str) -> float:
        """Stiffness of the spring of run `name`, N/m; InputError names the runs there are."""
        if not isinstance(name, str) or name not in self.masses:
            why = f" (left out: {self.excluded[name]})" if isinstance(name, str) and name in self.excluded else ""
            raise InputError(
                f"no identified run {described(name)}{why}", f"There are: {', '.join(map(repr, self.masses))}."
            )
        return self.stiffness[self.springs[name]]

    @in_own_quantities
    def base_difference(self, from_base: str, to_base: str) -> Estimate:
        """Mass that `to_base` carries more than `from_base`, for example the moving parts of a connected damper.

        Parameters
        ----------
        from_base, to_base : str
            Base labels, for example case 3's two configurations.

        Returns
        -------
        Estimate
            kg, with the covariance of the two base masses taken into account.

        Raises
        ------
        stepid.errors.InputError
            If a base label has no identified base mass.
        """
        for base in (from_base, to_base):
            if not isinstance(base, str) or base not in self.base_mass:
                known = ", ".join(map(repr, self.base_mass)) or "none"
                raise InputError(f"no base mass for base {described(base)}", f"Base labels with a mass: {known}.")
        value = self.base_mass[to_base] - self.base_mass[from_base]
        labels = [f"base_mass[{base}]" for base in (from_base, to_base)]
        if self.covariance is None or not set(labels) <= set(self.covariance_labels):
            return Estimate(value=value, unit="kg")
        i, j = (self.covariance_labels.index(label) for label in labels)
        variance = self.covariance[i, i] + self.covariance[j, j] - 2 * self.covariance[i, j]
        return Estimate(value=value, uncertainty=math.sqrt(max(float(variance), 0.0)), unit="kg")

    def correlation(self, one: str, two: str) -> float:
        """Correlation of the errors of two values, named as in `covariance_labels`."""
        known = all(isinstance(label, str) and label in self.covariance_labels for label in (one, two))
        if self.covariance is None or not known:
            raise InputError(
                f"no covariance of {described(one)} and {described(two)}",
                f"There are: {', '.join(self.covariance_labels) or 'none'}.",
            )
        i, j = self.covariance_labels.index(one), self.covariance_labels.index(two)
        scale = math.sqrt(float(self.covariance[i, i] * self.covariance[j, j]))
        return float(np.clip(self.covariance[i, j] / scale, -1, 1)) if scale > 0 else 0.0

    def _runs(self) -> list[tuple[str, ...]]:
        u = self.uncertainty
        return [
            (
                name,
                format_value(self.masses[name], u.masses.get(name)),
                format_value(self.damping[name], u.damping.get(name)),
                _cell(self.damping_from_stiffness, u.damping_from_stiffness, name),
                _cell(self.static_gain, u.static_gain, name),
            )
            for name in self.masses
        ]

    def to_dataframe(self) -> DataFrame:
        """Return every value as a pandas DataFrame: index `parameter`, columns `value`, `uncertainty`, `unit`.

        The names are those of `covariance_labels`: ``"masses[case 4]"``, ``"stiffness[medium]"``, …

        Raises
        ------
        stepid.errors.MissingPackageError
            If pandas is not installed.
        """
        return parameter_frame(self._parameter_rows())

    def to_latex(self, *, caption: str | None = None, label: str | None = None) -> str:
        """Return the parameters as a LaTeX table for siunitx, with a caption as a float; see `stepid.core.latex`."""
        return parameter_table(self._parameter_rows(), caption=caption, label=label)

    def _parameter_rows(self) -> list[Row]:
        return [
            Row(f"{group}[{label}]", value, getattr(self.uncertainty, group).get(label), unit)
            for group, unit in _UNITS.items()
            for label, value in getattr(self, group).items()
        ]

    def summary(self) -> str:
        """Return tables of value ± standard uncertainty: by run, then what the runs share, then what was left out."""
        title = f"Identified parameters{' by ' * bool(self.solver)}{self.solver}"
        parts = [
            text_table(_RUN_HEADER, self._runs(), title=title),
            text_table(("shared", "value", "unit"), shared_rows(self)),
            *(f"left out: {name}: {why}" for name, why in self.excluded.items()),
        ]
        return "\n\n".join([*parts, *self._said])

    @property
    def _said(self) -> tuple[str, ...]:
        """The notes, after one of runs that contradict each other."""
        if self.misfit is None or self.misfit <= _LARGE_MISFIT:
            return self.notes
        contradiction = (
            f"The runs contradict each other {self.misfit:.1f} times more than their uncertainties allow: "
            "the plant is not linear, or a label or added mass is wrong. The uncertainties hold for a linear one."
        )
        return contradiction, *self.notes

    def __repr__(self) -> str:
        springs = ", ".join(f"{label!r}: {value:.4g} N/m" for label, value in self.stiffness.items())
        return f"IdentifiedParameters({len(self.masses)} runs, stiffness {springs})"

    __str__ = summary

    def _repr_html_(self) -> str:
        out = html_table(_RUN_HEADER, self._runs(), title="Identified parameters")
        out += html_table(("shared", "value", "unit"), shared_rows(self))
        out += html_table(("left out", "why"), tuple(self.excluded.items())) if self.excluded else ""
        return out + "".join(f"<p>{escape(note)}</p>" for note in self._said)


_LARGE_MISFIT = 2.0
_UNITS = {
    "masses": "kg",
    "stiffness": "N/m",
    "damping": "N·s/m",
    "damping_from_stiffness": "N·s/m",
    "pooled_damping": "N·s/m",
    "static_gain": "m/V",
    "base_mass": "kg",
}
_RUN_HEADER = ("run", "mass [kg]", "damping [N·s/m]", "damping from k [N·s/m]", "static gain [m/V]")


def shared_rows(found: IdentifiedParameters) -> list[tuple[str, str, str]]:
    """What the runs share: parameter, value ± standard uncertainty, unit."""
    u = found.uncertainty
    stiffness = ("stiffness", found.stiffness, u.stiffness, "N/m")
    damping = ("damping, pooled", found.pooled_damping, u.pooled_damping, "N·s/m")
    return [
        (f"{what} [{label}]", format_value(value, spread.get(label)), unit)
        for what, values, spread, unit in (stiffness, damping, ("base mass", found.base_mass, u.base_mass, "kg"))
        for label, value in values.items()
    ]


def _cell(values: Mapping[str, float], spread: Mapping[str, float], name: str) -> str:
    return format_value(values[name], spread.get(name)) if name in values else "–"
