"""Jumps of a reading that no cart makes: samples were lost there, or the reading slipped."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from stepid.core.base import Array, Index
from stepid.core.hand import hand
from stepid.core.input_levels import changes_by
from stepid.core.noise import span_at_rest
from stepid.core.outliers import LONGEST

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

_TIMES = 2.5  # times any other that stands out so
_CLEAR = 4.0  # times what noise makes of a cart at rest
_STEADY = 1.0  # of a jump, by which the speed may change: a stop changes it by twice what one sample is off
_BACK = 0.5  # of a jump, by which changes beside it go back where a few readings are wrong
_SIDE = 3  # changes on each side that tell how far a cart moves from one sample to the next
_MOST = 5  # jumps of a record: of more none is an exception
_EARLY = 20  # part of a record, in which where it begins is asked: see `stepid.fitting.first_step`
_FEWEST = 24  # samples of a part


def jumps(experiment: Experiment) -> list[int]:
    """First sample after each jump of a reading: it moves on as before, from elsewhere.

    What stands out by far more than any other change, beside those around it, from one sample to the next. A step of
    the input may move a cart that its samples hardly follow, and an isolated wrong reading is off twice, there and
    back: these are none.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    list of int
    """
    n = experiment.position.size
    if n < 2 * _FEWEST:
        return []
    change = np.diff(experiment.position) * (experiment.sample_time / np.diff(experiment.time))  # no gap in the stamps
    windows = np.lib.stride_tricks.sliding_window_view(change, 2 * _SIDE + 1)
    before, after = np.median(windows[:, :_SIDE], axis=1), np.median(windows[:, -_SIDE:], axis=1)
    beyond = windows[:, _SIDE] - (before + after) / 2
    found, size = _largest(beyond), np.abs(beyond)
    moves_on = [i for i in found if _moves_on(experiment, i, beyond, after - before)]
    clear = _CLEAR * span_at_rest(experiment)
    for count in range(min(len(moves_on), len(found) - 1), 0, -1):
        kept = moves_on[:count]
        if size[kept[-1]] > max(_TIMES * max(size[i] for i in found if i not in kept), clear):
            return sorted(int(i) + _SIDE + 1 for i in kept)
    return []


def _moves_on(experiment: Experiment, i: int, beyond: Array, turn: Array) -> bool:
    """Tell whether a cart moves on as before where its reading changes `beyond` what it does beside that; by no step.

    `turn` is by how much it changes more afterwards than before.
    """
    at = i + _SIDE + 1
    if at <= experiment.position.size // _EARLY or abs(turn[i]) > _STEADY * abs(beyond[i]):
        return False
    near = beyond[max(i - LONGEST, 0) : i + LONGEST + 1] / beyond[i]
    return bool(near.min() >= -_BACK) and not changes_by(experiment, at - 1, at)  # there and back are wrong readings


def _largest(beyond: Array) -> Index:
    """The largest few, one more than jumps may be, with none beside a larger one: that is in what these are held to."""
    left, out = np.abs(beyond), list[int]()
    for _ in range(min(_MOST + 1, beyond.size)):
        out.append(int(np.argmax(left)))
        left[max(out[-1] - _SIDE, 0) : out[-1] + _SIDE + 1] = 0.0
    return np.array(out, dtype=np.intp)


def split_at(experiment: Experiment, at: Sequence[int]) -> tuple[Experiment, ...]:
    """Split a record at some samples: what follows each starts in motion, and has a rest position of its own.

    Parameters
    ----------
    experiment : Experiment
    at : sequence of int

    Returns
    -------
    tuple of Experiment
        In order of time on the record's clock, called "name (1)", "name (2)", …; the record itself where nothing is
        split. A part of less than 24 samples, those that a hand may have held not counted, is left out.
    """
    held = hand(experiment).first if at else 0
    cuts = [(a, b) for a, b in pairwise([0, *at, experiment.position.size]) if b - max(a, held) >= _FEWEST]
    if not (at and cuts):
        return (experiment,)
    parts = [experiment.slice(a, b, name=f"{experiment.name} ({i})") for i, (a, b) in enumerate(cuts, 1)]
    begun = zip(parts, cuts, strict=True)
    return tuple(part.model_copy(update={"starts": "motion"}) if a else part for part, (a, _) in begun)
