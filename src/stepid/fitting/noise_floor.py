"""The noise floor of a campaign, and how far a residual is from white noise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array, Index
from stepid.core.copies import grouped
from stepid.core.experiment import Experiment
from stepid.core.hand import period_of
from stepid.core.noise import STILL, clipped_spread, predicted_noise
from stepid.core.once import once
from stepid.core.samples import divided_differences, is_even, means_of_blocks
from stepid.core.words import length
from stepid.simulation.clock import clock
from stepid.simulation.records import Records
from stepid.simulation.simulator import FINE

_ORDER = 8  # of the differences: a swing sampled 12 times a period leaves 1e-5 of itself
_FAST = 14.0  # samples of a period, below which differences keep some of the swing
_BUSY = 0.05  # share of samples with a new input, above which it is in the differences
_BELOW = 0.75  # of the differences' spread: as much less is not chance
_CHANCE = 3.0  # standard errors of an RMS
_FEWEST = 20  # differences that make a spread
_ALIKE = 0.1  # spread of repeated runs over their motion, beyond which they are no repeats
_SCATTER = 1.5  # times the sensor's noise, by which repeated runs differ notably


def _moves(run: Experiment, y: Array) -> npt.NDArray[np.bool_]:
    """Tell for each window of `_ORDER` + 1 samples whether the reading moves by more than its resolution."""
    windows = np.lib.stride_tricks.sliding_window_view(y, _ORDER + 1)
    moves: npt.NDArray[np.bool_] = np.ptp(windows, axis=1) > STILL * (run.resolution or 0.0)
    return moves


def _moving_differences(run: Experiment, begin: int) -> Array:
    """High-order differences where the reading moves and the input does not jump, in units of white noise."""
    y = run.position[begin:]
    if y.size < _ORDER + 8:
        return np.empty(0)
    use = _moves(run, y)
    jumps = np.flatnonzero(np.diff(np.concatenate([[run.input_before], run.input])))
    for jump in jumps - begin if jumps.size < _BUSY * y.size else []:
        use[max(0, jump - _ORDER - 1) : max(0, jump + 3)] = False
    if not is_even(run.time):
        return divided_differences(clock(run)[begin:], y, order=_ORDER)[use]
    out: Array = np.diff(y, _ORDER)[use] / math.sqrt(math.comb(2 * _ORDER, _ORDER))
    return out


def von_neumann_ratio(records: Records, residual: Array) -> tuple[float, int]:
    """Mean square of a residual over half that of its successive differences, where the cart moves; and their number.

    White noise gives 1 ± 1/√n whatever its size; what is left of a motion is slower, and gives more (von Neumann 1941).

    Parameters
    ----------
    records : Records
    residual : array, shape (S,)
        Unweighted, m.
    """
    squares, steps, count = 0.0, 0.0, 0
    for piece, at in zip(records.pieces(), _moving(records), strict=True):
        r = residual[piece]
        squares += float(np.sum(r[at] ** 2))
        steps += float(np.sum((r[at] - r[at - 1]) ** 2))
        count += at.size
    return (2 * squares / steps if steps > 0 else math.inf), count


@once
def _moving(records: Records) -> tuple[Index, ...]:
    """Samples of each run at which the cart moves, and that are right like the ones before them."""
    out = []
    for run, piece in zip(records.runs, records.pieces(), strict=True):
        y, use = records.position[piece], records.trusted[piece]
        at = np.flatnonzero(_moves(run, y)) + _ORDER // 2 if y.size > _ORDER else np.zeros(0, dtype=np.intp)
        out.append(at[use[at] & use[at - 1]])
    return tuple(out)


def enough(records: Records) -> bool:
    """Tell whether the noise can be told from the motion: by enough samples that move, or by the encoder's scale."""
    moving = (_moving_differences(run, int(b)).size for run, b in zip(records.runs, records.begin, strict=True))
    return all(run.resolution is not None for run in records.runs) or sum(moving) >= _FEWEST


def noise_floor(records: Records) -> float:
    """RMS that a perfect model would leave, m: the standard deviation of the readings' noise.

    Spread of eighth differences where the cart moves, outliers clipped, not below the resolution's share
    (resolution/√12). A robust spread of differences sees white noise and cancels the motion. Where the input changes
    all the time or the swing is fast some motion is left in it; what nothing predicts counts there if clearly less.
    """
    values = [_moving_differences(run, int(b)) for run, b in zip(records.runs, records.begin, strict=True)]
    least = least_floor(records)
    d = np.concatenate(values)
    if d.size < _FEWEST:
        return least
    spread = clipped_spread(d)
    predicted = _predicted(records)
    if predicted is not None and predicted < _BELOW * spread:
        spread = predicted
    return max(spread, least)


def _predicted(records: Records) -> float | None:
    """Noise by prediction of the runs that swing fast or whose input changes all the time, m; None without any."""
    square, count = 0.0, 0
    for run, piece in zip(records.runs, records.pieces(), strict=True):
        y, u = records.position[piece], records.volts[piece]
        if np.count_nonzero(np.diff(u)) <= _BUSY * u.size and period_of(y) > _FAST:
            continue
        own = predicted_noise(y, u, resolution=run.resolution)
        if own is None:
            return None
        square, count = square + own**2 * y.size, count + y.size
    return math.sqrt(square / count) if count else None


