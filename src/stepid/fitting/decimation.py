"""Fewer samples to race on: every few samples one, with what its neighbors say about the gap averaged in."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from stepid.core.base import Array, Index
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.problem import build
from stepid.simulation.records import Records

_FEWEST = 200  # samples
_PER_PERIOD = 16.0  # samples to keep of the fastest run's period
_BLUR = 0.1  # of the period: as wide an average loses a fifth of the floor where the gap is as small as the floor
_PERIODS = 60.0  # to keep of a record of which every sample is needed
_MOST_CHANGES = 0.1  # share of samples with a new input above which all are needed


def decimated(records: Records, linear: Optimum, period: float, floor: float) -> Records:
    """Keep every m-th sample, and those where the input changes; of a long record with a busy input a first part.

    What is averaged over each kept sample's neighborhood is the gap to the linear fit: it is small and slow, so that
    noise is averaged out and hardly any of the gap. Weights are such that a gap costs what it costs in all samples.

    Parameters
    ----------
    records : Records
    linear : Optimum
        Of the linear plant, on the same records.
    period : float
        s, the shortest that the linear plant swings with.
    floor : float
        m, noise floor: the larger the gap, the less is averaged, for blur must stay below the noise.

    Returns
    -------
    Records
        With `at`; the same records where nothing can be left out.
    """
    kept: list[Index] = []
    for r, piece in enumerate(records.pieces()):
        step = _stride(period / float(records.sample_time[r]))
        volts = records.volts[piece]
        changes = np.flatnonzero(np.diff(np.concatenate([[records.before[r]], volts])))
        size = volts.size
        busy = changes.size > _MOST_CHANGES * size
        whole = step == 1 or busy or records.coefficients.shape[1] > 1
        enough = max(_FEWEST, math.ceil(_PERIODS * period / float(records.sample_time[r])))
        first = _telling(linear.residual[piece] ** 2, enough) if busy else size
        kept.append(piece.start + (np.arange(first) if whole else _grid(size, step, changes)))
    at = np.concatenate(kept)
    if at.size == records.size:
        return records
    bounds = np.concatenate([[0], np.cumsum([k.size for k in kept])]).astype(np.intp)
    run = records.run[at]
    width = _BLUR * period / np.sqrt(max(linear.rms / floor, 1.0)) / records.sample_time[run]
    gap, weight = _averages(records, linear, at, bounds, width)
    return replace(
        records,
        bounds=bounds,
        run=run,
        time=records.time[at],
        position=(records.position - linear.residual)[at] + gap,
        volts=records.volts[at],
        weight=weight,
        coefficients=records.coefficients[at],
        at=at,
    )


def _telling(power: Array, least: int) -> int:
    """Samples of a first part, `least` at least, in which the linear plant leaves half the mean power or more.

    A slow sweep comes to the resonance late: what is missing does not show before.
    """
    if power.size <= least:
        return power.size
    means = np.cumsum(power) / np.arange(1, power.size + 1)
    return least + int(np.argmax(2 * means[least - 1 :] >= means[-1]))


def _stride(samples: float) -> int:
    """Odd number of samples to take as one."""
    return max(1, 2 * round((samples / _PER_PERIOD - 1) / 2) + 1)


def _grid(size: int, step: int, changes: Index) -> Index:
    """Every `step`-th sample from each change of the input on, the ends included."""
    marks = np.unique(np.concatenate([[0], changes, [size - 1]]))
    between = [np.append(np.arange(a, b, step), b) for a, b in pairwise(marks)]
    return np.unique(np.concatenate([marks, *between]))


def _averages(records: Records, linear: Optimum, at: Index, bounds: Index, width: Array) -> tuple[Array, Array]:
    """Weighted mean of the gap over up to `width` samples around each kept one; square-root weights."""
    before = np.diff(at, prepend=at[0])
    after = np.diff(at, append=at[-1])
    before[bounds[:-1]] = 0
    after[bounds[1:] - 1] = 0
    half = np.minimum(np.minimum(before, after), width.astype(np.intp)) // 2
    square = records.weight**2
    sums = np.concatenate([[0.0], np.cumsum(square)])
    gaps = np.concatenate([[0.0], np.cumsum(square * linear.residual)])
    low, high = at - half, at + half + 1
    total = sums[high] - sums[low]
    mean = np.divide(gaps[high] - gaps[low], total, out=np.zeros_like(total), where=total > 0)  # all may be left out
    return mean, np.sqrt(total)


def shortest_period(linear: Optimum) -> float:
    """2π over the largest magnitude of a linear plant's poles [s]: the shortest period, or less if overdamped."""
    records = linear.problem.records
    of = linear.problem.layout
    mass = of.mass(linear.shared)
    natural = np.sqrt(linear.shared[of.stiffness][records.spring] / mass)
    ratio = np.maximum(linear.shared[of.damping][records.damper] / (2 * mass * natural), 1.0)
    return float(np.min(2 * np.pi / (natural * (ratio + np.sqrt(ratio**2 - 1)))))


def fit_coarsely(records: Records, linear: Optimum) -> Optimum:
    """Fit the linear plant to decimated records, from its fit to all samples.

    That fit itself where nothing is left out, or where the plant runs away on the decimated records, as one that hardly
    a spring holds may.
    """
    if records.at is None:
        return linear
    problem = replace(build(records, ()), free=linear.problem.free, active=linear.problem.active)
    found = minimize(problem, linear.shared, linear.local, tolerance=1e-6 * linear.cost, iterations=6)
    return found or linear


def full_residual(optimum: Optimum, linear: Optimum, coarse: Optimum) -> Array:
    """Residual [m] of a coarse fit at all samples, shape (S,): the linear fit's, less what the coarse fit changed."""
    part, records = optimum.problem.records, linear.problem.records
    change = optimum.solved.reading - coarse.solved.reading
    if part.at is not None:
        change = np.concatenate(
            [
                np.interp(records.time[all_], part.time[few], change[few])
                for few, all_ in zip(part.pieces(), records.pieces(), strict=True)
            ]
        )
    return records.centered(linear.residual - change)
