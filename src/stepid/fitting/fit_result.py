"""What a joint fit found: parameters, the model, what is left, and how sure it is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

from stepid.core.base import Matrix, Model, NonNegative
from stepid.core.estimate import Estimate, format_value, one_end, prefixed
from stepid.core.frames import parameter_frame, rows_of
from stepid.core.latex import parameter_name, parameter_table
from stepid.core.quantities import InputUnit, Motion
from stepid.core.tables import html_table, text_table
from stepid.core.words import length
from stepid.simulation.model import PlantModel

if TYPE_CHECKING:
    from stepid.core.frames import DataFrame


class Fit(Model):
    """A joint fit.

    Parameters
    ----------
    parameters : mapping
        Name to Estimate: ``"base_mass"``, ``"stiffness[medium]"``, ``"force_gain"``, ``"coulomb_friction.level"``, …
    model : PlantModel
        Ready for `stepid.simulate`.
    rms : float
        m, of measured minus simulated over all samples.
    noise : float
        m, noise floor.
    run_rms : mapping
        Run name to RMS [m].
    correlation : array, shape (n, n)
        Of the free shared parameters, in the order of `parameters`.
    converged : bool
    notes : tuple of str
        What was left out, which run disagrees with the others, whose input is not what the record says, that the fit
        did not converge.
    motion, input_unit : str
        Of the campaign, see `stepid.Campaign`.
    """

    parameters: Mapping[str, Estimate]
    model: PlantModel
    rms: NonNegative
    noise: NonNegative
    run_rms: Mapping[str, NonNegative]
    correlation: Matrix
    converged: bool
    notes: tuple[str, ...] = ()
    motion: Motion = "translation"
    input_unit: InputUnit = "V"

    def to_dataframe(self) -> DataFrame:
        """Return the parameters as a pandas DataFrame: index `parameter`, columns `value`, `uncertainty`, `unit`."""
        return parameter_frame(rows_of(self.parameters))

    def to_latex(self, *, caption: str | None = None, label: str | None = None) -> str:
        """Return the parameters as a LaTeX table for siunitx, with a caption as a float; see `stepid.core.latex`."""
        return parameter_table(rows_of(self.parameters), caption=caption, label=label)

    def summary(self) -> str:
        """Return a table: each value ± standard uncertainty, its 95 % interval, and what the uncertainty comes from."""
        parts = [text_table(*self._table(), title=self._title()), *self.notes]
        return "\n\n".join(parts)

    def __repr__(self) -> str:
        named = ", ".join(effect.name for effect in self.model.effects) or "linear"
        return f"Fit({named}, {len(self.parameters)} parameters, rms {length(self.rms)})"

    __str__ = summary

    def _repr_html_(self) -> str:
        notes = "".join(f"<p>{escape(note)}</p>" for note in self.notes)
        return html_table(*self._table(), title=self._title()) + notes

    def _title(self) -> str:
        named = ", ".join(parameter_name(effect.name) for effect in self.model.effects)
        plant = f"Linear plant with {named}" if named else "Linear plant"
        return f"{plant}: {length(self.rms)} are left, the noise is {length(self.noise)}"

    def _table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Header and rows; of the causes those that there are."""
        every = self.parameters.values()
        causes = [cause for cause in _CAUSES if any(cause in e.parts for e in every)]
        header = ("parameter", "value", "95 % interval", *(_CAUSES[cause] for cause in causes), "unit")
        rows = []
        for name, e in self.parameters.items():
            value, spread, unit = prefixed(e.value, e.uncertainty, e.unit)
            factor = 1.0 if unit == e.unit else 1e3
            ends = e.interval and (factor * e.interval[0], factor * e.interval[1])
            interval = "not determined" if ends is None else _span(ends)
            if e.one_sided:
                words, end = e.one_sided
                interval = one_end(words, factor * end)
            parts = (_size(factor * e.parts[cause] if cause in e.parts else None) for cause in causes)
            rows.append((name, format_value(value, spread), interval, *parts, unit))
        return header, rows


_CAUSES = {"noise": "by noise", "weights": "by weights", "scale": "by scale"}


def _span(interval: tuple[float, float]) -> str:
    low, high = interval
    half = 0.5 * (high - low)
    places = max(0, 1 - math.floor(math.log10(half))) if half > 0 else 6
    if places > 9:
        return f"{low:.6g} to {high:.6g}"
    return f"{low:.{places}f} to {high:.{places}f}"


def _size(part: float | None) -> str:
    return "–" if part is None else f"{part:.2g}"
