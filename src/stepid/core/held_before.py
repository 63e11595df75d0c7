"""The input that a plant rested under before its record: a first level that moves nothing was held before, too."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array, Index
from stepid.core.experiment import Experiment
from stepid.core.hand import period_of
from stepid.core.input_levels import STEP, step_bounds
from stepid.core.noise import span_at_rest
from stepid.core.words import listed

_AWAY, _RESTS = 0.4, 0.1  # of the travel, from which on the cart is elsewhere; that it spans where it comes to rest
_FEWEST = 4  # samples at the end
_NEARER = 0.1  # times as far from where one level would hold it as from where another would: it is held by the one


def held_before(run: Experiment) -> Experiment:
    """Return a run with the input that it rested under before its first sample: what it says, or its first level.

    A plant rests in one place under one input. Where a run is at rest as long as its first level is held, and ends
    elsewhere under what it is said to have rested under, it did not begin there. An amplifier that was off does not do
    that: its cart rests where no input holds it. Where a run does not come back to what it is said to have rested
    under, its first level was held before if it would have moved the cart, and if that rests where later levels, if
    there are two, say that it does under that level.

    Parameters
    ----------
    run : Experiment

    Returns
    -------
    Experiment
        The run itself where it is as it says.
    """
    before = _input_before(run).level
    return run if before == run.input_before else run.model_copy(update={"input_before": before})


def all_held_before(runs: Sequence[Experiment]) -> tuple[list[Experiment], list[str]]:
    """Return runs as `held_before` does, and say of which that is another input than they say."""
    held, told = [held_before(run) for run in runs], dict[tuple[str, bool], list[str]]()
    for run, own in zip(held, runs, strict=True):
        if run is not own:
            level, sure = _input_before(own)
            told.setdefault((f"{level:.3g} V", sure), []).append(repr(run.name))
    return held, [_said(level, names, sure) for (level, sure), names in told.items()]


def _said(level: str, names: list[str], sure: bool) -> str:
    many = len(names) > 1
    who = f"Run{'s' * many} {listed(names, 'and')} {'begin' if many else 'begins'} at rest under {level}"
    said = f"{who}: {'their inputs' if many else 'its input'} had that level before the record."
    if sure:
        return said
    return f"{said} A cart that friction holds under it looks alike: samples from before that level would tell."


class _Before(NamedTuple):
    """Level of the input before a record, V, and whether the record tells it."""

    level: float
    sure: bool


def _input_before(run: Experiment) -> _Before:
    bounds = step_bounds(run.input)  # levels that are measured have noise
    first, final = (_level(run.input[a:b]) for a, b in (bounds[:2], bounds[-2:]))
    small, said = STEP * _range(run), _Before(run.input_before, True)
    if bounds.size == 2 or first == said.level or run.starts == "motion":
        return said
    lead, changed = run.position[: bounds[1] + 1], first - said.level  # to where the next level sets in
    if abs(changed) <= small:  # that of a noisy one is taken from its readings: see `input_levels.levelled`
        exact = float(np.ptp(run.input[: bounds[1]])) == 0.0
        return _Before(first, True) if exact and _rests_beside(run, lead, changed) else said
    quiet, travel = span_at_rest(run), float(np.ptp(run.position))
    if travel <= 2 * quiet or float(np.ptp(lead)) > quiet:
        return said
    held, places = float(np.mean(lead)), _places(run, bounds)
    if abs(final - said.level) <= small:
        elsewhere = places[-1] is not None and abs(places[-1].position - held) > _AWAY * travel
        return _Before(first, True) if elsewhere else said
    if not _rests_beside(run, lead, changed):
        return said
    levels, positions = np.array([place for place in places if place is not None]).reshape(-1, 2).T
    if levels.size < 2 or float(np.ptp(levels)) <= small:
        return _Before(first, abs(first) >= abs(final))
    line = np.polyfit(levels, positions, 1)
    off = [abs(float(np.polyval(line, level)) - held) for level in (first, said.level)]
    return _Before(first, True) if off[0] < _NEARER * off[1] else said


class _Place(NamedTuple):
    """Level of the input, V, and where the cart comes to rest under it, or what it swings about, m."""

    level: float
    position: float


def _places(run: Experiment, bounds: Index) -> list[_Place | None]:
    """Places under the levels after the first; None where one is too short to tell."""
    period, travel = round(period_of(run.position)), float(np.ptp(run.position))
    out: list[_Place | None] = []
    for a, b in pairwise(bounds[1:]):
        part = run.position[a:b]
        end = part[-period:] if period <= part.size else part[-(part.size // 3) :]  # where it rings: its mean
        tells = end.size >= _FEWEST and (period <= part.size or float(np.ptp(end)) <= _RESTS * travel)
        out.append(_Place(_level(run.input[a:b]), float(np.mean(end))) if tells else None)
    return out


def _range(run: Experiment) -> float:
    return float(max(run.input.max(), run.input_before) - min(run.input.min(), run.input_before))


def _level(volts: Array) -> float:
    return float(volts[0]) if np.ptp(volts) == 0 else float(np.mean(volts))


def _rests_beside(run: Experiment, lead: Array, volts: float) -> bool:
    """Tell whether a cart rests although its input lies a little beside what it is said to have been: no step made it.

    A step of so many `volts` would have moved it in that time, by a part of what the whole input did.
    """
    y, quiet, whole = run.position, span_at_rest(run), _range(run)
    swing = 1.0 - math.cos(min(2 * math.pi * (lead.size - 1) / period_of(y), math.pi))
    moves = abs(volts) / whole * float(np.ptp(y)) / 2 * swing if whole > 0 else 0.0
    return moves > quiet >= float(np.ptp(lead))
