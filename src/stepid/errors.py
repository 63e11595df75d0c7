"""The error tree: every message says the cause, then the remedy."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class StepidError(Exception):
    """Base of every error that stepid raises on purpose.

    Parameters
    ----------
    cause : str
        What is wrong, naming the file, run, row or column.
    remedy : str
        What to do about it.
    """

    def __init__(self, cause: str, remedy: str = "") -> None:
        self.cause = cause.rstrip(".")
        self.remedy = remedy
        super().__init__(cause, remedy)

    def __str__(self) -> str:
        cause = self.cause if self.cause.endswith("?") else f"{self.cause}."
        return f"{cause} {self.remedy}".rstrip()


class InputError(StepidError, ValueError):
    """The data or arguments handed in cannot be right: a bad file, row, unit or label."""


@contextmanager
def naming(place: str) -> Iterator[None]:
    """Put a file, run or column in front of the cause of an `InputError` that is raised inside.

    Parameters
    ----------
    place : str
        What is named.

    Yields
    ------
    None

    Raises
    ------
    InputError
        The one that was raised inside, so named.
    """
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}: {error.cause}", error.remedy) from None


class IdentificationError(StepidError, ValueError):
    """The data are readable but do not determine what was asked for."""


class NotSettledError(IdentificationError):
    """The response has not come to rest where its steady state is needed."""


class NoStepError(IdentificationError):
    """The record holds no step (or release) from which to read characteristics."""


class NoOvershootError(IdentificationError):
    """The response does not overshoot, so Eqs. 7 and 8 do not apply to it."""


class UndeterminedError(IdentificationError):
    """The stacked system or fit leaves a parameter free; the message names it and the run to add."""


class ConvergenceError(IdentificationError):
    """A fit did not converge; the message carries the best result so far."""


class MissingPackageError(StepidError, ImportError):
    """An optional package is not installed; the message names the extra that brings it."""
