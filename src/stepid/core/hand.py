"""What a hand does to a cart at the start of a record: until when it holds it, or may hold it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.noise import reading_step, record_noise
from stepid.core.once import once
from stepid.core.outliers import without_outliers

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

_FEW = 8  # samples, the last of a record
_FAR = 0.85  # of the farthest point: the first as far is where the hand held the cart, or pushed it to
_HIGH = 0.6  # of the swing that follows: above it the cart is near its farthest point
_DAMPED = 0.3  # of the farthest point, what at least is taken for the swing that follows
_WIDTH = 0.4  # of the time from there to rest, a tenth of a period, over which speed is measured
_SURE = 0.25  # of the fastest fall: a free cart is as fast once it has left its farthest point by 3 % of the swing
_TERMS = 5  # of a damped swing over a part of its period
_SWING = 1.1  # periods, that hold both turns of a swing
_FINE = 8  # parts of a line, in which its place is told
_HALF = 0.42  # of a period, before the cart turns again
_CHANCE = 4.0  # standard deviations of χ²
_NEAR = 3e-3  # of the travel, that the terms of a swing are off by themselves
_FAINT = 0.05  # of the largest swing: less is rest
_SEEN = 3.0  # counts, likewise
_RESTING = 3  # samples in one place: a free cart stays for two at its farthest point


class Hand(NamedTuple):
    """What a hand may do at the start of a record: the first sample surely free of it, and whether it is seen there."""

    first: int
    seen: bool


def release_index(experiment: Experiment) -> int:
    """Index of the first sample at which a cart that a hand is seen to hold or move is surely free; 0 where none is.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    int
    """
    first, seen = hand(experiment)
    return first if seen else 0


@once
def hand(experiment: Experiment) -> Hand:
    """Find what a hand does at the start of a record.

    Only a record without input, of which nobody said how it starts, may begin with a hand. A free cart swings
    from its farthest point across its rest: the hand is off where that motion, followed back, has a quarter of its
    speed. Where the free swing, carried back, goes through what came before, no hand is seen. It may still have held
    the cart for some samples, until the first that is surely away from there: what is lost by leaving them out is
    little, and a swing fitted through them is another. Only a cart that surely moves at the first sample is free there.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    Hand
    """
    if not experiment.is_release or experiment.starts != "auto" or float(np.ptp(experiment.position)) <= 0:
        return Hand(0, False)
    y = without_outliers(experiment)
    time, away = experiment.time, y - _rest(y)
    steepest = _fall(away)
    if steepest is None:
        return Hand(0, False)
    begin, end, side = steepest
    width = max(1, round(_WIDTH * (end - begin)))
    speed = -side * (away[width:] - away[:-width]) / (time[width:] - time[:-width])
    slow, first = _slow(speed, max(0, begin - width), end, width)
    if slow:
        seen = first > 3 * width or _rests(experiment, first) or not _swings_through(experiment, first)
    else:  # a damped cart falls from its farthest point
        far = int(np.flatnonzero(side * away[:end] > _FAR * float(np.abs(away).max()))[-1])
        first = _slow(speed, max(0, min(begin, far) - width), end, width)[1]
        seen = _rests(experiment, first)
    if seen:
        return Hand(first, True)
    return Hand(0 if _moves(experiment, width, float(speed.max())) else min(first, _still(experiment)), False)


def _still(experiment: Experiment) -> int:
    """First sample that is surely not where the first one is: before it the cart may be held."""
    small = max(_CHANCE * np.sqrt(2.0) * record_noise(experiment), reading_step(experiment))
    return _away(without_outliers(experiment), small)


def _away(y: Array, small: float) -> int:
    """First of some readings that is farther from the first of them; their number if none is."""
    away = np.abs(y - y[0]) > small
    return int(np.argmax(away)) if away.any() else y.size


def _moves(experiment: Experiment, width: int, fastest: float) -> bool:
    """Tell whether the cart surely moves at first: by the slope of a parabola there, which the readings follow."""
    y = without_outliers(experiment)
    time, y = experiment.time - experiment.time[0], y - y[0]
    count, soon = min(max(width, _RESTING) + 1, y.size), max(width // 2, 1)
    weights = np.linalg.pinv(np.vander(time[:count], 3))[1]
    slope = float(weights @ y[:count])
    chance = _SEEN * record_noise(experiment) * float(np.linalg.norm(weights))
    follows = y[soon] * np.sign(slope) >= 0.5 * abs(slope) * time[soon]
    return bool(follows) and abs(slope) > _SURE * fastest + chance


def _slow(speed: Array, begin: int, end: int, width: int) -> tuple[bool, int]:
    """Whether a cart is slow before it falls fastest within some samples, and the first at which it surely falls."""
    fast = begin + int(np.argmax(speed[begin:end]))
    slow = np.flatnonzero(speed[:fast] < _SURE * speed[fast])
    return bool(slow.size), (int(slow[-1]) + 1 if slow.size else 0) + (width + 1) // 2


def _fall(away: Array) -> tuple[int, int, float] | None:
    """Last sample near the farthest point, first beyond rest or half way to it, and which side the cart comes from."""
    far = float(np.abs(away).max())
    top = int(np.argmax(np.abs(away) >= _FAR * far))
    side = float(np.sign(away[top]))
    fall = side * away[top:]
    across = np.flatnonzero(fall < 0)
    end = int(across[0]) if across.size else fall.size
    back = np.flatnonzero(fall[end:] > 0)
    swing = float(-fall[end : end + int(back[0]) if back.size else None].min(initial=0.0))
    high = _HIGH * max(swing, _DAMPED * far)
    if swing < _FAINT * far:  # it creeps to its rest
        high, near = _FAR * far, np.flatnonzero(fall < 0.5 * far)
        if not near.size:
            return None
        end = int(near[0])
    above = np.flatnonzero(fall[:end] > high)
    return (top + int(above[-1]), top + end, side) if above.size else None


def _carried_back(experiment: Experiment, first: int) -> tuple[Array, Array] | None:
    """How far samples before a given one are off the free swing from there on, carried back; and how it follows.

    A damped swing of about the record's period is 1, cos, sin, t·cos and t·sin over so short a time.
    """
    y = without_outliers(experiment)
    period = period_of(y[first:], _FINE)
    last = first + round(_HALF * period)
    if not _TERMS < last - first <= y.size - first:
        return None
    turn = 2 * np.pi / period * (np.arange(last) - first)
    terms = np.column_stack([np.ones(last), np.cos(turn), np.sin(turn), turn * np.cos(turn), turn * np.sin(turn)])
    back = terms[:first] @ np.linalg.pinv(terms[first:])
    return y[:first] - back @ y[first:last], back


def _swings_through(experiment: Experiment, first: int) -> bool:
    """Tell whether the free swing from a sample on, carried back, goes through the samples before it."""
    carried = _carried_back(experiment, first)
    if carried is None:
        return False
    y, (off, back) = without_outliers(experiment), carried
    noise = record_noise(experiment)
    covariance = noise**2 * (np.eye(first) + back @ back.T) + (_NEAR * float(np.ptp(y))) ** 2 * np.eye(first)
    chance = first + _CHANCE * np.sqrt(2.0 * first)
    return bool(off @ np.linalg.solve(covariance, off) <= chance)


def _rests(experiment: Experiment, first: int) -> bool:
    """Tell whether the cart rests at first, by samples that are nearer to one place than to the swing carried back."""
    carried = _carried_back(experiment, first)
    if carried is None:
        return False
    y, off = without_outliers(experiment)[:first], carried[0]
    small = max(_SEEN * record_noise(experiment), reading_step(experiment))
    still = _away(y, small)
    if still < _RESTING:
        return False
    power = float(np.mean(off[:still] ** 2))
    return power > _CHANCE * max(float(np.mean((y[:still] - y[0]) ** 2)), small**2)


def _rest(y: Array) -> float:
    """Where the cart rests: the middle of what comes after it has left its farthest point, m.

    Of a swing that goes on it is the middle of its turns: more samples lie on one side in what is no whole period.
    """
    away = np.abs(y - np.median(y[-_FEW:]))
    top = int(np.argmax(away))
    left = top + int(np.argmax(away[top:] < 0.5 * away[top]))
    after = y[left + (y.size - left) // 2 :]
    swings = after.size // math.ceil(_SWING * period_of(y[left:])) if y.size - left > _FEW else 0
    if not swings:
        return float(np.median(after))
    parts = np.array_split(after, swings)
    return float(np.median([0.5 * (part.max() + part.min()) for part in parts]))


def period_of(y: Array, parts: int = 1) -> float:
    """Samples of a period of the strongest oscillation, to so many `parts` of a line of its spectrum."""
    power = np.abs(np.fft.rfft((y - y.mean()) * np.hanning(y.size), parts * y.size))[parts:] ** 2
    order = 1.0 + np.arange(power.size) / parts
    return float(y.size / order[np.argmax(power * order)])
