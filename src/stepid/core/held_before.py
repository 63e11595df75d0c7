"""The input that a plant rested under before its record: a first level that moves nothing was held before, too."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stepid.core.experiment import Experiment
from stepid.core.hand import period_of
from stepid.core.noise import span_at_rest

_AWAY, _RESTS = 0.4, 0.1  # of the travel, from which on the cart is elsewhere; that it spans where it comes to rest
_FEWEST = 4  # samples at the end


def held_before(run: Experiment) -> Experiment:
    """Return a run with the input that it rested under before its first sample: what it says, or its first level.

    A plant rests in one place under one input. Where a run is at rest as long as its first level is held, and ends
    elsewhere under what it is said to have rested under, it did not begin there. An amplifier that was off does not do
    that: its cart rests where no input holds it.

    Parameters
    ----------
    run : Experiment

    Returns
    -------
    Experiment
        The run itself where it is as it says.
    """
    before = _input_before(run)
    return run if before == run.input_before else run.model_copy(update={"input_before": before})


def all_held_before(runs: Sequence[Experiment]) -> tuple[list[Experiment], list[str]]:
    """Return runs as `held_before` does, and say of which that is another input than they say."""
    held = [held_before(run) for run in runs]
    return held, [
        f"Run {run.name!r} begins at rest under {run.input_before:g} V: its input had that level before the record."
        for run, told in zip(held, runs, strict=True)
        if run is not told
    ]


def _input_before(run: Experiment) -> float:
    first, y = float(run.input[0]), run.position
    changes = np.flatnonzero(np.diff(run.input)) + 1
    if first == run.input_before or run.starts == "motion" or not changes.size or run.input[-1] != run.input_before:
        return run.input_before
    lead, last, travel = y[: changes[0]], y[changes[-1] :], float(np.ptp(y))
    quiet = span_at_rest(run)
    if travel <= 2 * quiet or float(np.ptp(lead)) > quiet:
        return run.input_before
    period = round(period_of(y))
    end = last[-period:] if period <= last.size else last[-(last.size // 3) :]  # where it rings: its mean
    if end.size < _FEWEST or (period > last.size and float(np.ptp(end)) > _RESTS * travel):
        return run.input_before
    return first if abs(float(np.mean(end) - np.mean(lead))) > _AWAY * travel else run.input_before
