"""Sensors that are slower than the clock of their record: each reading is repeated until there is a new one."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stepid.core.base import Array, Index
from stepid.core.input_levels import levelled
from stepid.core.noise import reading_step
from stepid.core.once import once
from stepid.core.outliers import Mask
from stepid.core.words import capitalized, runs_named

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

_MOVES = 3.0  # steps of the reading, that it changes by where the cart does not just creep over one of them
_SHARE = 0.25  # of such changes that repeats follow: lost samples that are filled so are one in eight at most
_FEWEST = 8  # such changes
_LEAST = 24  # new readings of a record that is taken at its sensor's rate
_BUSY = 0.05  # share of samples with a new input, above which none may be left out
_JITTER = 0.25  # samples, by which readings are off an even clock beside when they are shown
_SLIPS = 0.05  # samples, by which a clock of its own moves along those of the record
_NEAR, _FINE = 0.03, 0.05  # of the period, within which it is sought; samples that its last tick moves by at a step
_EXACT = 1e-9


class AtSensorRate(NamedTuple):
    """A record without repeated readings, and which of its samples hold none of their own, for the input's sake.

    `period` is from one reading to the next, and `early` how much earlier each may have been taken, s; `out` tells
    whether repeats could be left out.
    """

    run: Experiment
    stale: Mask
    period: float
    early: float
    out: bool


@once
def at_sensor_rate(experiment: Experiment) -> AtSensorRate | None:
    """Take a record at the rate of its sensor; None where that is as fast as the clock.

    A cart that moves by three steps of the reading or more from one reading to the next, before and after, has not
    stood still in between: readings repeated there are old ones (a hold of zero order). Samples at which the input
    changes stay, with a reading between those around them that does not count.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    AtSensorRate or None
        With the record as it is where the input changes at too many samples to leave any out.
    """
    y, volts = experiment.position, experiment.input
    new = np.flatnonzero(np.diff(y) != 0) + 1
    period = _period(y, new, reading_step(experiment))
    if period is None:
        return None
    steps = levelled(experiment)  # noise on an input is no change of it
    changes = np.flatnonzero(np.diff(steps.input, prepend=steps.input_before))
    at, reading, *about = _taken(y, new, period)
    period, early = (samples * experiment.sample_time for samples in about)
    if at.size < _LEAST or changes.size > _BUSY * y.size or experiment.input_between != "held":
        return AtSensorRate(experiment, np.zeros(y.size, dtype=bool), period, early, False)
    apart = changes[np.abs(changes[:, None] - at).min(axis=1, initial=np.inf) > _EXACT]
    index = np.sort(np.concatenate([at, apart]))
    update = {
        "time": _frozen(np.interp(index, np.arange(y.size), experiment.time)),
        "input": volts[np.floor(index + _EXACT).astype(np.intp)],
        "position": _frozen(np.interp(index, at, reading)),
    }
    return AtSensorRate(experiment.model_copy(update=update), np.isin(index, apart), period, early, True)


def at_sensor_rates(runs: Sequence[Experiment]) -> tuple[list[Experiment], dict[str, AtSensorRate]]:
    """Take records whose sensor is slower than their clock at its rate; these by name."""
    slow = {run.name: found for run in runs if (found := at_sensor_rate(run)) is not None}
    return [slow[run.name].run if run.name in slow else run for run in runs], slow


def sensor_notes(
    slow: Mapping[str, AtSensorRate], taken: Callable[[AtSensorRate], str] = lambda _: "The repeats are left out."
) -> list[str]:
    """Say of which runs, by their names, the sensor is slower than the clock, and how they are `taken`."""
    alike: dict[str, list[str]] = {}
    for name, found in slow.items():
        how = taken(found) if found.out else "Record at that rate."
        said = f"every {found.period:.2g} s only, and repeats the last one in between. {how}"
        alike.setdefault(said, []).append(name)
    return [f"{capitalized(runs_named(names))}: the sensor has a new reading {said}" for said, names in alike.items()]


def _period(y: Array, new: Index, step: float) -> float | None:
    """Samples from one new reading to the next, the mean where the cart moves; None where none is repeated."""
    clear = np.abs(y[new] - y[new - 1]) >= _MOVES * step * (1 - _EXACT)
    lasts = np.diff(new)[clear[:-1] & clear[1:]]
    repeats = np.count_nonzero(lasts > 1)
    if repeats < _FEWEST or repeats < _SHARE * lasts.size:
        return None
    usual = np.abs(lasts - np.median(lasts)) <= 1  # others skip a reading that was like the one before
    return float(np.mean(lasts[usual]))


class _Taken(NamedTuple):
    """When readings were taken, and how much earlier each may have been, in samples; what they are; their period."""

    at: Array
    reading: Array
    period: float
    early: float


def _taken(y: Array, new: Index, period: float) -> _Taken:
    """When readings were taken, also those of a cart at rest that are like the one before.

    A sensor with an even clock of its own took each after the sample before the one that shows it first: the middle of
    what that leaves is taken, which is little where its period is no multiple. Where it keeps step with the samples, or
    no even clock fits, each counts as taken when it is first shown.
    """
    number, ticks = _clock(new, period)
    begin = new - ticks * number
    early = 1.0 - float(np.ptp(begin))
    if early > -_JITTER:
        own = early < 1.0 - _SLIPS
        at, period, early = float(begin.min()) - own * early / 2 + ticks * number, ticks, max(early, 0.0)
    else:
        number = np.cumsum(np.maximum(np.rint(np.diff(new, prepend=new[0] - period) / period), 1)).astype(np.intp) - 1
        at, early = new.astype(np.float64), 1.0
    first, more = -math.floor(at[0] / period), math.floor((y.size - 1 - at[-1]) / period)
    every = np.arange(first, number[-1] + 1 + more)
    last = np.maximum(np.searchsorted(number, every, side="right") - 1, 0)
    return _Taken(
        at=at[last] + period * (every - number[last]),
        reading=np.where(every < 0, y[0], y[new[last]]),
        period=period,
        early=early,
    )


def _clock(new: Index, period: float) -> tuple[Index, float]:
    """Number of each reading by an even clock near a period, whose ticks they follow soonest, and its period [samples].

    On a circle of a trial period, all readings lie within an arc from a tick on: the shortest is that of the clock.
    """
    turns = float(new[-1] - new[0]) / period
    number, shortest, best = np.zeros(new.size, dtype=np.intp), math.inf, period
    for trial in period * (1 + _NEAR * np.linspace(-1, 1, 2 * math.ceil(_NEAR * turns * period / _FINE) + 1)):
        phase = np.sort(new % trial)
        gaps = np.diff(phase, append=phase[0] + trial)
        widest = int(np.argmax(gaps))
        if (arc := float(trial - gaps[widest])) < shortest - _EXACT:
            tick = phase[(widest + 1) % new.size]
            number = np.rint((new - tick - arc / 2) / trial).astype(np.intp)
            shortest, best = arc, float(trial)
    line = float(np.polyfit(number, new, 1)[0])
    arcs = {trial: float(np.ptp(new - trial * number)) for trial in (best, line)}
    return number - number[0], min(arcs, key=arcs.__getitem__)


def _frozen(values: Array) -> Array:
    values.setflags(write=False)
    return values
