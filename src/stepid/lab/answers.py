"""What is hidden: one group's answer and those of the class."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from stepid.core.base import Finite, Label, Model, NonNegative, Positive
from stepid.core.tables import html_table, text_table
from stepid.core.takes import a, described
from stepid.errors import InputError
from stepid.lab.hashes import answer_digest

_TITLE = "Answers"
_HEADER = ("group", "hidden", "r0", "parameters")


def in_words(effects: Iterable[str]) -> str:
    """Canonical names as people speak, ``"nothing"`` where there are none."""
    return " and ".join(effect.replace("_", " ") for effect in effects) or "nothing"


class Answer(Model):
    """What was put into one group's campaign.

    Parameters
    ----------
    group : str
    effects : tuple of str
        Canonical names of what is hidden; () where nothing is.
    parameters, units : mapping
        The true values by the names that `stepid.fit` gives them, SI units.
    attainable : mapping
        Standard uncertainties that a joint fit with the right effects attains on these records; None where the records
        do not determine the value.
    visibility : float
        r0: RMS that the best joint linear fit of the records leaves, over `noise`. About 1 where nothing is hidden.
    noise : float
        m, RMS of all that is random in the records: the reading's noise, its rounding, and what the amplifier's noise
        moves.
    records : str
        SHA-256 of the group's records.
    nonce : str
        Random text that keeps the commitment from being guessed.
    """

    group: Label
    effects: tuple[str, ...]
    parameters: Mapping[str, Finite]
    units: Mapping[str, str]
    attainable: Mapping[str, NonNegative | None]
    visibility: NonNegative
    noise: Positive
    records: Label
    nonce: Label

    def _unit(self, field: str, key: str = "") -> str:
        return self.units.get(key, "") if field in ("parameters", "attainable") else super()._unit(field, key)

    @property
    def commitment(self) -> str:
        """SHA-256 of this answer in hexadecimal; students may have it, and it holds the instructor to the answer."""
        return answer_digest(self)

    @property
    def names(self) -> str:
        """What is hidden, in words."""
        return in_words(self.effects)

    def __repr__(self) -> str:
        return f"Answer(group {self.group!r}: {self.names} hidden, r0 {self.visibility:.3g})"

    __str__ = __repr__


class Answers(Model):
    """The answers of a class, from `open_answers` or `Assignment.answers`.

    Parameters
    ----------
    seed : int or str
        What they were made from.
    answers : tuple of Answer
    """

    seed: int | str
    answers: tuple[Answer, ...]

    @property
    def groups(self) -> tuple[str, ...]:
        """Names of the groups."""
        return tuple(answer.group for answer in self.answers)

    def __getitem__(self, group: str) -> Answer:
        """Return a group's answer; InputError names the groups there are."""
        for answer in self.answers:
            if isinstance(group, str) and answer.group == group:
                return answer
        raise InputError(
            f"there is no answer for group {described(group)}", f"The groups are {', '.join(map(repr, self.groups))}."
        )

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (
                a.group,
                a.names,
                f"{a.visibility:.3g}",
                ", ".join(f"{name} = {value:.4g} {a.units[name]}".rstrip() for name, value in a.parameters.items()),
            )
            for a in self.answers
        ]

    def summary(self) -> str:
        """Return the table of what is hidden in whose campaign."""
        return text_table(_HEADER, self._rows(), title=_TITLE)

    def __repr__(self) -> str:
        return f"Answers({len(self.answers)} groups: {', '.join(self.groups)})"

    __str__ = summary

    def _repr_html_(self) -> str:
        return html_table(_HEADER, self._rows(), title=_TITLE)


an_answer = a(Answer, "an Answer: answers[group] of stepid.lab.open_answers")
"""Check of an argument `answer`."""