def repeats(records: Records) -> list[tuple[int, ...]]:
    """Groups of runs recorded under the same conditions with the same input, by index."""
    resting = np.flatnonzero(~records.moving).tolist()
    groups = grouped([records.runs[i] for i in resting])
    return [tuple(resting[i] for i in group) for group in groups if len(group) > 1]


def _spreads(records: Records, left: Array | None = None) -> list[tuple[tuple[int, ...], float, float]]:
    """Groups of repeated runs, each with the sum of squares of their spread and of their motion, m².

    The spread of the readings, or of what a fit has left of them, shape (S,).
    """
    out, pieces = [], records.pieces()
    left = records.position if left is None else left
    for group in repeats(records):
        motion, stack = (_centered(values, pieces, group) for values in (records.position, left))
        between = float(np.sum((stack - stack.mean(axis=0)) ** 2)) / (len(group) - 1) * len(group)
        out.append((group, between, float(np.sum(motion**2))))
    return out


def _centered(values: Array, pieces: Sequence[slice], runs: Sequence[int]) -> Array:
    """Values of some runs of as many samples, each about its mean, shape (n, samples)."""
    stack = np.array([values[pieces[i]] for i in runs])
    out: Array = stack - stack.mean(axis=1, keepdims=True)
    return out


def repeatability(records: Records, left: Array | None = None) -> float | None:
    """Run-to-run spread of repeated runs, m: what no model of one plant can explain; None without repeats.

    Runs under the same labels that differ by a tenth of their motion are no repeats: a label, scale or sign is wrong.

    Parameters
    ----------
    records : Records
    left : array, shape (S,), optional
        m, residual of a fit in which runs may differ: the spread is what it leaves of that of the readings.
    """
    found = [(group, between) for group, between, motion in _spreads(records, left) if between <= _ALIKE**2 * motion]
    if not found:
        return None
    counts = np.diff(records.bounds)
    return math.sqrt(sum(between for _, between in found) / sum(int(counts[list(g)].sum()) for g, _ in found))


def repeat_notes(records: Records) -> tuple[str, ...]:
    """Say by how much repeated runs differ, where that is notable."""
    out = []
    for group, between, motion in _spreads(records):
        if between > _ALIKE**2 * motion:
            names = ", ".join(repr(records.runs[i].name) for i in group)
            share = 100 * math.sqrt(between / motion)
            out.append(
                f"Runs {names} have the same labels and input but differ by {share:.0f} % of their motion: "
                "a label, scale or sign is wrong."
            )
    spread = repeatability(records)
    if spread is not None and spread > _SCATTER * (noise := noise_floor(records)):
        out.append(
            f"Repeated runs differ by {length(spread)}, {spread / noise:.2g} times the sensor's noise: "
            "no model of one plant leaves less."
        )
    return tuple(out)


def bounded_floor(records: Records, floor: float, left: float, parameters: int) -> float:
    """Noise floor, m, by what a fit leaves where that is plainly less: no fit leaves less than the noise.

    Parameters
    ----------
    records : Records
    floor : float
        m, read off the records.
    left : float
        m, RMS of a fit's residual, whatever the fit: what it leaves is noise and misfit.
    parameters : int
        How many were fitted to the samples.
    """
    free = max(records.weighed_size - parameters, 1.0)
    left *= math.sqrt(records.size / max(records.size - parameters, 1))
    if left > (1.0 - _CHANCE / math.sqrt(2.0 * free)) * floor:
        return floor
    return max(left, least_floor(records))


def least_floor(records: Records) -> float:
    """Least noise floor, m: the spread of rounding to the resolution, and never less than a simulation is exact to."""
    steps = [run.resolution for run in records.runs if run.resolution is not None]
    exact = FINE * float(np.abs(records.centered(records.position)).max(initial=0.0))
    return max(max(steps, default=0.0) / math.sqrt(12), exact, np.finfo(float).tiny)


def weights(records: Records, floor: float) -> Array:
    """Square-root weights that count a stretch of one constant reading once, shape (S,).

    Where the noise is less than the resolution, a cart at rest reads the same count over and over: those readings
    share one rounding error and are one observation, not hundreds.
    """
    out = np.ones(records.size)
    for run, piece in zip(records.runs, records.pieces(), strict=True):
        if run.resolution is None or floor > 0.6 * run.resolution:
            continue
        y = records.position[piece]
        edges = np.flatnonzero(np.diff(y) != 0) + 1
        bounds = np.concatenate([[0], edges, [y.size]])
        lengths = np.diff(bounds)
        share = np.where(lengths > 6, np.sqrt(6.0 / np.maximum(lengths, 1)), 1.0)
        out[piece] = np.repeat(share, lengths)
    return out


def block_mean_deviate(records: Records, residual: Array, floor: float, period: float) -> float:
    """How far a residual is from white noise of size `floor`, in standard deviations.

    The residual is averaged over windows of a tenth of the period; white noise averages out, misfit does not.

    Parameters
    ----------
    records : Records
    residual : array, shape (S,)
        Weighted, m.
    floor : float
        m.
    period : float
        s, of the strongest oscillation.
    """
    total, freedom = 0.0, 0
    for r, piece in enumerate(records.pieces()):
        m = max(2, round(0.1 * period / float(records.sample_time[r])))
        means = means_of_blocks(residual[piece], m)
        total += float(np.sum(means**2)) * m / floor**2
        freedom += means.size
    return (total - freedom) / math.sqrt(2.0 * max(freedom, 1))
