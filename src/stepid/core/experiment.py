"""What was measured: one record, the known mass differences, and the campaign that holds them."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, model_validator

from stepid.core.base import Finite, Label, Model, NonNegative, Positive, Vector
from stepid.core.collection import Runs, as_tuple, check_names
from stepid.core.frames import make_frame, tidy_frame
from stepid.core.mass_offset import WEIGHT_UNCERTAINTY as WEIGHT_UNCERTAINTY
from stepid.core.mass_offset import MassOffset as MassOffset
from stepid.core.mass_offset import chained
from stepid.core.noise import record_grid
from stepid.core.quantities import InputUnit, Motion, in_own_quantities, middle_dot
from stepid.core.samples import CLOSE, InputBetween, Starts, check_samples, off_even_clock
from stepid.core.slices import segment
from stepid.core.takes import described
from stepid.core.tidy import run_fields
from stepid.core.units import record

if TYPE_CHECKING:
    from stepid.core.frames import DataFrame


class Experiment(Model):
    """One record of a mass-spring-damper plant.

    Parameters
    ----------
    name : str
        Unique within a campaign, for example ``"case 5"``.
    time : array, shape (n,)
        s, increasing. Times that are off an even clock are taken with a note by `fit` and `diagnose`.
    position : array, shape (n,)
        m, from any zero.
    input : array, shape (n,)
        V, at each sample; zeros for a free release.
    added_mass : float
        kg, known weights on top of the unknown base mass.
    spring, damper, base : str
        Runs with the same label share one stiffness, one damping constant, one base mass.
    counts_per_meter : float or None
        The encoder's scale and sign, for writing back and the resolution. Without it the readings tell their step.
    input_before : float
        V before the first sample; the plant rests there unless the record starts in motion.
    input_between : "held", "lines" or "smooth"
        What the input does between two samples: each value is held until the next (a logged DAC), values are joined by
        straight lines (``scipy.signal.lsim``), or by the cubic spline through all of them.
    starts : "auto", "rest" or "motion"
        At rest under `input_before`, or in motion, as a slice of a longer record: then the initial position and
        velocity are fitted, from the first sample on. "auto" looks at the data.

    Raises
    ------
    stepid.errors.InputError
        If lengths differ, a value is not finite, time does not increase or a label is empty.
    """

    name: Label
    time: Vector
    position: Vector
    input: Vector
    added_mass: NonNegative
    spring: Label
    damper: Label
    counts_per_meter: Finite | None = None
    input_before: Finite = 0.0
    base: Label = "cart"
    input_between: InputBetween = "held"
    starts: Starts = "auto"

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        check_samples(self.time, self.position, self.input, self.counts_per_meter)
        return self

    @cached_property
    def sample_time(self) -> float:
        """Sample time, s; of uneven samples the usual one."""
        if off_even_clock(self.time).max() > CLOSE:
            return float(np.median(np.diff(self.time)))
        return (float(self.time[-1]) - float(self.time[0])) / (self.time.size - 1)

    @property
    def resolution(self) -> float | None:
        """Position of one encoder count, m; without a scale the step that all readings lie on, if there is one."""
        return record_grid(self) if self.counts_per_meter is None else 1.0 / abs(self.counts_per_meter)

    @property
    def is_release(self) -> bool:
        """True where there is no input at all, so that any motion comes from the initial state."""
        return self.input_before == 0 and not np.any(self.input)

    @in_own_quantities
    def slice(
        self,
        first: int | None = None,
        last: int | None = None,
        *,
        after: float | None = None,
        until: float | None = None,
        name: str | None = None,
    ) -> Self:
        """Return a segment of the record, which starts in motion unless it begins where the record does.

        Parameters
        ----------
        first, last : int, optional
            Samples to keep, counted from 0, `last` not included; negative ones count from the end.
        after, until : float, optional
            s on the record's clock, in place of `first` and `last`; the sample at `until` is included.
        name : str, optional
            Of the segment; the record's by default.

        Returns
        -------
        Experiment

        Raises
        ------
        stepid.errors.InputError
            If a bound is given twice or is no number, or fewer than 8 samples are left.
        """
        fields = segment(self, first, last, after=after, until=until, name=name)
        return type(self)(**fields)._bearing(self.provenance)

    @classmethod
    def from_dataframe(
        cls,
        frame: Any,
        *,
        name: str,
        added_mass: float,
        spring: str,
        damper: str,
        time: str = "time",
        position: str = "position",
        input: str = "input",
        time_scale: float = 1.0,
        position_scale: float = 1.0,
        input_scale: float = 1.0,
        counts_per_meter: float | None = None,
        input_before: float = 0.0,
        base: str = "cart",
        input_between: InputBetween = "held",
        starts: Starts = "auto",
    ) -> Self:
        """Make an experiment from a pandas DataFrame (or anything indexed by column name).

        Parameters
        ----------
        frame : pandas.DataFrame
            One row a sample.
        name, added_mass, spring, damper, counts_per_meter, input_before, base, input_between, starts
            Fields of `Experiment`.
        time, position, input : str
            Names of the columns; of clock times (the first is 0) and durations the seconds are taken.
        time_scale, position_scale, input_scale : float
            s, m and V per unit of those columns, as in `read_table`.

        Raises
        ------
        stepid.errors.InputError
            If a column is missing, its content is not numeric, its name (``"x_mm"``) belies its scale, or a field is
            wrong.
        """
        columns = {"time": time, "position": position, "input": input}
        scales = {"time": time_scale, "position": position_scale, "input": input_scale}
        arrays: dict[str, Any] = record(frame, columns, scales, f"run {described(name)}")
        return cls(
            **arrays,
            name=name,
            added_mass=added_mass,
            spring=spring,
            damper=damper,
            counts_per_meter=counts_per_meter,
            input_before=input_before,
            base=base,
            input_between=input_between,
            starts=starts,
        )

    def to_dataframe(self) -> DataFrame:
        """Return the record as a pandas DataFrame: columns `time` [s], `position` [m] and `input` [V].

        Raises
        ------
        stepid.errors.MissingPackageError
            If pandas is not installed.
        """
        return make_frame({field: np.array(getattr(self, field)) for field in ("time", "position", "input")})


class Campaign(Runs):
    """Runs of one plant under known changes of mass, spring and damper: a collection of them.

    ``len(campaign)``, ``for run in campaign``, ``campaign["case 4"]``, ``campaign[0]``, ``campaign[1:]``,
    ``campaign[["case 4", "case 6"]]``, ``campaign + run`` and ``"case 4" in campaign`` do what they do elsewhere.

    Parameters
    ----------
    name : str
    experiments : tuple of Experiment
        Names are unique. A list is taken, too.
    weight_uncertainty : float
        kg, standard uncertainty of one 0.5 kg weight; grows with the square root of the mass added.
    scale_uncertainty : float
        Relative standard uncertainty of the scale of all positions (counts per meter), one error shared by all runs.
    motion : "translation" or "rotation"
        Of a rotation, all that is in kg, m and N here is in kg·m², rad and N·m; numbers, names and keys are the same.
    input_unit : "V", "A", "N" or "N·m"
        Of the input, in place of V.

    Raises
    ------
    stepid.errors.InputError
        If there is no experiment, a name occurs twice, or a rotation is said to be driven in N.
    """

    name: Label
    experiments: Annotated[tuple[Experiment, ...], BeforeValidator(as_tuple)]
    weight_uncertainty: Positive = WEIGHT_UNCERTAINTY
    scale_uncertainty: NonNegative = 0.0
    motion: Motion = "translation"
    input_unit: Annotated[InputUnit, BeforeValidator(middle_dot)] = "V"

    @model_validator(mode="after")
    def _unique(self) -> Self:
        check_names([e.name for e in self.experiments])
        if self.motion == "rotation" and self.input_unit == "N":
            raise ValueError("a rotation is not driven in N; give the torque, force times lever arm, in N·m")
        return self

    @property
    def mass_offsets(self) -> tuple[MassOffset, ...]:
        """Mass differences (Eq. 9), runs of one base sorted by added mass, each to the next.

        Runs of equal added mass keep the campaign's order and are joined by an exact constraint.
        """
        return chained([(e.name, e.base, e.added_mass) for e in self.experiments], self.weight_uncertainty)

    @classmethod
    def from_dataframe(
        cls,
        frame: Any,
        *,
        name: str,
        weight_uncertainty: float = WEIGHT_UNCERTAINTY,
        scale_uncertainty: float = 0.0,
        motion: Motion = "translation",
        input_unit: InputUnit = "V",
        time_scale: float = 1.0,
        position_scale: float = 1.0,
        input_scale: float = 1.0,
    ) -> Self:
        """Make a campaign from a tidy pandas DataFrame, as `to_dataframe` gives it.

        Parameters
        ----------
        frame : pandas.DataFrame
            One row a sample; columns `run`, `time`, `position`, `input`, `added_mass`, `spring`, `damper`
            and, where they differ from the defaults of `Experiment`, `base`, `counts_per_meter`, `input_before`,
            `input_between` and `starts`.
        name, weight_uncertainty, scale_uncertainty, motion, input_unit
            Fields of `Campaign`.
        time_scale, position_scale, input_scale : float
            s, m and V per unit of those columns, as in `read_table`.

        Raises
        ------
        stepid.errors.InputError
            If a column is missing or not numeric, or what belongs to a whole run changes within it.
        """
        scales = {"time": time_scale, "position": position_scale, "input": input_scale}
        runs = [Experiment(**fields) for fields in run_fields(frame, scales, f"campaign {described(name)}")]
        return cls(
            name=name,
            experiments=tuple(runs),
            weight_uncertainty=weight_uncertainty,
            scale_uncertainty=scale_uncertainty,
            motion=motion,
            input_unit=input_unit,
        )

    def to_dataframe(self) -> DataFrame:
        """Return all records as one tidy pandas DataFrame, one row a sample.

        Columns: `run`, `time` [s], `position` [m], `input` [V], `added_mass` [kg], `counts_per_meter` (NaN where not
        known), `input_before` [V], `spring`, `damper`, `base`, `input_between`, `starts`.

        Raises
        ------
        stepid.errors.MissingPackageError
            If pandas is not installed.
        """
        return tidy_frame(self.experiments)
