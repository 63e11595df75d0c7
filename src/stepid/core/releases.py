"""Where a hand lets the cart go: the part of a record before it, and records that hold several releases."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from stepid.core.base import Array
from stepid.core.noise import noise_level

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

_FEW = 8  # samples, the last of a record
_FAR = 0.85  # of the farthest point: the first as far is where the hand held the cart, or pushed it to
_HIGH = 0.6  # of the swing that follows: above it the cart is near its farthest point
_DAMPED = 0.3  # of the farthest point, what at least is taken for the swing that follows
_PART = 0.1  # of a period that a free cart takes from there to its rest
_WIDTH = 0.4  # of that time, over which speed is measured: a part of a period of 1/24
_SURE = 0.25  # of the fastest fall: a free cart is as fast once it has left its farthest point by 3 % of the swing
_TERMS = 5  # of a damped swing over a part of its period
_HALF = 0.42  # of a period, before the cart turns again
_CHANCE = 4.0  # standard deviations of χ²
_NEAR = 1e-3  # of the travel, that the terms of a swing are off by themselves
_AGAIN = 1.5  # times the least swing before: no free swing grows so
_NOTABLE = 0.2  # of the largest swing, below which a growing one is noise or a touch
_QUIET = 8.0  # standard deviations of the noise that no swing stands out from
_SEEN = 3.0  # counts, likewise
_FEWEST = 24  # samples of a release


def release_index(experiment: Experiment) -> int:
    """Index of the first sample at which a cart that a hand pulled, held or pushed is surely free; 0 where none did.

    Only a record without input, of which nobody said how it starts, may begin with a hand. A free cart swings
    from its farthest point across its rest: the hand is off where that motion, followed back, has a quarter of its
    speed. Where the free swing, carried back, goes through what came before, no hand held the cart.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    int
    """
    if not experiment.is_release or experiment.starts != "auto" or float(np.ptp(experiment.position)) <= 0:
        return 0
    time, away = experiment.time, experiment.position - _rest(experiment.position)
    steepest = _fall(away)
    if steepest is None:
        return 0
    begin, end, side = steepest
    width = max(1, round(_WIDTH * (end - begin)))
    speed = -side * (away[width:] - away[:-width]) / (time[width:] - time[:-width])
    near = slice(max(0, begin - width), end)
    fast = near.start + int(np.argmax(speed[near]))
    slow = np.flatnonzero(speed[:fast] < _SURE * speed[fast])
    if not slow.size:
        return 0
    first = int(slow[-1]) + 1 + (width + 1) // 2
    return 0 if first <= 3 * width and _swings_through(experiment, first, (end - begin) / _PART) else first


def _fall(away: Array) -> tuple[int, int, float]| None:
    """Last sample near the farthest point, first on the other side of rest, and which side the cart comes from."""
    top = int(np.argmax(np.abs(away) >= _FAR * np.abs(away).max()))
    side = float(np.sign(away[top]))
    across = np.flatnonzero(side * away[top:] < 0)
    if not across.size:
        return None
    end = top + int(across[0])
    back = np.flatnonzero(side * away[end:] > 0)
    swing = -side * away[end : end + int(back[0]) if back.size else None]
    high = _HIGH * max(float(swing.max()), _DAMPED * abs(float(away[top])))
    return top + int(np.flatnonzero(side * away[top:end] > high)[-1]), end, side


def _swings_through(experiment: Experiment, first: int, period: float) -> bool:
    """Tell whether the free swing from a sample on, carried back, goes through the samples before it.

    A damped swing of about that period [samples] is 1, cos, sin, t·cos and t·sin over so short a time.
    """
    y = experiment.position
    last = first + round(_HALF * period)
    if not 2 * _TERMS <= last - first <= y.size - first:
        return False
    turn = 2 * np.pi / period * (np.arange(last) - first)
    terms = np.column_stack([np.ones(last), np.cos(turn), np.sin(turn), turn * np.cos(turn), turn * np.sin(turn)])
    inverse = np.linalg.pinv(terms[first:])
    off = y[:first] - terms[:first] @ inverse @ y[first:last]
    noise = noise_level(y, resolution=experiment.resolution)
    back = terms[:first] @ inverse
    covariance = noise**2 * (np.eye(first) + back @ back.T) + (_NEAR * float(np.ptp(y))) ** 2 * np.eye(first)
    chance = first + _CHANCE * np.sqrt(2.0 * first)
    return bool(off @ np.linalg.solve(covariance, off) <= chance)


def split_releases(experiment: Experiment) -> tuple[Experiment, ...]:
    """Split a record that holds several releases, or pushes, by hand into one record each.

    A free swing only dies away. Where it grows again, a hand has moved the cart: the record ends there, and the next
    begins. What the hand did first in each of them is left out by `fit` and `diagnose`.

    Parameters
    ----------
    experiment : Experiment
        A record with an input is returned whole: a fit follows all of its steps.

    Returns
    -------
    tuple of Experiment
        In order of time on the record's clock, called "name (1)", "name (2)", …; the record itself where it holds one
        release.
    """
    if not experiment.is_release or experiment.starts == "rest":
        return (experiment,)
    cuts = _hands(experiment)
    bounds = [0, *cuts, experiment.time.size]
    parts = [(a, b) for a, b in pairwise(bounds) if b - a >= _FEWEST]
    if len(parts) < 2:
        return (experiment,)
    return tuple(
        experiment.slice(a, b, name=f"{experiment.name} ({i})") if a else _first(experiment, b)
        for i, (a, b) in enumerate(parts, 1)
    )


def _first(experiment: Experiment, last: int) -> Experiment:
    return experiment.slice(0, last, name=f"{experiment.name} (1)")


def _hands(experiment: Experiment) -> list[int]:
    """Samples at which a hand takes a cart that was let go before."""
    y = experiment.position
    away = y - _rest(y)
    noise = noise_level(y, resolution=experiment.resolution)
    quiet = max(_QUIET * noise, _SEEN * (experiment.resolution or 0.0), _NOTABLE / 4 * float(np.abs(away).max()))
    half = max(2, round(_period(y) / 2))
    lobes = _lobes(away, quiet)
    largest = max((float(np.abs(away[a:b]).max()) for a, b in lobes), default=0.0)
    out: list[int] = []
    least, free = np.inf, release_index(experiment)
    for before, (a, b) in pairwise([(0, 0), *lobes]):
        size = float(np.abs(away[a:b]).max())
        rested = a - before[1] > half  # the swing had died away
        if before[1] > free and rested:
            least = min(least, quiet)
        if b > free and size > max(_AGAIN * least, _NOTABLE * largest) and least < np.inf:
            out.append(max(before[1], a - half) if rested else before[0])
            least, free = np.inf, out[-1] + _released(experiment, out[-1])
        if b > free:
            least = min(least, size)
    return out


def _released(experiment: Experiment, first: int) -> int:
    if experiment.time.size - first < _FEWEST:
        return 0
    return release_index(experiment.slice(first, None))


def _lobes(away: Array, quiet: float) -> list[tuple[int, int]]:
    """First and last sample (not included) of each stay on one side of rest, beyond what is quiet."""
    side = np.where(away > quiet, 1, np.where(away < -quiet, -1, 0))
    at = np.flatnonzero(side)
    if not at.size:
        return []
    ends = np.flatnonzero(np.diff(side[at])) + 1
    return [(int(part[0]), int(part[-1]) + 1) for part in np.split(at, ends)]


def _rest(y: Array) -> float:
    """Where the cart rests: the middle of what comes after it has left its farthest point, m."""
    away = np.abs(y - np.median(y[-_FEW:]))
    top = int(np.argmax(away))
    left = top + int(np.argmax(away[top:] < 0.5 * away[top]))
    return float(np.median(y[left + (y.size - left) // 2 :]))


def _period(y: Array) -> float:
    """Samples of a period of the strongest oscillation."""
    power = np.abs(np.fft.rfft((y - y.mean()) * np.hanning(y.size)))[1:] ** 2
    order = np.arange(1, power.size + 1)
    return float(y.size / order[np.argmax(power * order)])
