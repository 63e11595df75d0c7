"""The result of comparing identified models with the measurement (Figs. 3 and 6 to 8)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Self

import numpy as np
from pydantic import model_validator

from stepid.core.base import Finite, Label, Model, NonNegative, Positive, Vector
from stepid.core.frames import make_frame
from stepid.core.quantities import InputUnit, Motion
from stepid.core.tables import html_table, text_table
from stepid.core.takes import described
from stepid.core.words import length
from stepid.errors import InputError

if TYPE_CHECKING:
    from stepid.core.frames import DataFrame


class VerificationRun(Model):
    """One run's measured and simulated response.

    Parameters
    ----------
    name : str
    time, measured, simulated : array, shape (n,)
        s, m, m; on the clock and zero of the record.
    fit_percent : float
        100·(1 − ‖y − ŷ‖/‖y − ȳ‖).
    rms, rms_before_peak, rms_after_peak : float
        m, of measured minus simulated: in all, up to and after the first peak; None where there is no such part.
    peak_time : float or None
        s, on the clock of the record: where before and after part.
    settling_time_measured, settling_time_simulated : float or None
        s, into the 2 % band from the step; None where the record does not show it.
    """

    name: Label
    time: Vector
    measured: Vector
    simulated: Vector
    fit_percent: Finite
    rms: NonNegative
    rms_before_peak: NonNegative | None = None
    rms_after_peak: NonNegative | None = None
    peak_time: Finite | None = None
    settling_time_measured: Positive | None = None
    settling_time_simulated: Positive | None = None

    @model_validator(mode="after")
    def _same_length(self) -> Self:
        if not self.time.size == self.measured.size == self.simulated.size:
            raise ValueError("time, measured and simulated differ in length")
        return self

    def to_dataframe(self) -> DataFrame:
        """Return the records as a pandas DataFrame: columns `time` [s], `measured` [m] and `simulated` [m]."""
        return make_frame({field: np.array(getattr(self, field)) for field in ("time", "measured", "simulated")})

    def __repr__(self) -> str:
        return f"VerificationRun({self.name!r}, fit {self.fit_percent:.1f} %, RMS {length(self.rms)})"


class Verification(Model):
    """Measured against simulated, run by run, made by `stepid.verify`.

    Parameters
    ----------
    runs : tuple of VerificationRun
    motion, input_unit : str
        Of the campaign, see `stepid.Campaign`.
    """

    runs: tuple[VerificationRun, ...]
    motion: Motion = "translation"
    input_unit: InputUnit = "V"

    def __getitem__(self, name: str) -> VerificationRun:
        """Return the run called `name`; InputError names the runs there are."""
        for run in self.runs:
            if isinstance(name, str) and run.name == name:
                return run
        raise InputError(
            f"no verified run {described(name)}", f"There are: {', '.join(repr(run.name) for run in self.runs)}."
        )

    @property
    def fit_percent(self) -> Mapping[str, float]:
        """Run name to fit per cent."""
        return {run.name: run.fit_percent for run in self.runs}

    @property
    def rms(self) -> Mapping[str, float]:
        """Run name to RMS of measured minus simulated, m."""
        return {run.name: run.rms for run in self.runs}

    @property
    def rms_before_peak(self) -> Mapping[str, float | None]:
        """Run name to RMS up to the first peak, m."""
        return {run.name: run.rms_before_peak for run in self.runs}

    @property
    def rms_after_peak(self) -> Mapping[str, float | None]:
        """Run name to RMS after the first peak, m."""
        return {run.name: run.rms_after_peak for run in self.runs}

    @property
    def simulated(self) -> Mapping[str, Vector]:
        """Run name to simulated position, m, shape (n,)."""
        return {run.name: run.simulated for run in self.runs}

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (
                run.name,
                f"{run.fit_percent:.1f}",
                *(_micro(v) for v in (run.rms, run.rms_before_peak, run.rms_after_peak)),
                *(_seconds(v) for v in (run.settling_time_measured, run.settling_time_simulated)),
            )
            for run in self.runs
        ]

    def to_dataframe(self) -> DataFrame:
        """Return one row a run as a pandas DataFrame.

        Columns: `run`, `fit_percent`, `rms`, `rms_before_peak`, `rms_after_peak` [m], `peak_time`,
        `settling_time_measured`, `settling_time_simulated` [s]; NaN where the record does not show it.
        """
        fields = [f for f in VerificationRun.model_fields if f not in {"name", "time", "measured", "simulated"}]
        columns: dict[str, list[object]] = {"run": [run.name for run in self.runs]}
        for field in fields:
            values = [getattr(run, field) for run in self.runs]
            columns[field] = [np.nan if value is None else value for value in values]
        return make_frame(columns)

    def summary(self) -> str:
        """Return a table: fit per cent, RMS in all, before and after the first peak, and both settling times."""
        return text_table(_HEADER, self._rows(), title="Verification: measured against simulated")

    def __repr__(self) -> str:
        worst = min((run.fit_percent for run in self.runs), default=float("nan"))
        return f"Verification({len(self.runs)} runs, worst fit {worst:.1f} %)"

    __str__ = summary

    def _repr_html_(self) -> str:
        return html_table(_HEADER, self._rows(), title="Verification: measured against simulated")


_HEADER = (
    "run",
    "fit [%]",
    "RMS [µm]",
    "before peak [µm]",
    "after peak [µm]",
    "settles, measured [s]",
    "settles, simulated [s]",
)


def _micro(value: float | None) -> str:
    return "–" if value is None else f"{value * 1e6:.1f}"


def _seconds(value: float | None) -> str:
    return "–" if value is None else f"{value:.3f}"
