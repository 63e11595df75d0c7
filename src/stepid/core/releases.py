"""Where a hand lets the cart go: the part of a record before it, and records that hold several releases."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.noise import record_noise
from stepid.core.once import once
from stepid.core.quantities import in_own_quantities
from stepid.core.takes import described
from stepid.errors import InputError

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

_FEW = 8  # samples, the last of a record
_TAIL = 1.5  # periods near rest, after which a cart has come to it; or
_MUCH = 0.25  # of the record
_TIMES = 4  # that a middle of swings is found anew
_BIG = 0.3  # of the farthest point, which a cart that comes to rest stays below
_FAR = 0.85  # of the farthest point: the first as far is where the hand held the cart, or pushed it to
_HIGH = 0.6  # of the swing that follows: above it the cart is near its farthest point
_DAMPED = 0.3  # of the farthest point, what at least is taken for the swing that follows
_WIDTH = 0.4  # of the time from there to rest, a tenth of a period, over which speed is measured
_SURE = 0.25  # of the fastest fall: a free cart is as fast once it has left its farthest point by 3 % of the swing
_TERMS = 5  # of a damped swing over a part of its period
_HALF = 0.42  # of a period, before the cart turns again
_CHANCE = 4.0  # standard deviations of χ²
_NEAR = 3e-3  # of the travel, that the terms of a swing are off by themselves
_AGAIN = 1.5  # times the turn before, or what is rest: no free swing grows so
_FAINT = 0.05  # of the largest swing: less is rest
_STILL = 0.2  # of what is rest: less is no motion of the hand
_NOTABLE = 0.2  # of the largest swing, below which a growing one is noise or a touch
_QUIET = 8.0  # standard deviations of the noise that no swing stands out from
_SEEN = 3.0  # counts, likewise
_FEWEST = 24  # samples of a release
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
    time, away = experiment.time, experiment.position - _rest(experiment.position)
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
    y = experiment.position
    away = np.abs(y - y[0]) > max(_CHANCE * np.sqrt(2.0) * record_noise(experiment), experiment.resolution or 0.0)
    return int(np.argmax(away)) if away.any() else y.size


def _moves(experiment: Experiment, width: int, fastest: float) -> bool:
    """Tell whether the cart surely moves at first: by the slope of a parabola there, which the readings follow."""
    time, y = experiment.time - experiment.time[0], experiment.position - experiment.position[0]
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
    return top + int(np.flatnonzero(fall[:end] > high)[-1]), top + end, side


def _carried_back(experiment: Experiment, first: int) -> tuple[Array, Array] | None:
    """How far samples before a given one are off the free swing from there on, carried back; and how it follows.

    A damped swing of about the record's period is 1, cos, sin, t·cos and t·sin over so short a time.
    """
    y = experiment.position
    period = _period(y[first:])
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
    y, (off, back) = experiment.position, carried
    noise = record_noise(experiment)
    covariance = noise**2 * (np.eye(first) + back @ back.T) + (_NEAR * float(np.ptp(y))) ** 2 * np.eye(first)
    chance = first + _CHANCE * np.sqrt(2.0 * first)
    return bool(off @ np.linalg.solve(covariance, off) <= chance)


def _rests(experiment: Experiment, first: int) -> bool:
    """Tell whether the cart rests at first, by samples that are nearer to one place than to the swing carried back."""
    carried = _carried_back(experiment, first)
    if carried is None:
        return False
    y, off = experiment.position[:first], carried[0]
    noise = record_noise(experiment)
    small = max(_SEEN * noise, experiment.resolution or 0.0)
    away = np.abs(y - y[0]) > small
    still = int(np.argmax(away)) if away.any() else y.size
    if still < _RESTING:
        return False
    power = float(np.mean(off[:still] ** 2))
    return power > _CHANCE * max(float(np.mean((y[:still] - y[0]) ** 2)), small**2)


@in_own_quantities
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
    if not hasattr(experiment, "is_release"):
        raise InputError(f"an Experiment is needed, not {described(experiment)}", "Give one run: campaign[name].")
    if not experiment.is_release or experiment.starts == "rest":
        return (experiment,)
    hands = _hands(experiment)
    begins, ends = [0, *(after for _, after in hands)], [*(before for before, _ in hands), experiment.time.size]
    parts = [(a, b) for a, b in zip(begins, ends, strict=True) if b - a >= _FEWEST]
    if len(parts) < 2:
        return (experiment,)
    first, *later = (experiment.slice(a, b, name=f"{experiment.name} ({i})") for i, (a, b) in enumerate(parts, 1))
    return first, *(part.model_copy(update={"starts": "auto"}) for part in later)  # these begin with the hand


class _Lobe(NamedTuple):
    """A stay on one side of rest: first sample, last (not included), farthest point [m], which side."""

    first: int
    last: int
    size: float
    side: float


def _hands(experiment: Experiment) -> list[tuple[int, int]]:
    """Last free sample before each time that a hand takes a cart that was let go, and first of what follows."""
    y = experiment.position
    away = y - _rest_between(y)
    noise = record_noise(experiment)
    largest = float(np.abs(away).max())
    quiet = max(_QUIET * noise, _SEEN * (experiment.resolution or 0.0), _FAINT * largest)
    lobes, half = _lobes(away, quiet)
    out: list[tuple[int, int]] = []
    swings = 0  # lobes since the last hand
    range_before = np.inf  # of the turn before, from one farthest point to the next: whatever the rest, it only shrinks
    for before, lobe in pairwise(lobes):
        rested = lobe.first - before.last > half
        turn = before.size + lobe.size if lobe.side != before.side else lobe.size
        grown = lobe.size > _AGAIN * quiet if rested else turn > _AGAIN * range_before
        if lobe.size > _NOTABLE * largest and swings + rested > 1 and grown:
            still = max(before.last, _moved(away, before, lobe, quiet) - round(half)) if rested else lobe.first
            out.append((still if rested else before.first, still))  # a hand that catches the cart shapes a swing
            swings, range_before = 0, np.inf
        else:
            swings += lobe.side != before.side or rested
            range_before = turn
    return out


def _moved(away: Array, before: _Lobe, lobe: _Lobe, quiet: float) -> int:
    """Last sample of a cart at rest before a hand moves it."""
    between = away[before.last : lobe.first]
    still = np.flatnonzero(np.abs(between - np.median(between)) < _STILL * quiet)
    return before.last + int(still[-1])


def _lobes(away: Array, quiet: float) -> tuple[list[_Lobe], float]:
    """Stays on one side of rest, farther than `quiet`, one after another; and the samples of half a swing."""
    at = np.flatnonzero(np.abs(away) > quiet)
    sides = np.sign(away[at])
    turns = at[1:][np.diff(sides) != 0]
    if turns.size < 2:
        return [], 0.0
    half = float(np.quantile(np.diff(turns), 0.25))
    ends = np.flatnonzero((np.diff(sides) != 0) | (np.diff(at) > half)) + 1
    parts = [(int(part[0]), int(part[-1]) + 1) for part in np.split(at, ends)]
    return [_Lobe(a, b, float(np.abs(away[a:b]).max()), float(np.sign(away[a]))) for a, b in parts], half


def _rest(y: Array) -> float:
    """Where the cart rests: the middle of what comes after it has left its farthest point, m."""
    away = np.abs(y - np.median(y[-_FEW:]))
    top = int(np.argmax(away))
    left = top + int(np.argmax(away[top:] < 0.5 * away[top]))
    return float(np.median(y[left + (y.size - left) // 2 :]))


def _rest_between(y: Array) -> float:
    """Where the cart rests, m, whatever a hand does between: where it ends, or the middle of its swings."""
    away = np.abs(y - np.median(y[-_FEW:]))
    tail = y[int(np.flatnonzero(away >= _BIG * away.max())[-1]) + 1 :]
    period = _period(y)
    if tail.size > max(_FEW, min(_TAIL * period, _MUCH * y.size)):
        return float(np.median(tail[tail.size // 2 :]))
    width = max(1, round(period / 24))
    order = np.argsort(middle := 0.5 * (y[width:] + y[:-width]))
    passed = np.cumsum(((y[width:] - y[:-width]) ** 2)[order])  # little of it where a hand holds
    rest = float(middle[order][int(np.searchsorted(passed, 0.5 * passed[-1]))])
    for _ in range(_TIMES):
        lobes, _half = _lobes(y - rest, _FAINT * float(np.ptp(y)))
        top = np.array([lobe.side * lobe.size for lobe in lobes])
        if top.size < 4:
            break
        rest += float(np.median(0.25 * top[:-2] + 0.5 * top[1:-1] + 0.25 * top[2:]))
    return rest


def _period(y: Array) -> float:
    """Samples of a period of the strongest oscillation."""
    power = np.abs(np.fft.rfft((y - y.mean()) * np.hanning(y.size)))[1:] ** 2
    order = np.arange(1, power.size + 1)
    return float(y.size / order[np.argmax(power * order)])
