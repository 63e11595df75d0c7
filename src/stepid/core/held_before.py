"""The input that a plant rested under before its record: a first level that moves nothing was held before, too."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.hand import period_of
from stepid.core.input_levels import STEP, step_bounds
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
    y, bounds = run.position, step_bounds(run.input)  # levels that are measured have noise
    first, final = (_level(run.input[a:b]) for a, b in (bounds[:2], bounds[-2:]))
    small = STEP * _range(run)
    begins, ends = abs(first - run.input_before) > small, abs(final - run.input_before) > small
    if bounds.size == 2 or first == run.input_before or run.starts == "motion":
        return run.input_before
    lead, last, travel = y[: bounds[1]], y[bounds[-2] :], float(np.ptp(y))
    if not begins:  # the level of a noisy one is taken from its readings: see `stepid.core.input_levels.levelled`
        exact = float(np.ptp(run.input[: bounds[1]])) == 0.0
        return first if exact and _rests_beside(run, lead, first - run.input_before) else run.input_before
    if ends:
        return run.input_before
    quiet = span_at_rest(run)
    if travel <= 2 * quiet or float(np.ptp(lead)) > quiet:
        return run.input_before
    period = round(period_of(y))
    end = last[-period:] if period <= last.size else last[-(last.size // 3) :]  # where it rings: its mean
    if end.size < _FEWEST or (period > last.size and float(np.ptp(end)) > _RESTS * travel):
        return run.input_before
    return first if abs(float(np.mean(end) - np.mean(lead))) > _AWAY * travel else run.input_before


def _range(run: Experiment) -> float:
    return float(max(run.input.max(), run.input_before) - min(run.input.min(), run.input_before))


def _level(volts: Array) -> float:
    return float(volts[0]) if np.ptp(volts) == 0 else float(np.mean(volts))


def _rests_beside(run: Experiment, lead: Array, volts: float) -> bool:
    """Tell whether a cart rests although its input lies a little beside what it is said to have been: no step made it.

    A step of so many `volts` would have moved it in that time, by a part of what the whole input did.
    """
    y, quiet, whole = run.position, span_at_rest(run), _range(run)
    swing = 1.0 - math.cos(min(2 * math.pi * lead.size / period_of(y), math.pi))
    moves = abs(volts) / whole * float(np.ptp(y)) / 2 * swing if whole > 0 else 0.0
    return moves > quiet >= float(np.ptp(lead))
