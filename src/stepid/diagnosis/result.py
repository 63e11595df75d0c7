"""What a diagnosis says: the result models of the second half of the workflow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

import numpy as np

from stepid.core.base import Finite, Label, Model, NonNegative, Vector
from stepid.core.estimate import Estimate
from stepid.core.experiment import Campaign
from stepid.core.frames import make_frame, parameter_frame, rows_of
from stepid.core.latex import parameter_table
from stepid.core.quantities import InputUnit, Motion
from stepid.core.words import length
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.differences import Scatter
from stepid.diagnosis.headline import leaves_noise
from stepid.diagnosis.text import as_html, as_text, one_line
from stepid.diagnosis.written import Written
from stepid.fitting.record_fault import RecordFault
from stepid.simulation.model import PlantModel, parameter_unit

if TYPE_CHECKING:
    from stepid.core.frames import DataFrame

Verdict = Literal["adequate", "named", "ambiguous", "unexplained"]


class Gap(Model):
    """RMS of measured minus simulated, m, over all samples of the runs concerned.

    Parameters
    ----------
    before : float
        Joint fit of the linear plant.
    after : float
        With the effects of the diagnosis added, and the conditions that differ from run to run (`Diagnosis.scatter`)
        free; equal to `before` where there are neither.
    noise : float
        Noise floor: what a perfect model would leave.
    held_out_before, held_out_after : float or None
        On runs that the fit did not see, the linear plant with the same conditions free: these, and freedoms that an
        effect has in every run, are estimated on the first part of the run, and the rest is judged. None where no run
        qualifies.
    """

    before: NonNegative
    after: NonNegative
    noise: NonNegative
    held_out_before: NonNegative | None = None
    held_out_after: NonNegative | None = None

    @property
    def held_out(self) -> tuple[float, float] | None:
        """RMS before and after on runs that the fit did not see, m; None where no run qualifies."""
        if self.held_out_before is None or self.held_out_after is None:
            return None
        return self.held_out_before, self.held_out_after


class RunGap(Model):
    """One run: measured and simulated records and their gap.

    `phases` maps "before", "driven", "rise", "overshoot", "ring-down" and "rest" to the RMS [m] of the linear model's
    residual in that phase of the run's responses; "driven" is where the input changes all the time. `explained` is the
    share of the linear model's misfit in this run, in power, that the final model takes; negative where it adds to it.
    """

    name: Label
    time: Vector
    measured: Vector
    linear: Vector
    model: Vector
    before: NonNegative
    after: NonNegative
    held_out_before: NonNegative | None = None
    held_out_after: NonNegative | None = None
    phases: Mapping[str, NonNegative] = {}
    explained: Finite = 0.0

    def to_dataframe(self) -> DataFrame:
        """Return the records as a pandas DataFrame: columns `time` [s], `measured`, `linear` and `model` [m]."""
        return make_frame({f: np.array(getattr(self, f)) for f in ("time", "measured", "linear", "model")})

    def __repr__(self) -> str:
        return f"RunGap({self.name!r}, RMS {length(self.before)} → {length(self.after)})"


class Where(Model):
    """Where the linear model and the measurement disagree.

    Parameters
    ----------
    phases : mapping
        Phase of the response to RMS [m] over all runs.
    velocity_levels, velocity_force : arrays, shape (b,)
        Force [N] that would produce the residual, averaged in bins of velocity [m/s]: a step at zero is Coulomb
        friction. Where its shape is clear, what the linear parameters took in its place has been given back.
    position_levels, position_force : arrays, shape (b,)
        The same against position from rest [m]: a cubic is a cubic.
    runs : mapping
        Run to RMS [m].
    trends : mapping
        Correlation (−1 … 1) of the runs' RMS with "mass", "size" and "direction" of the step, where they vary.
    sentences : tuple of str
        The same in words.
    jump : float or None
        N, by how much the residual force jumps where the velocity changes sign; None where it has no such shape.
    """

    phases: Mapping[str, NonNegative]
    velocity_levels: Vector
    velocity_force: Vector
    position_levels: Vector
    position_force: Vector
    runs: Mapping[str, NonNegative]
    trends: Mapping[str, Finite]
    sentences: tuple[str, ...]
    jump: Finite | None = None

    def summary(self) -> str:
        """Return the sentences, one a line."""
        return "\n".join(self.sentences)

    def __repr__(self) -> str:
        return f"Where({'; '.join(self.sentences)})"

    __str__ = summary


class Ranked(Model):
    """One candidate set of effects in the ranking.

    Parameters
    ----------
    effects : tuple of str
    rms : float
        m, what it leaves.
    evidence : float
        QBIC less that of the best candidate, so 0 is best; see `stepid.diagnosis.evidence`.
    parameters : mapping
        Of the effects, by name.
    deviations : tuple of str
        Conditions that differ from run to run.
    explained : float
        Share of the linear model's misfit that it takes, in power.
    probability : float
        Its weight among the candidates: a probability where one of them is all that is missing, see
        `Diagnosis.reaches_noise`.
    """

    effects: tuple[str, ...]
    rms: NonNegative
    evidence: Finite
    parameters: Mapping[str, Finite] = {}
    deviations: tuple[str, ...] = ()
    explained: Finite = 0.0
    probability: NonNegative = 0.0

    def _unit(self, field: str, key: str = "") -> str:
        return parameter_unit(key) if field == "parameters" else super()._unit(field, key)


class Diagnosis(Written):
    """Whether a linear model is adequate, and if not, what is missing.

    Parameters
    ----------
    campaign : str
        Name of the campaign.
    verdict : str
        ``"adequate"``, ``"named"``, ``"ambiguous"`` or ``"unexplained"``.
    effects : tuple of str
        Canonical names of the effects added, () when adequate.
    alternatives : tuple of tuple of str
        Sets of effects that the data cannot tell from `effects`.
    gap : Gap
    parameters : mapping
        Name to Estimate of the final model.
    linear_parameters : mapping
        The same of the linear joint fit.
    where : Where
    next_experiment : str or None
        What to measure next when the data cannot tell.
    advice : mapping
        What to do about each named effect in the lab, by its name.
    reasons : tuple of str
        Why the verdict is what it is, in words.
    notes : tuple of str
        What else was noticed: segments left out, undetermined parameters, faults of the manifest that the data show.
    ranking : tuple of Ranked
        Candidates, best first; the linear model is the entry without effects.
    runs : tuple of RunGap
    model, linear_model : PlantModel
    explained : float or None
        Share of the linear model's misfit that the answer takes on runs left out of the fit, in power, the conditions
        and starts that are free in the answer free in both; None where no run can be left out, or the linear model
        leaves only noise there.
    left : float
        Per cent: what the answer leaves over the motion about rest, RMS.
    probability : float or None
        That the answered set holds the truth; None where no effect is named.
    scatter : mapping
        ``"start_time"``, ``"gain"``, ``"rest"``, ``"damping"``, ``"friction"``, ``"start_offset"`` or
        ``"start_velocity"`` to `Scatter`: what the runs differ by.
    faults : tuple of RecordFault
        Faults of single records.
    wrong_inputs : tuple of str
        Runs whose input is plainly not what their record says between the samples: then no model can be judged.
    data : Campaign or None
        What was diagnosed, kept so that a report can show the peak method beside it; added masses that were noted for
        each other are exchanged in it.
    motion, input_unit : str
        Of the campaign, see `stepid.Campaign`.
    criteria : Criteria
        By which it was judged.
    """

    campaign: Label
    verdict: Verdict
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...] = ()
    gap: Gap
    parameters: Mapping[str, Estimate]
    linear_parameters: Mapping[str, Estimate]
    where: Where
    next_experiment: str | None = None
    advice: Mapping[str, str] = {}
    reasons: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    ranking: tuple[Ranked, ...] = ()
    runs: tuple[RunGap, ...] = ()
    model: PlantModel
    linear_model: PlantModel
    explained: Finite | None = None
    left: NonNegative = 0.0
    probability: NonNegative | None = None
    scatter: Mapping[str, Scatter] = {}
    faults: tuple[RecordFault, ...] = ()
    wrong_inputs: tuple[str, ...] = ()
    data: Campaign | None = None
    motion: Motion = "translation"
    input_unit: InputUnit = "V"
    criteria: Criteria = Criteria()

    @property
    def reaches_noise(self) -> bool:
        """Whether a candidate leaves little more than noise: else the weights of `ranking` are no probabilities."""
        return not (self.ranking and self.gap.noise) or any(leaves_noise(self, one) for one in self.ranking)

    def to_dataframe(self) -> DataFrame:
        """Return the parameters as a pandas DataFrame: index `parameter`, columns `value`, `uncertainty`, `unit`."""
        return parameter_frame(rows_of(self.parameters))

    def to_latex(self, *, caption: str | None = None, label: str | None = None) -> str:
        """Return the parameters as a LaTeX table for siunitx, with a caption as a float; see `stepid.core.latex`."""
        return parameter_table(rows_of(self.parameters), caption=caption, label=label)

    def summary(self) -> str:
        """Return the answers to the five questions: noise floor, where, which, is it, what next; with tables."""
        return as_text(self)

    def __repr__(self) -> str:
        return one_line(self)

    __str__ = summary

    def _repr_html_(self) -> str:
        return as_html(self)
