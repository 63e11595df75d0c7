"""Isolated wrong readings of a record: one to three samples that no motion explains."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.core.noise import record_noise
from stepid.core.once import once

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

Mask = npt.NDArray[np.bool_]
Block = tuple[float, int, int]  # score, first sample, number of samples
Detector = Callable[[Array, float, float], list[Block]]
"""Blocks of wrong readings, m, by the noise and by what one that stands out is off by at least, both m."""
SIDE = 4  # neighbors on each side that tell what a sample should read
_DEGREE = 3  # of the polynomial through them
_OUTLIER = 9.0  # standard deviations; kinks, jumps and bounces of the motion itself stay below 3.5
LONGEST = 3  # samples of one outlier
_COUNTS = 3.0  # counts that rounding never makes
_JUMP = 10.0  # times the fastest change of a motion, that none begins with: a blow that fades at once has 3.5
_MOST = 0.05  # share of a record beyond which nothing is isolated
_PASSES = 20
_SHORTEST = 4 * SIDE  # samples of a record, below which its motion is not told from an outlier


class _Local(NamedTuple):
    """Prediction of a block of m samples from its neighbors, shape (m, 2k), their misfit, and the spread of both."""

    predict: Array
    misfit: Array
    spread: Array


def _sides(count: int, after: int) -> npt.NDArray[np.intp]:
    """Where the neighbors of a block are, counted from its begin: so many of them after it, the rest before."""
    return np.concatenate([np.arange(after - 2 * SIDE, 0), np.arange(count, count + after)])


@cache
def _local(count: int, after: int = SIDE) -> _Local:
    at = _sides(count, after) - (count - 1) / 2
    basis = np.vander(at.astype(np.float64), _DEGREE + 1)
    inverse = np.linalg.pinv(basis)
    predict = np.vander(np.arange(count) - (count - 1) / 2, _DEGREE + 1) @ inverse
    misfit = np.eye(2 * SIDE) - basis @ inverse
    return _Local(predict, misfit, np.sqrt(1.0 + np.sum(predict**2, axis=1)))


def stand_out(
    y: Array, count: int, begin: npt.NDArray[np.intp], noise: float, after: int = SIDE
) -> tuple[Array, Array]:
    """Deviation of blocks that begin at given samples from their neighbors: in standard deviations, and in m."""
    local = _local(count, after)
    near = y[begin[:, None] + _sides(count, after)]
    block = y[begin[:, None] + np.arange(count)]
    off = block - near @ local.predict.T
    freedom = 2 * SIDE - _DEGREE - 1
    spread = np.sqrt(np.sum((near @ local.misfit.T) ** 2, axis=1) / freedom)
    return np.abs(off) / local.spread / np.maximum(spread, noise)[:, None], off


def _after(size: int, begin: int, count: int) -> int:
    """How many of the neighbors of a block come after it: half of them, but near the ends of a record."""
    return max(min(SIDE, size - begin - count), 2 * SIDE - begin)


def _interpolate(y: Array, begin: int, count: int) -> None:
    after = _after(y.size, begin, count)
    y[begin : begin + count] = _local(count, after).predict @ y[begin + _sides(count, after)]


def _take(y: Array, found: list[Block], wrong: Mask) -> bool:
    """Interpolate blocks, the plainest first, none near another."""
    busy = np.zeros(y.size, dtype=bool)
    for _, begin, count in sorted(found, reverse=True):
        around = slice(max(begin - SIDE, 0), begin + count + SIDE)
        if busy[around].any():
            continue
        busy[around] = True
        wrong[begin : begin + count] = True
        _interpolate(y, begin, count)
    return bool(found)


def outliers(y: Array, noise: float, least: float) -> list[Block]:
    """Blocks of up to three samples whose ends stand out from their neighbors: one between two wrong ones is lost."""
    found = []
    for count in range(1, LONGEST + 1):
        begin = np.arange(SIDE, y.size - SIDE - count + 1)
        score, off = stand_out(y, count, begin, noise)
        ends, far = score[:, [0, -1]].min(axis=1), np.abs(off[:, [0, -1]]).min(axis=1)
        out = (ends > _OUTLIER) & (far > least)
        found += [(float(ends[i]), int(begin[i]), count) for i in np.flatnonzero(out)]
    return found + _near_the_ends(y, noise, least)


def _near_the_ends(y: Array, noise: float, least: float) -> list[Block]:
    """One of the first or last samples that stands out, by more than any acceleration of the record does in a sample.

    Of the first, one whose two neighbors differ by less than half of it: where a motion begins they differ by more. One
    that is over within a sample reads as an outlier. The very first have to lie off by more than any motion does.
    """
    found = _at_the_beginning(y, noise, least)
    for begin in (*range(1, SIDE), *range(y.size - SIDE, y.size)):
        score, off = stand_out(y, 1, np.array([begin]), noise, _after(y.size, begin, 1))
        first = begin < SIDE
        fastest = float(np.abs(np.diff(y[begin + 2 :] if first else y[: begin - 1], 2)).max(initial=0.0))
        beside = 2 * abs(float(y[begin + 1] - y[begin - 1])) if first else 0.0
        if score[0, 0] > _OUTLIER and abs(off[0, 0]) > max(least, fastest, beside):
            found.append((float(score[0, 0]), begin, 1))
    return found


def _at_the_beginning(y: Array, noise: float, least: float) -> list[Block]:
    """The first readings of a cart that rests, where they lie off by many times what it ever moves in a sample.

    Before a cart that moves, readings may have been lost instead.
    """
    plain = max(least, _OUTLIER * noise)
    for count in range(1, LONGEST + 1):
        off = float(np.abs(y[:count] - y[count]).min())
        rests = float(np.ptp(y[count : count + SIDE])) <= plain
        if off > plain and rests and off > _JUMP * float(np.abs(np.diff(y[count:])).max()):
            return [(off / noise, 0, count)]
    return []


def interpolate_readings(experiment: Experiment, *, detectors: Sequence[Detector]) -> tuple[Array, list[Mask]]:
    """Interpolate the wrong readings of a record, those of one detector after those of another.

    Parameters
    ----------
    experiment : Experiment
    detectors : sequence of Detector

    Returns
    -------
    readings : array, shape (n,)
        m; those of the record where none is wrong, or too many are.
    wrong : list of array of bool, shape (n,)
        Samples that are interpolated, those of each detector; none is of two.
    """
    size = experiment.position.size
    nothing = [np.zeros(size, dtype=bool) for _ in detectors]
    if size < _SHORTEST:
        return experiment.position, nothing
    y, wrong, every = np.array(experiment.position), [], np.zeros(size, dtype=bool)
    noise, least = _scales(experiment)
    for detect in detectors:
        wrong.append(_in_passes(y, detect, noise, least) & ~every)
        every |= wrong[-1]
    return (y, wrong) if isolated(every) else (experiment.position, nothing)


def _scales(experiment: Experiment) -> tuple[float, float]:
    """Noise of a record, and what a reading that stands out is off by at least, m."""
    y, resolution = experiment.position, experiment.resolution or 0.0
    noise = max(record_noise(experiment), resolution / math.sqrt(12), 1e-7 * float(np.ptp(y)), 1e-15)
    return noise, _COUNTS * resolution


def _in_passes(y: Array, detect: Detector, noise: float, least: float) -> Mask:
    """Interpolate readings where they are until a detector finds no more, and tell which they were."""
    wrong = np.zeros(y.size, dtype=bool)
    for _ in range(_PASSES):
        if not _take(y, detect(y, noise, least), wrong):
            break
    return wrong


def isolated(wrong: Mask) -> bool:
    """Tell whether there are wrong readings, and so few that they are not a motion."""
    return bool(wrong.any()) and bool(wrong.mean() <= _MOST)


@once
def without_outliers(experiment: Experiment) -> Array:
    """Readings of a record, m, the outliers interpolated; as they are where there are none or too many.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    array, shape (n,)

    Notes
    -----
    A block of one to three samples is predicted by a cubic through four neighbors on each side. It is an outlier where
    its ends are off by many times the spread of these neighbors about their cubic, and of the record's noise: a kink, a
    jump or a bounce of the motion disturbs the neighbors as well, an outlier does not. One of the last four samples is
    predicted by more of them before it, one of the second to the fourth by more after it, if its neighbors read alike.
    """
    y, (out,) = interpolate_readings(experiment, detectors=(outliers,))
    if out.any():
        y.setflags(write=False)
    return y
