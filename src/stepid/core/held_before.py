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
from stepid.core.words import capitalized, runs_named

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
    return _under(run, _input_before(run).level)


def all_held_before(runs: Sequence[Experiment]) -> tuple[list[Experiment], list[str]]:
    """Return runs as `held_before` does, and say of which that is another input than they say."""
    before = [_input_before(run) for run in runs]
    told = dict[tuple[str, bool], list[str]]()
    for run, (level, sure) in zip(runs, before, strict=True):
        if level != run.input_before:
            told.setdefault((f"{level:.3g} V", sure), []).append(run.name)
    held = [_under(run, found.level) for run, found in zip(runs, before, strict=True)]
    return held, [_said(level, names, sure) for (level, sure), names in told.items()]


def _under(run: Experiment, before: float) -> Experiment:
    """A run that rested under an input, V; itself where it says so."""
    return run if before == run.input_before else run.model_copy(update={"input_before": before})


def _said(level: str, names: list[str], sure: bool) -> str:
    begin, inputs = ("begin", "their inputs") if len(names) > 1 else ("begins", "its input")
    said = f"{capitalized(runs_named(names))} {begin} at rest under {level}: {inputs} had that level before the record."
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
    quiet = span_at_rest(run)
    if float(np.ptp(run.position)) <= 2 * quiet or float(np.ptp(lead)) > quiet:
        return said
    return _by_places(run, _places(run, bounds), lead, first, final)


def _by_places(run: Experiment, places: Sequence[_Place | None], lead: Array, first: float, final: float) -> _Before:
    """The input before a run that rests under its first level, V, by where it comes to rest under later ones."""
    said, held, small = run.input_before, float(np.mean(lead)), STEP * _range(run)
    if abs(final - said) <= small:
        elsewhere = places[-1] is not None and abs(places[-1].position - held) > _AWAY * float(np.ptp(run.position))
        return _Before(first if elsewhere else said, True)
    if not _rests_beside(run, lead, first - said):
        return _Before(said, True)
    near = _nearer([place for place in places if place is not None], first, said, held, small)
    if near is None:
        return _Before(first, abs(first) >= abs(final))
    return _Before(first if near else said, True)


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


def _nearer(places: Sequence[_Place], one: float, other: float, held: float, small: float) -> bool | None:
    """Tell whether a cart is held far nearer to where one level would hold it than to where another would.

    By the line through the places of other levels; None where these do not differ by more than is `small`, V.
    """
    levels, positions = np.array(places).reshape(-1, 2).T
    if levels.size < 2 or float(np.ptp(levels)) <= small:
        return None
    line = np.polyfit(levels, positions, 1)
    off = [abs(float(np.polyval(line, level)) - held) for level in (one, other)]
    return off[0] < _NEARER * off[1]


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
