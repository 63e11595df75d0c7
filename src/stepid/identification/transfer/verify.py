"""Verification step responses: the identified models against the measurement (Figs. 3 and 6 to 8)."""

from __future__ import annotations

import math

import numpy as np

from stepid.core.arguments import as_campaign
from stepid.core.base import Array
from stepid.core.experiment import Campaign, Experiment
from stepid.core.noise import rms
from stepid.core.quantities import in_own_quantities
from stepid.core.recorded import recorded
from stepid.core.takes import a, takes
from stepid.errors import IdentificationError
from stepid.identification.characteristics import characterize, characterize_each
from stepid.identification.characteristics_model import Characteristics
from stepid.identification.free_response import is_free_response
from stepid.identification.parameters import IdentifiedParameters
from stepid.identification.second_order import settling_time
from stepid.identification.steps import Step, find_steps
from stepid.identification.transfer import free_responses, held_response
from stepid.identification.transfer.verification import Verification, VerificationRun

_REST = 20  # samples before a later step that show where the plant rests


@in_own_quantities
@takes(parameters=a(IdentifiedParameters, "what stepid.identify returns"))
@recorded()
def verify(parameters: IdentifiedParameters, campaign: Campaign) -> Verification:
    """Simulate each identified run on its measured input with python-control, and compare.

    The plant rests before a step: the first one, or the first that characteristics can be read from, and the record
    is compared from there on. The rest position is the mean of the samples up to the one at which the input steps,
    where the plant has not moved yet; it is not fitted, so that an error of the static gain shows. The first peak is
    the measured one. Settling counts into a band of 2 % around what each comes to rest at, for the first step.

    A run that was released by hand has no input to simulate. It is compared from the first turning point that its
    characteristics were read from, with rest position, displacement and velocity there fitted by least squares.

    Parameters
    ----------
    parameters : IdentifiedParameters
        From `stepid.identify`.
    campaign : Campaign
        With the runs to compare. Runs that `parameters` excluded are left out.

    Returns
    -------
    Verification
        For each run fit per cent, RMS in all and before and after the first peak, both settling times, measured and
        simulated position.

    Raises
    ------
    stepid.errors.InputError
        If a run of the campaign was neither identified nor excluded.
    stepid.errors.IdentificationError
        If no run is left.
    """
    campaign = as_campaign(campaign)
    runs = tuple(_verify_run(parameters, e) for e in campaign.experiments if e.name not in parameters.excluded)
    if not runs:
        raise IdentificationError(
            f"campaign {campaign.name!r} has no run to verify: all were left out",
            "Read parameters.excluded for the reasons.",
        )
    return Verification(runs=runs)


def fit_percent(measured: Array, simulated: Array) -> float:
    """Fit 100·(1 − ‖y − ŷ‖/‖y − ȳ‖), %; 100 is perfect, 0 no better than the mean.

    Parameters
    ----------
    measured, simulated : array, shape (n,)
        In the same unit; `measured` not constant.

    Returns
    -------
    float
    """
    spread = float(np.linalg.norm(measured - measured.mean()))
    return 100.0 * (1.0 - float(np.linalg.norm(measured - simulated)) / spread)


def _verify_run(parameters: IdentifiedParameters, experiment: Experiment) -> VerificationRun:
    return (_verify_release if is_free_response(experiment) else _verify_step)(parameters, experiment)


def _verify_step(parameters: IdentifiedParameters, experiment: Experiment) -> VerificationRun:
    name = experiment.name
    first, read = _first_readable(experiment)
    # what came before a later step is no part of the comparison, the plant rests in the samples just before it
    begin = 0 if first.number == 1 else max(first.rest, first.began - _REST)
    since_begin = slice(begin, None)
    moved = held_response(
        parameters,
        name,
        input=experiment.input[since_begin],
        sample_time=experiment.sample_time,
        input_between=experiment.input_between,
        input_before=experiment.input_before if first.number == 1 else float(experiment.input[begin]),
    )
    resting = max(first.rest, begin)
    rest = float(experiment.position[resting : max(first.still, resting + 1)].mean())
    outward = math.copysign(1.0, parameters.static_gain[name] * first.size)
    swing = outward * experiment.position[first.start : first.stop + 1]
    top, ratio = int(np.argmax(swing)), _damping_ratio(parameters, name)
    return _compared(
        experiment,
        since_begin,
        rest + moved,
        peak=first.start - begin + top if ratio < 1 and 0 < top < swing.size - 1 else None,
        settles=None if read is None else read.settling_time,
        model_settles=settling_time(_natural_frequency(parameters, name), ratio) if 0 < ratio < 1 else None,
    )


def _first_readable(experiment: Experiment) -> tuple[Step, Characteristics | None]:
    """Return the step that the run's characteristics come from, with them; the first step where none can be read."""
    steps = find_steps(experiment)
    for step, read in zip(steps, characterize_each(experiment), strict=True):
        if isinstance(read, Characteristics):
            return step, read
    return steps[0], None


def _verify_release(parameters: IdentifiedParameters, experiment: Experiment) -> VerificationRun:
    start = characterize(experiment).start
    part = slice(int(np.searchsorted(experiment.time, start)) if start is not None else 0, None)
    measured = experiment.position[part]
    free = free_responses(parameters, experiment.name, samples=measured.size, sample_time=experiment.sample_time)
    # one column a unknown: rest, displacement and velocity at the start; velocity scaled to a like size
    scale = np.array([1.0, 1.0, _natural_frequency(parameters, experiment.name)])
    basis = np.column_stack([np.ones(measured.size), free]) * scale
    solution, *_ = np.linalg.lstsq(basis, measured, rcond=None)
    return _compared(experiment, part, basis @ solution, peak=None, settles=None, model_settles=None)


def _natural_frequency(parameters: IdentifiedParameters, run: str) -> float:
    """ω_n = √(k/m) of the identified model, rad/s (Eq. 5)."""
    return math.sqrt(parameters.run_stiffness(run) / parameters.masses[run])


def _damping_ratio(parameters: IdentifiedParameters, run: str) -> float:
    """ζ = c/(2√(km)) of the identified model."""
    return parameters.damping[run] / (2 * math.sqrt(parameters.run_stiffness(run) * parameters.masses[run]))


def _compared(
    experiment: Experiment,
    part: slice,
    simulated: Array,
    *,
    peak: int | None,
    settles: float | None,
    model_settles: float | None,
) -> VerificationRun:
    time, measured = experiment.time[part], experiment.position[part]
    error = measured - simulated
    return VerificationRun(
        name=experiment.name,
        time=time,
        measured=measured,
        simulated=simulated,
        fit_percent=fit_percent(measured, simulated),
        rms=rms(error),
        rms_before_peak=None if peak is None else rms(error[: peak + 1]),
        rms_after_peak=None if peak is None else rms(error[peak + 1 :]),
        peak_time=None if peak is None else float(time[peak]),
        settling_time_measured=settles,
        settling_time_simulated=model_settles,
    )
