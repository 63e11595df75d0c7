"""Levels that an input is held at, where it was measured: readings scatter about each."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stepid.core.base import Array, Index
from stepid.core.experiment import Experiment
from stepid.core.noise import rms
from stepid.core.once import once
from stepid.core.outliers import LONGEST

STEP = 0.05
"""Of the input's range: a smaller change is noise on it."""
_CLEAR = 6.0  # standard deviations of a change by noise, beyond which it is a step
_FEWEST = 8  # samples of a level whose scatter says something
_LONE = 3  # samples in a row of a level that may be misread
_WHITE = 0.5  # von Neumann ratio over 2, below which a level drifts or sags: what the drive did, and no noise


def most_steps(samples: int) -> int:
    """Changes of an input of so many samples beyond which it is no sequence of levels that are held."""
    return max(2, samples // 8)


def level_bounds(values: Array) -> Index | None:
    """First sample of each level, and the number of samples; None where the input is exact, or no noise on levels.

    Parameters
    ----------
    values : array, shape (n,)
        V.
    """
    bounds = step_bounds(values)
    if bounds.size > most_steps(values.size):
        return None
    about = [part - part.mean() for part in (values[a:b] for a, b in pairwise(bounds)) if part.size >= _FEWEST]
    scatters = any(np.ptp(part) > 0 for part in about)
    return bounds if scatters and _are_white(about) else None


def held_bounds(run: Experiment) -> Index | None:
    """As `level_bounds` of a run's input; what is read beside the levels may be of any color where it is small.

    It differs from sample to sample, which small steps of the drive do not.
    """
    values = run.input
    if run.input_between != "held":
        return None
    if 2 * np.count_nonzero(np.diff(values)) > values.size:
        bounds = step_bounds(values)
        small = rms(beside_levels(values, bounds)) <= STEP * float(np.ptp(values))
        if small and bounds.size <= most_steps(values.size):
            return bounds
    return level_bounds(values)


def beside_levels(values: Array, bounds: Index) -> Array:
    """What is read beside the mean of each level, shape (n,)."""
    return np.concatenate([values[a:b] - values[a:b].mean() for a, b in pairwise(bounds)])


@once
def levelled(run: Experiment) -> Experiment:
    """Return a run with its input at its own levels, where it is read with noise about them; else the run.

    It rested under the first of them where that is no step from what the run says.
    """
    bounds = held_bounds(run)
    if bounds is None:
        return run
    return at_levels(run, bounds, [float(run.input[a:b].mean()) for a, b in pairwise(bounds)])


def at_levels(run: Experiment, bounds: Index, levels: Sequence[float]) -> Experiment:
    """Return a run with its input held at given levels [V] between `bounds`; see `levelled`."""
    no_step = abs(levels[0] - run.input_before) <= STEP * float(np.ptp([run.input_before, *levels]))
    before = levels[0] if no_step else run.input_before
    return run.model_copy(update={"input": np.repeat(levels, np.diff(bounds)), "input_before": before})


def lone_samples(values: Array) -> list[slice]:
    """Find samples of an input, three in a row at most, that leave a level which holds on both sides of them.

    Parameters
    ----------
    values : array, shape (n,)
        V.

    Returns
    -------
    list of slice
    """
    bounds = step_bounds(values)
    clear = STEP * float(np.ptp(values))
    return [
        slice(a, b)
        for start, a, b, stop in zip(bounds, bounds[1:], bounds[2:], bounds[3:], strict=False)
        if b - a <= _LONE and min(a - start, stop - b) >= _FEWEST and abs(values[a - 1] - values[b]) <= clear
    ]


def without_samples(values: Array, lone: Sequence[slice]) -> Array:
    """Return an input, shape (n,), V, with samples of it at the level around them."""
    out = values.copy()
    for some in lone:
        around = np.concatenate([values[some.start - _FEWEST : some.start], values[some.stop : some.stop + _FEWEST]])
        out[some] = np.median(around)
    out.setflags(write=False)
    return out


def step_bounds(values: Array) -> Index:
    """First sample of each stretch between two steps that no noise makes, and the number of samples.

    Parameters
    ----------
    values : array, shape (n,)
        V.
    """
    change = np.abs(np.diff(values))
    clear = max(STEP * float(np.ptp(values)), _CLEAR * 1.4826 * float(np.median(change))) if change.size else 0.0
    return np.concatenate([[0], np.flatnonzero(change > clear) + 1, [values.size]]).astype(np.intp)


def _are_white(scatters: Sequence[Array]) -> bool:
    """Tell whether what is read of levels knows nothing of its neighbors; few samples of one alone do not tell."""
    power = sum(float(one @ one) for one in scatters)
    return sum(float(np.sum(np.diff(one) ** 2)) for one in scatters) >= 2 * _WHITE * power


def changes_by(run: Experiment, begin: int, end: int) -> bool:
    """Tell whether the input changes from a few samples before one to another: a step may move a cart at once."""
    return bool(np.diff(run.input[max(begin - LONGEST, 0) : end + 1]).any())
