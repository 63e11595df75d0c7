"""What a check says: each parameter, and all of a group's."""

from __future__ import annotations

import math
from html import escape
from typing import Literal

from stepid.core.base import Finite, Label, Model, NonNegative
from stepid.core.estimate import format_value
from stepid.core.tables import html_table, text_table
from stepid.errors import InputError

Naming = Literal["right", "among", "partly", "wrong"]
_HEADER = ("parameter", "handed in", "truth", "unit", "off", "verdict")
_CHANCE = 0.01  # that so many intervals miss, though all are right


class ParameterCheck(Model):
    """One parameter as handed in and in truth.

    Parameters
    ----------
    name, unit : str
    value, uncertainty : float or None
        As handed in; None where not given, or given as undetermined.
    truth : float or None
        None where the plant has no such parameter.
    off : float or None
        |value − truth|/|truth|; for an angle in rad |value − truth|, the short way round.
    inside : bool
        The truth lies in the 95 % interval handed in, value ± 1.96 standard uncertainties.
    close : bool
        The value lies within the tolerance of the truth, or as near to it as the records allow.
    words : str
    """

    name: Label
    unit: str
    value: Finite | None
    uncertainty: NonNegative | None
    truth: Finite | None
    off: NonNegative | None
    inside: bool
    close: bool
    words: str

    @property
    def right(self) -> bool:
        """Close to the truth, and the interval holds it."""
        return self.inside and self.close


class Check(Model):
    """A group's submission against the answer; printed, it is a table in words. It tells the truth: for instructors.

    Parameters
    ----------
    group : str
    naming : str
        ``"right"``, ``"among"`` (what is hidden is among several that the group could not tell apart), ``"partly"``
        (one of several found, or one too many named), or ``"wrong"``.
    words : str
        The same in words.
    parameters : tuple of ParameterCheck
    tolerance : float
        Relative, as asked for.
    """

    group: Label
    naming: Naming
    words: str
    parameters: tuple[ParameterCheck, ...]
    tolerance: NonNegative

    @property
    def counted(self) -> tuple[ParameterCheck, ...]:
        """The parameters that count; where several effects could not be told apart, not those of only one of them."""
        if self.naming != "among":
            return self.parameters
        return tuple(p for p in self.parameters if p.value is not None and p.truth is not None)

    @property
    def close(self) -> int:
        """How many values are within the tolerance, of those counted."""
        return sum(p.close for p in self.counted)

    @property
    def inside(self) -> int:
        """How many intervals hold the truth, of those counted."""
        return sum(p.inside for p in self.counted)

    @property
    def misses_allowed(self) -> int:
        """How many intervals may miss by chance; more would do so in less than 1 % of perfect submissions."""
        n, left, k = len(self.counted), 1.0, -1
        while left > _CHANCE:
            k += 1
            left -= math.comb(n, k) * 0.05**k * 0.95 ** (n - k)
        return k

    @property
    def passed(self) -> bool:
        """Naming right (or among several), all values close, and no more intervals missed than chance allows."""
        n = len(self.counted)
        named = self.naming in ("right", "among")
        return named and self.close == n and n - self.inside <= self.misses_allowed

    def __getitem__(self, name: str) -> ParameterCheck:
        """Return the check of a parameter; InputError names those there are."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise InputError(
            f"no parameter {name!r} was checked", f"There are: {', '.join(p.name for p in self.parameters)}."
        )

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (
                p.name,
                "–" if p.value is None else format_value(p.value, p.uncertainty),
                "–" if p.truth is None else f"{p.truth:.5g}",
                p.unit,
                "–" if p.off is None else _off(p.off, p.unit),
                p.words,
            )
            for p in self.parameters
        ]

    @property
    def _title(self) -> str:
        return f"Group {self.group}: {'passed' if self.passed else 'not passed'}"

    @property
    def _counts(self) -> str:
        n = len(self.counted)
        return (
            f"{self.close} of {n} values within the tolerance ({100 * self.tolerance:.3g} %), {self.inside} of {n} "
            f"intervals hold the truth ({n - self.misses_allowed} needed: of right ones, one in twenty misses)."
        )

    def summary(self) -> str:
        """Return the verdict, a table of the parameters, and the counts."""
        table = text_table(_HEADER, self._rows())
        return f"{self._title}\n{self.words}\n{table}\n{self._counts}"

    def __repr__(self) -> str:
        n = len(self.counted)
        return f"Check({self._title}, naming {self.naming}, {self.close} of {n} close, {self.inside} of {n} inside)"

    __str__ = summary

    def _repr_html_(self) -> str:
        table = html_table(_HEADER, self._rows(), title=self._title)
        return f"<p>{escape(self.words)}</p>{table}<p>{escape(self._counts)}</p>"


def _off(off: float, unit: str) -> str:
    return f"{off:.2g} rad" if unit == "rad" else f"{100 * off:.2g} %"
