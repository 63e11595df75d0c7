"""Whether a record starts in motion, so that its initial state has to be fitted."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.input_levels import levelled
from stepid.core.noise import rms, span_at_rest
from stepid.core.once import once
from stepid.core.samples import course

_LEAD = 5  # samples before the first change of the input that tell rest from motion
_EARLY = 3  # samples, by which the plant may move before the recorded input does: a trigger comes so early
_SHARE = 0.1  # of the travel, less before the first change is drift, or a plant that something shakes
_FREE = 0.06  # of half the travel: a swing of its own so large at the first sample is motion
_STEPPED = 0.7  # the same where the input is a step at the first samples, as records from rest have it
_OFF = 0.3  # the same for a cart that is away from its rest and has no speed: friction may hold it there
_SURE = 6.0  # standard errors
_PERIODS = 3.0  # of the record's swing, which are looked at
_ROUND = 12  # part of a period in which the speed must be seen in the readings themselves
_BUSY = 0.05  # share of samples with a new input, above which it changes all the time
_POOR = 0.3  # of the motion, left by a fit that says nothing about the start
_FEWEST = 16  # samples


@once
def starts_in_motion(experiment: Experiment) -> bool:
    """Tell whether a record starts in motion: what `Experiment.starts` says, or with "auto" what the data show.

    A record without input that moves was released. A driven one is at rest where the readings before the first change
    of the input are, the last three before it apart: the plant starts before the record says so where a trigger is
    early. Where the input changes too soon for that, m x″ + c x′ + k x = K_f u + d is fitted in integral form to the
    first periods, with a free initial state, and the record is in motion where that state is as large as a notable
    share of the travel, and its speed is seen in the first readings, too.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    bool
    """
    if experiment.starts != "auto":
        return experiment.starts == "motion"
    travel = float(np.ptp(experiment.position))
    if experiment.is_release or travel <= 0:
        return travel > 0
    quiet = span_at_rest(experiment)
    experiment = levelled(experiment)
    changes = np.flatnonzero(np.diff(experiment.input, prepend=experiment.input_before))
    lead = int(changes[0]) if changes.size else experiment.input.size
    seen = max(lead + 1 - _EARLY, _LEAD)
    before = float(np.ptp(experiment.position[:seen]))
    if lead >= _LEAD and before <= quiet:
        return False
    period = _period(experiment)
    if changes.size <= _BUSY * experiment.input.size and lead >= _LEAD:
        share = _SHARE * min(1.0, 2 * np.pi * (seen - 1) / period)  # a swing's share that so short a time shows
        return before > max(quiet, share * travel)
    return _moves_by_itself(experiment, round(_PERIODS * period), max(1, round(period / _ROUND)), changes.size)


def _period(experiment: Experiment) -> float:
    """Samples of a period of the strongest oscillation."""
    y = np.diff(experiment.position)
    power = np.abs(np.fft.rfft(y * np.hanning(y.size))) ** 2
    at = 1 + int(np.argmax(power[1:]))
    return float(y.size / at)


def _moves_by_itself(experiment: Experiment, window: int, soon: int, changes: int) -> bool:
    """Tell by the initial state of a fit in integral form to `window` samples; `soon` samples show its speed."""
    n = min(max(window, _FEWEST), experiment.time.size)
    y = experiment.position[:n] - experiment.position[0]
    time = experiment.time[:n] - experiment.time[0]
    busy = changes > _BUSY * experiment.input.size
    columns = [np.ones(n), time, 0.5 * time**2, *_integrals(time, y)]
    volts = experiment.input[:n] - experiment.input_before
    if np.any(volts != volts[0]):
        columns.append(_integrals(time, volts, course(time, volts, experiment.input_between))[1])
    a = np.column_stack(columns)
    size = np.linalg.norm(a, axis=0)
    if not size.all():  # nothing moves yet
        return False
    values, _, rank, _ = np.linalg.lstsq(a / size, y, rcond=1e-10)
    free = n - a.shape[1]
    if rank < a.shape[1] or free < 4:
        return False
    left = y - a / size @ values
    covariance = np.linalg.inv((a / size).T @ (a / size)) * float(left @ left) / free / np.outer(size, size)
    first, slope, push, damping, stiffness = (values / size)[:5] * (1, 1, 1, -1, -1)
    if not stiffness > 0 or rms(left) > _POOR * float(np.std(y)):
        return False
    omega, half = float(np.sqrt(stiffness)), 0.5 * float(np.ptp(experiment.position))
    speed, spread = slope - damping * first, float(np.sqrt(covariance[1, 1]))
    seen = (y[min(soon, n - 1)] - y[0]) * np.sign(speed) >= 0.5 * abs(speed) * time[min(soon, n - 1)]
    fast: bool = abs(speed) > max((_FREE if busy else _STEPPED) * half * omega, _SURE * spread) and seen
    if fast or not busy:
        return bool(fast)
    away, unsure = first - push / stiffness, float(np.sqrt(covariance[2, 2])) / stiffness
    return bool(abs(away) > max(_OFF * half, _SURE * unsure))


def _integrals(time: Array, values: Array, pieces: Array | None = None) -> tuple[Array, Array]:
    """Integral and double integral from the first sample on, of a polynomial a sample, by default the spline's."""
    pieces = course(time, values, "smooth") if pieces is None else pieces
    h = np.diff(time)
    once, twice = np.zeros_like(h), np.zeros_like(h)
    for power in range(pieces.shape[1]):
        term = pieces[:-1, power] * h ** (power + 1) / (power + 1)
        once += term
        twice += term * h / (power + 2)
    first = np.concatenate([[0.0], np.cumsum(once)])
    return first, np.concatenate([[0.0], np.cumsum(first[:-1] * h + twice)])
