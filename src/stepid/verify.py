"""Verification step responses: the identified models against the measurement (Figs. 3 and 6 to 8)."""

from __future__ import annotations

import math

import numpy as np

from stepid._base import Array
from stepid.characteristics import characterize
from stepid.errors import IdentificationError
from stepid.experiment import Campaign, Experiment
from stepid.parameters import IdentifiedParameters
from stepid.settle import settling_time_measured
from stepid.steps import find_steps
from stepid.transfer import free_responses, held_response
from stepid.verification import Verification, VerificationRun


def verify(parameters: IdentifiedParameters, campaign: Campaign) -> Verification:
    """Simulate each identified run on its measured input with python-control, and compare.

    The plant rests before its first step. The rest position is the mean of the samples up to the one at which the
    input steps, where it has not moved yet; it is not fitted, so that an error of the static gain shows. The first
    peak is the measured one. Settling counts into a band of 2 % around static gain times step, for the first step.

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
    return (_verify_release if experiment.is_release else _verify_step)(parameters, experiment)


def _verify_step(parameters: IdentifiedParameters, experiment: Experiment) -> VerificationRun:
    name, first = experiment.name, find_steps(experiment)[0]
    moved = held_response(
        parameters,
        name,
        input=experiment.input,
        sample_time=experiment.sample_time,
        input_before=experiment.input_before,
    )
    rest = float(experiment.position[first.rest : first.start + 1].mean())
    level = parameters.static_gain[name] * first.size
    part = slice(first.start, first.stop + 1)
    since = experiment.time[part] - experiment.time[first.start]
    outward = math.copysign(1.0, level)
    swings = [outward * (experiment.position[part] - rest), outward * (moved[part] - moved[first.start])]
    top = int(np.argmax(swings[0]))
    peak = first.start + top if _overshoots(parameters, name) and 0 < top < since.size - 1 else None
    half = _half_period(parameters, name)
    settled = [settling_time_measured(since, swing, level=abs(level), half_period=half) for swing in swings]
    return _compared(experiment, slice(None), rest + moved, peak=peak, settled=[s and s[0] for s in settled])


def _verify_release(parameters: IdentifiedParameters, experiment: Experiment) -> VerificationRun:
    start = characterize(experiment).start
    part = slice(int(np.searchsorted(experiment.time, start)) if start is not None else 0, None)
    measured = experiment.position[part]
    free = free_responses(parameters, experiment.name, samples=measured.size, sample_time=experiment.sample_time)
    # one column a unknown: rest, displacement and velocity at the start; velocity scaled to a like size
    scale = np.array([1.0, 1.0, math.pi / _half_period(parameters, experiment.name)])
    basis = np.column_stack([np.ones(measured.size), free]) * scale
    solution, *_ = np.linalg.lstsq(basis, measured, rcond=None)
    return _compared(experiment, part, basis @ solution, peak=None, settled=[None, None])


def _half_period(parameters: IdentifiedParameters, run: str) -> float:
    """π/ω_n of the identified model, s: near half a period also where there is no ω_d."""
    return math.pi * math.sqrt(parameters.masses[run] / parameters.run_stiffness(run))


def _overshoots(parameters: IdentifiedParameters, run: str) -> bool:
    """True below critical damping, c < 2√(km)."""
    return parameters.damping[run] < 2 * math.sqrt(parameters.run_stiffness(run) * parameters.masses[run])


def _compared(
    experiment: Experiment, part: slice, simulated: Array, *, peak: int | None, settled: list[float | None]
) -> VerificationRun:
    time, measured = experiment.time[part], experiment.position[part]
    error = measured - simulated
    return VerificationRun(
        name=experiment.name,
        time=time,
        measured=measured,
        simulated=simulated,
        fit_percent=fit_percent(measured, simulated),
        rms=_rms(error),
        rms_before_peak=None if peak is None else _rms(error[: peak + 1]),
        rms_after_peak=None if peak is None else _rms(error[peak + 1 :]),
        peak_time=None if peak is None else float(time[peak]),
        settling_time_measured=settled[0],
        settling_time_simulated=settled[1],
    )


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2)))
