"""Where a record's input steps, and where it rests before."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array, Index
from stepid.core.experiment import Experiment
from stepid.core.input_levels import STEP, level_bounds, most_steps
from stepid.errors import NoStepError

HELD = 8
"""Samples that an input is held for, at least, between two steps: in fewer no response is read."""
_REST = 200  # samples before a step that count for its rest position


class Step(NamedTuple):
    """One step of the input.

    Parameters
    ----------
    start, stop : int
        First sample with the new input, and last sample of the response to it.
    size : float
        V, signed change of the input.
    number, total : int
        Which step of how many.
    began : int
        First sample that has some of it.
    rest, still : int
        First sample of the rest before it, and the first that is none any more.
    lead, spread : float
        s, from the step to its first sample, and how long it takes as a standard deviation: 0 where one sample has all
        of it. The response to a rise is the mean of those to steps along it, to second order that to a step in its
        middle.
    """

    start: int
    stop: int
    size: float
    number: int
    total: int
    began: int
    rest: int
    still: int
    lead: float = 0.0
    spread: float = 0.0

    @property
    def before(self) -> slice:
        """Samples at rest before it, its first one as well where the input has not moved until then."""
        return slice(self.rest, self.still)


def find_steps(experiment: Experiment) -> tuple[Step, ...]:
    """Find every step of the input.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    tuple of Step
        In order of time; changes below 5 % of the input's range, or within the noise of one that was measured, are
        taken for noise on it.

    Raises
    ------
    stepid.errors.NoStepError
        If the input never changes, or changes so often that it is no sequence of steps.
    """
    level = np.concatenate([[experiment.input_before], experiment.input])
    starts = _starts(level)
    if not starts.size and np.ptp(level) > 0:
        raise NoStepError(
            f"run {experiment.name!r}: the input changes slowly, by at most {100 * STEP:g} % of its range a sample, "
            "there is no step in it",
            "The peak method needs a step; stepid.fit takes any input.",
        )
    if not starts.size:
        raise NoStepError(
            f"run {experiment.name!r}: the input stays at {experiment.input_before:g} V, there is no step in it",
            "Record the step itself, or give input_before: the input that the plant rested at before the first sample.",
        )
    if starts.size > most_steps(experiment.input.size):
        raise NoStepError(
            f"run {experiment.name!r}: the input changes at {starts.size} of {experiment.input.size} samples, "
            "it is not a sequence of steps",
            "The peak method needs steps held until the plant rests; stepid.fit takes any input.",
        )
    groups = _groups(level, starts)
    began = [int(group[0]) for group in groups]
    new = [int(group[-1]) for group in groups]
    ramps = experiment.input_between != "held"  # to the next step's first sample it is under way already
    stops = [*(first - ramps for first in began[1:]), experiment.input.size - 1]
    rises = [_rise(experiment, level, *ends) for ends in zip(began, new, strict=True)]
    held = [0, *(start + 1 for start in new[:-1])]  # of the level before, which has one entry more
    return tuple(
        Step(
            start=new[i],
            stop=stops[i],
            # the levels before and after, not the single change: each may carry noise
            size=float(
                np.median(experiment.input[new[i] : max(stops[i] + ramps, new[i] + 1)])
                - np.median(level[held[i] : began[i] + 1])
            ),
            number=i + 1,
            total=len(groups),
            began=began[i],
            rest=max(new[i - 1] if i else 0, began[i] - _REST),
            still=began[i] + (not ramps or began[i] == 0),
            lead=lead,
            spread=spread,
        )
        for i, (lead, spread) in enumerate(rises)
    )


def _groups(level: Array, starts: Index) -> list[Index]:
    """Changes of the input, those together that follow one another the same way: one step that takes its time."""
    way = np.sign(np.diff(level)[starts])
    return np.split(starts, np.flatnonzero((np.diff(starts) >= HELD) | (way[1:] != way[:-1])) + 1)


def _rise(experiment: Experiment, level: Array, began: int, start: int) -> tuple[float, float]:
    """Lead and spread of a step, see `Step`, that is under way from one sample to another."""
    taken = np.abs(np.diff(level)[began : start + 1])
    time = np.array(experiment.time[began : start + 1])
    within = experiment.sample_time * (experiment.input_between != "held") * (np.arange(began, start + 1) > 0)
    middle = time - within / 2
    center = float(np.average(middle, weights=taken))
    spread = math.sqrt(float(np.average((middle - center) ** 2 + within**2 / 12, weights=taken)))
    return float(time[-1]) - center, spread


def _starts(level: Array) -> Index:
    """Samples at which an input steps, of its level before the first and then at each, shape (n + 1,)."""
    span = float(np.ptp(level))
    starts = np.flatnonzero(np.abs(np.diff(level)) > STEP * span)
    bounds = level_bounds(level[1:]) if starts.size > most_steps(level.size - 1) else None
    if bounds is None:
        return starts
    begins = abs(float(level[1 : 1 + bounds[1]].mean()) - level[0]) > STEP * span
    clear = bounds[0 if begins else 1 : -1]  # of an input that was measured: the rest is its noise
    return clear if clear.size else starts  # one level alone may be a drive at random
