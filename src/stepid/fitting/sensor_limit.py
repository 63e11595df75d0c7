"""Readings at the sensor's limit: the cart goes on beyond it. They are bounds of its position, and no values."""

from __future__ import annotations

import math

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.noise import reading_step, record_noise
from stepid.core.outliers import SIDE, Mask

_LONG = 6  # samples in a row at the limit
_PEAK = 0.2  # of these samples: within one count more, the least that a peak stays there
_STEADY = 0.5  # speed back over speed out, or the reverse: from a stop a cart comes slower, or sets out from rest
_UNSEEN = 8.0  # times noise and rounding, that the cart goes beyond the limit by its speeds on either side


def at_limit(run: Experiment) -> Mask:
    """Tell the samples whose reading is the sensor's limit, shape (n,).

    There readings are the same to the last digit. Beyond the limit the cart turns unseen, and comes back about as fast
    as it went. From a stop it would come slower; a stop that gives way as far as these speeds say would show.
    """
    y, step = run.position, reading_step(run)
    noise = math.hypot(record_noise(run), step)
    out = np.zeros(y.size, dtype=bool)
    for extreme in (y.max(), y.min()):
        at = y == extreme
        if any(_goes_beyond(y, first, end, step, noise) for first, end in stretches(at)):
            out |= at
    return out


def stretches(marked: Mask) -> list[tuple[int, int]]:
    """First and end of each stretch of samples that are marked."""
    edges = np.flatnonzero(np.diff(marked.astype(int), prepend=0, append=0)).reshape(-1, 2)
    return [(int(first), int(end)) for first, end in edges]


def is_cut_off(y: Array, first: int, end: int, step: float) -> bool:
    """Tell whether a record is at its extreme for longer than a peak is within a count.

    Of a parabola that a count cuts off, two counts cut off 1.4 times as much.
    """
    near = np.abs(y - y[first]) < 1.5 * step
    before, after = int(np.argmin(near[:first][::-1])), int(np.argmin(near[end:]))
    return before + after < _PEAK * (end - first)


def _goes_beyond(y: Array, first: int, end: int, step: float, noise: float) -> bool:
    speeds = _speeds(y, first, end) if end - first >= _LONG else None
    if speeds is None or not is_cut_off(y, first, end, step):
        return False
    out, back = speeds
    slow, fast = sorted((abs(out), abs(back)))
    unseen = abs(out - back) * (end - first) / 8  # height of a parabola
    return out * back < 0 and slow > _STEADY * fast and unseen > _UNSEEN * noise


def _speeds(y: Array, first: int, end: int) -> tuple[float, float] | None:
    """Change a sample just before a stretch and just after it; None at a record's ends."""
    if first < SIDE or end > y.size - SIDE:
        return None
    before, after = np.diff(y[first - SIDE : first]), np.diff(y[end : end + SIDE])
    return float(before.mean()), float(after.mean())


def beyond(y: Array, limit: Mask) -> Array:
    """Readings with those at the limit where the cart may have been: a cubic on from either side of a stretch."""
    out = y.copy()
    for first, end in stretches(limit):
        if (speeds := _speeds(y, first, end)) is not None:
            n = end - first + 1
            t = np.arange(1, n) / n
            start, stop, before, after = y[first - 1], y[end], n * speeds[0], n * speeds[1]
            out[first:end] = start * (1 + 2 * t) * (1 - t) ** 2 + before * t * (1 - t) ** 2
            out[first:end] += stop * t**2 * (3 - 2 * t) + after * t**2 * (t - 1)
    return out
