"""Readings at the end of a sensor's range: it was clipped, and what the cart did beyond is not known."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.input_levels import changes_by
from stepid.core.noise import noise_level, reading_step
from stepid.core.outliers import Mask
from stepid.core.words import counted, length
from stepid.fitting.record_fault import RecordFault

_SWINGS = 2  # of which one alone may be chance
_SURE = 2.0  # times the fall beside a smooth peak
_CLEAR = 5.0  # times the noise, within which readings are alike
_AFTER = 2  # samples later: the next one may have left the end of the range just now
_LEAST = 3  # samples of a swing: two beside each other may be a peak


def clipped(run: Experiment) -> Mask:
    """Find samples that stay at the largest or the smallest reading of a record, in two swings or more of both.

    A smooth peak that is within q of its top for L samples has fallen by q((L + 4)/L)² at most two samples later. What
    falls by twice that on both sides was cut off. q is a step of the reading, or what noise does. A sensor that is
    slower than its clock repeats readings as well, but most of them elsewhere.

    Parameters
    ----------
    run : Experiment

    Returns
    -------
    array of bool, shape (n,)
    """
    y = run.position
    near = max(reading_step(run), _CLEAR * noise_level(y, resolution=run.resolution))
    out, swings = np.zeros(y.size, dtype=bool), 0
    for side in (y, -y):
        top = side >= side.max() - near
        seen = sum(_falls(side, one, near) and not changes_by(run, *one) for one in _stretches(top))
        swings += seen
        out |= top & (seen > 0)
    sure = swings >= _SWINGS and _repeats(y, out) > _repeats(y, ~out)
    return out if sure else np.zeros(y.size, dtype=bool)


def _stretches(where: Mask) -> list[tuple[int, int]]:
    """Begin and end of the stretches of some samples that do not reach an end of the record."""
    edges = np.flatnonzero(np.diff(where)) + 1
    edges = edges[int(where[0]) :]
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=False)]


def _falls(side: Array, stretch: tuple[int, int], near: float) -> bool:
    """Tell whether readings fall on both sides of a stretch as no smooth peak does."""
    begin, end = stretch
    count = end - begin
    top = float(side[begin:end].max())
    fall = top - max(float(side[max(begin - _AFTER, 0)]), float(side[min(end + _AFTER, side.size) - 1]))
    return count >= _LEAST and fall > _SURE * near * ((count + 2 * _AFTER) / count) ** 2


def _repeats(y: Array, where: Mask) -> float:
    """Share of some samples that repeat the one before; 0 without any."""
    again = np.diff(y, prepend=np.nan) == 0
    return float(again[where].mean()) if where.any() else 0.0


def clipped_fault(run: Experiment, at: Mask) -> RecordFault:
    """Say of a record which readings are at the end of its sensor's range; the fault's size is how long, s."""
    farthest = float(np.abs(run.position[at]).max())
    words = (
        f"Run {run.name!r} stays at {length(farthest)}, its farthest reading, in several swings, "
        f"{counted(int(at.sum()), 'sample')} in all: the sensor was clipped. These samples are left out."
    )
    return RecordFault(run=run.name, kind="clipped", size=float(at.sum() * run.sample_time), unit="s", words=words)
