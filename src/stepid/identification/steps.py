"""Where a record's input steps, and where it rests before."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array, Index
from stepid.core.experiment import Experiment
from stepid.core.input_levels import STEP, level_bounds, most_steps
from stepid.errors import NoStepError

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
    rest : int
        First sample of the rest before it.
    lead : float
        s from the step to its first sample: half of one where the input is not held. The response to a ramp is the
        mean of those to steps along it, to second order that to a step in its middle.
    """

    start: int
    stop: int
    size: float
    number: int
    total: int
    rest: int
    lead: float = 0.0

    @property
    def before(self) -> slice:
        """Samples at rest before it, its first one as well where the input has not moved until then."""
        return slice(self.rest, self.start + (self.lead == 0))


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
    bounds = [int(start) for start in starts] + [experiment.input.size - 1]
    ramps = experiment.input_between != "held"  # to the next step's first sample it is under way already
    return tuple(
        Step(
            start=start,
            stop=stop - (ramps and i + 1 < len(starts)),
            # the levels before and after, not the single change: each may carry noise
            size=float(
                np.median(experiment.input[start : max(stop, start + 1)])
                - np.median(level[bounds[i - 1] + 1 if i else 0 : start + 1])
            ),
            number=i + 1,
            total=len(starts),
            rest=max(bounds[i - 1] if i else 0, start - _REST),
            lead=0.5 * experiment.sample_time if ramps and start > 0 else 0.0,
        )
        for i, (start, stop) in enumerate(pairwise(bounds))
    )


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
