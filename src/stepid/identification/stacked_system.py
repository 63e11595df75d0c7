"""The stacked linear system of the paper's method, a result of its own."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from stepid.core.base import Matrix, Model, Vector
from stepid.core.experiment import MassOffset
from stepid.core.quantities import InputUnit, Motion
from stepid.core.tables import html_table, text_table
from stepid.identification.characteristics_model import Characteristics


class StackedSystem(Model):
    """The stacked linear system of Eqs. 6, 9 and 10 (corrected), made by `stepid.assemble`.

    Parameters
    ----------
    matrix : array, shape (2n − b, n + s)
        n runs of b bases, s spring labels; columns are the masses [kg], then the stiffnesses [N/m].
    rhs : array, shape (2n − b,)
        N/m·rad² for the frequency rows (all zero), kg for the mass rows.
    row_labels, column_labels : tuple of str
    characteristics : tuple of Characteristics
        The runs, in the order of their columns.
    mass_offsets : tuple of MassOffset
        In the order of their rows.
    motion, input_unit : str
        Of the campaign, see `stepid.Campaign`.
    """

    matrix: Matrix
    rhs: Vector
    row_labels: tuple[str, ...]
    column_labels: tuple[str, ...]
    characteristics: tuple[Characteristics, ...]
    mass_offsets: tuple[MassOffset, ...]
    motion: Motion = "translation"
    input_unit: InputUnit = "V"

    @model_validator(mode="after")
    def _shapes(self) -> Self:
        rows, columns = self.matrix.shape
        if self.rhs.size != rows or len(self.row_labels) != rows or len(self.column_labels) != columns:
            raise ValueError(f"matrix is {rows} × {columns}; rhs and labels must match it")
        return self

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (label, *(f"{value:.5g}" for value in row), f"{right:.4g}", unit)
            for label, row, right, unit in zip(self.row_labels, self.matrix, self.rhs, self.row_units, strict=True)
        ]

    @property
    def row_units(self) -> tuple[str, ...]:
        """Unit of each row's terms: N/m of a frequency row, kg of a mass row."""
        masses = len(self.characteristics)
        return tuple("N/m" if row[masses:].any() else "kg" for row in self.matrix)

    @property
    def _header(self) -> tuple[str, ...]:
        return ("row", *self.column_labels, "= rhs", "unit")

    @property
    def _title(self) -> str:
        size = f"{self.matrix.shape[0]} rows, {self.matrix.shape[1]} unknowns"
        return f"Stacked system (Eq. 10, corrected): {size}, masses in kg, stiffnesses in N/m"

    def summary(self) -> str:
        """Return the system as the paper prints Eq. 10: a row an equation, a column an unknown."""
        return text_table(self._header, self._rows(), title=self._title)

    def __repr__(self) -> str:
        return f"StackedSystem({self.matrix.shape[0]} rows, unknowns: {', '.join(self.column_labels)})"

    __str__ = summary

    def _repr_html_(self) -> str:
        return html_table(self._header, self._rows(), title=self._title)
