"""What is wrong with one run's record, as fits and diagnoses tell it."""

from __future__ import annotations

from stepid.core.base import Finite, Label, Model

ALL_RUNS = "all runs"  # as the run of a fault that all records share


class RecordFault(Model):
    """A fault of one record, with its size.

    Parameters
    ----------
    run : str
        Name of the run, or `ALL_RUNS`.
    kind : str
        What sort of fault: ``"outliers"``, ``"misread input"``, ``"hum"``, ``"added_mass"``, ``"gain"``,
        ``"disagreement"``, …
    size : float
        In `unit`.
    unit : str
        SI, ``"m"``; ``""`` for a pure number.
    words : str
        What the user is told.
    """

    run: Label
    kind: Label
    size: Finite
    unit: str
    words: str
