"""Wrong samples of a record, found before any fit: isolated outliers, and readings that stick while the cart moves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.noise import record_noise
from stepid.core.words import length
from stepid.fitting.record_fault import RecordFault
from stepid.simulation.records import Records

Mask = npt.NDArray[np.bool_]
_SIDE = 4  # neighbors on each side that tell what a sample should read
_DEGREE = 3  # of the polynomial through them
_OUTLIER = 9.0  # standard deviations; kinks, jumps and bounces of the motion itself stay below 3.5
_STUCK = 4.0  # the same where a reading is repeated to the last digit and the cart then catches up
_CAUGHT_UP = 0.7  # share of the way missed meanwhile that a reading makes good in one sample: a cart at rest does not
_STEADY = 0.5  # speed before over speed after, or the reverse, of a cart that moves on
_LONGEST = 3  # samples of one outlier
_STICKS = 8  # samples that a reading may stick
_COUNTS = 3.0  # counts that rounding never makes
_MOST = 0.05  # share of a record beyond which nothing is isolated
_PASSES = 20
_NAMED = 6  # samples named in a sentence
_NEXT_TO_NOTHING = 1e-6  # square-root weight of a reading that is left out
_RESIDUAL = 8.0  # standard deviations of a good fit's residual


class _Local(NamedTuple):
    """Prediction of a block of m samples from its neighbors, shape (m, 2k), their misfit, and the spread of both."""

    predict: Array
    misfit: Array
    spread: Array


class Mended(NamedTuple):
    """A record whose wrong samples are interpolated, which these are, and what is said of them."""

    run: Experiment
    wrong: Mask
    faults: tuple[RecordFault, ...]


def _sides(count: int, after: int) -> npt.NDArray[np.intp]:
    """Where the neighbors of a block are, counted from its begin: so many of them after it, the rest before."""
    return np.concatenate([np.arange(after - 2 * _SIDE, 0), np.arange(count, count + after)])


@cache
def _local(count: int, after: int = _SIDE) -> _Local:
    at = _sides(count, after) - (count - 1) / 2
    basis = np.vander(at.astype(np.float64), _DEGREE + 1)
    inverse = np.linalg.pinv(basis)
    predict = np.vander(np.arange(count) - (count - 1) / 2, _DEGREE + 1) @ inverse
    misfit = np.eye(2 * _SIDE) - basis @ inverse
    return _Local(predict, misfit, np.sqrt(1.0 + np.sum(predict**2, axis=1)))


def _stand_out(
    y: Array, count: int, begin: npt.NDArray[np.intp], noise: float, after: int = _SIDE
) -> tuple[Array, Array]:
    """Deviation of blocks that begin at given samples from their neighbors: in standard deviations, and in m."""
    local = _local(count, after)
    near = y[begin[:, None] + _sides(count, after)]
    block = y[begin[:, None] + np.arange(count)]
    off = block - near @ local.predict.T
    freedom = 2 * _SIDE - _DEGREE - 1
    spread = np.sqrt(np.sum((near @ local.misfit.T) ** 2, axis=1) / freedom)
    return np.abs(off) / local.spread / np.maximum(spread, noise)[:, None], off


def _interpolate(y: Array, begin: int, count: int) -> None:
    after = min(_SIDE, y.size - begin - count)
    y[begin : begin + count] = _local(count, after).predict @ y[begin + _sides(count, after)]


def _take(y: Array, found: list[tuple[float, int, int]], wrong: Mask) -> bool:
    """Interpolate blocks (score, begin, count), the plainest first, none near another."""
    busy = np.zeros(y.size, dtype=bool)
    for _, begin, count in sorted(found, reverse=True):
        around = slice(begin - _SIDE, begin + count + _SIDE)
        if busy[around].any():
            continue
        busy[around] = True
        wrong[begin : begin + count] = True
        _interpolate(y, begin, count)
    return bool(found)


def _stuck(y: Array, noise: float, least: float) -> list[tuple[float, int, int]]:
    """Blocks that repeat the reading before them while their neighbors move on."""
    same = np.concatenate([[False], np.diff(y) == 0, [False]])
    begins = np.flatnonzero(same[1:] & ~same[:-1]) + 1
    ends = np.flatnonzero(~same[1:] & same[:-1]) + 1
    found = []
    for begin, end in zip(begins, ends, strict=True):
        count = int(end - begin)
        if count > _STICKS or begin < _SIDE or end > y.size - _SIDE:
            continue
        before, after = (y[begin - 1] - y[begin - _SIDE]) / 3, (y[end + 3] - y[end]) / 3
        speed, caught = 0.5 * (before + after), (y[end] - y[end - 1]) / (count + 1)
        slow, fast = sorted((abs(before), abs(after)))
        if before * after <= 0 or slow < _STEADY * fast or caught / speed < _CAUGHT_UP:
            continue
        score, off = _stand_out(y, count, np.array([begin]), noise)
        if score.max() > _STUCK and np.abs(off).max() > least:
            found.append((float(score.max()), int(begin), count))
    return found


def _outliers(y: Array, noise: float, least: float) -> list[tuple[float, int, int]]:
    """Blocks of up to three samples, all of which stand out from their neighbors."""
    found = []
    for count in range(1, _LONGEST + 1):
        begin = np.arange(_SIDE, y.size - _SIDE - count + 1)
        score, off = _stand_out(y, count, begin, noise)
        out = (score.min(axis=1) > _OUTLIER) & (np.abs(off).min(axis=1) > least)
        found += [(float(score[i].min()), int(begin[i]), count) for i in np.flatnonzero(out)]
    return found + _last(y, noise, least)


def _last(y: Array, noise: float, least: float) -> list[tuple[float, int, int]]:
    """One of the last samples that stands out, by more than any acceleration of the record does in a sample.

    The first ones are not asked: there a motion may begin, which those after it do not tell.
    """
    found = []
    for after in range(_SIDE):
        begin = y.size - 1 - after
        score, off = _stand_out(y, 1, np.array([begin]), noise, after)
        fastest = float(np.abs(np.diff(y[: begin - 1], 2)).max(initial=0.0))
        if score[0, 0] > _OUTLIER and abs(off[0, 0]) > max(least, fastest):
            found.append((float(score[0, 0]), begin, 1))
    return found


def mend(run: Experiment) -> Mended:
    """Interpolate readings that no motion explains.

    Parameters
    ----------
    run : Experiment

    Returns
    -------
    Mended
        The record itself where nothing is wrong with it, or where too much is.

    Notes
    -----
    A block of one to three samples is predicted by a cubic through four neighbors on each side. It is an outlier where
    all of it is off by many times the spread of these neighbors about their cubic, and of the record's noise: a kink, a
    jump or a bounce of the motion disturbs the neighbors as well, an outlier does not. One of the last four samples is
    predicted by more of them before it.
    """
    nothing = np.zeros(run.position.size, dtype=bool)
    if run.position.size < 4 * _SIDE:
        return Mended(run, nothing, ())
    y = np.array(run.position)
    resolution = run.resolution or 0.0
    noise = max(record_noise(run), resolution / math.sqrt(12), 1e-7 * float(np.ptp(y)), 1e-15)
    least = _COUNTS * resolution
    stuck, out = nothing.copy(), nothing.copy()
    for _ in range(_PASSES):
        if not _take(y, _stuck(y, noise, least), stuck):
            break
    for _ in range(_PASSES):
        if not _take(y, _outliers(y, noise, least), out):
            break
    out &= ~stuck
    wrong = stuck | out
    if not wrong.any() or wrong.mean() > _MOST:
        return Mended(run, nothing, ())
    off = np.abs(y - run.position)
    kinds = {"outliers": out, "stuck readings": stuck}
    faults = [_fault(run.name, kind, mask, off) for kind, mask in kinds.items() if mask.any()]
    y.setflags(write=False)
    return Mended(run.model_copy(update={"position": y}), wrong, tuple(faults))


def _fault(run: str, kind: str, mask: Mask, off: Array) -> RecordFault:
    at = np.flatnonzero(mask)
    size = float(off[mask].max())
    one = at.size == 1
    listed = ", ".join(map(str, at[:_NAMED])) + (", …" if at.size > _NAMED else "")
    does = "stand" + "s" * one + f" out by {'up to ' * (not one)}{length(size)}"
    if kind == "stuck readings":
        does = f"repeat{'s' * one} the one before while the cart moves"
    words = (
        f"Run {run!r}: {at.size} reading{'s' * (not one)} (sample{'s' * (not one)} {listed}) {does}; "
        f"{'it is' if one else 'they are'} left out."
    )
    return RecordFault(run=run, kind=kind, size=size, unit="m", words=words)


def trust(records: Records, wrong: Mapping[str, Mask]) -> Array:
    """Factors of the square-root weights, shape (S,): next to nothing where a reading is interpolated.

    Parameters
    ----------
    records : Records
    wrong : mapping
        Run name to mask over the samples of its experiment.
    """
    masks = [wrong.get(run.name, np.zeros(run.position.size, dtype=bool)) for run in records.runs]
    every = np.concatenate([mask[b:] for mask, b in zip(masks, records.begin, strict=True)])
    return np.where(every, _NEXT_TO_NOTHING, 1.0)


def outliers_of(residual: Array, floor: float) -> Mask:
    """Isolated samples, one to three in a row, beyond eight robust standard deviations in the residual of a good fit.

    Parameters
    ----------
    residual : array, shape (n,)
        m, of one run.
    floor : float
        m; the standard deviation is not taken below it.

    Returns
    -------
    array of bool, shape (n,)
    """
    middle = float(np.median(residual))
    spread = max(1.4826 * float(np.median(np.abs(residual - middle))), floor)
    far = np.abs(residual - middle) > _RESIDUAL * spread
    edges = np.flatnonzero(np.diff(np.concatenate([[False], far, [False]])))
    out = np.zeros(residual.size, dtype=bool)
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        sides = np.concatenate([residual[max(0, begin - 2) : begin], residual[end : end + 2]])
        calm = not sides.size or float(np.abs(sides - middle).max()) < _RESIDUAL / 2 * spread
        if end - begin <= _LONGEST and calm:
            out[begin:end] = True
    return out if math.isfinite(spread) and out.mean() <= _MOST else np.zeros_like(out)
