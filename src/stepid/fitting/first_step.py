"""Where a driven run begins: at the first change of its input that it answers, from rest."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from stepid.core.experiment import Experiment
from stepid.core.input_levels import levelled
from stepid.core.noise import span_at_rest
from stepid.core.words import length
from stepid.simulation.starts import starts_in_motion

_LIKE = 0.9  # share of an input change that another must have to be as strong
_LATE = 4.0  # times the usual time to an answer
_STILL = 0.005  # of a run's travel: less is no motion
_LEAD = 10  # samples at rest that are kept before the first step
_REST = 40  # samples before a step in which a cart at rest does not move
_FIRST = 8  # samples in which a record that starts in motion moves
_LEAST = 24  # samples that a run must have after its unusable stretch


class _Answer(NamedTuple):
    """What a run does after a change of its input at sample `at`, until sample `end`."""

    at: int
    end: int
    change: float  # V
    before: float  # V
    lag: float | None  # s to the first motion, None where nothing moves
    rests: bool  # the cart is at rest before


class _Seen(NamedTuple):
    """A run, what noise makes of its rest [m], and what it answers."""

    run: Experiment
    quiet: float
    answers: list[_Answer]


class _Stretch(NamedTuple):
    """A stretch at the start of a run that is of no use: in words, and how many changes of the input it holds."""

    what: str
    changes: int


def from_rest(runs: list[Experiment]) -> tuple[list[Experiment], list[str]]:
    """Begin each driven run at the first change of its input that it answers, from rest.

    Parameters
    ----------
    runs : list of Experiment

    Returns
    -------
    runs : list of Experiment
        Those that hold such a change, or need none.
    notes : list of str
        What is left out.
    """
    seen = [_Seen(run, quiet := span_at_rest(run), _answers(run, quiet)) for run in runs]
    # a cart that moves already answers at once, whatever its drive does
    lags = sorted(a.lag for one in seen for a in one.answers if a.lag is not None and a.rests)
    if not lags:
        return runs, []
    usual, moving = lags[len(lags) // 4], _already_moving(seen)
    out, notes = [], []
    for one in seen:
        begun: Experiment | None = one.run
        if (stretch := _unusable(one, usual, moving)) is not None:
            begun, note = _begun_after(one, stretch)
            notes.append(note)
        if begun is not None:
            out.append(begun)
    return out, notes


def _already_moving(seen: list[_Seen]) -> frozenset[str]:
    """Names of runs whose cart moves before their first step, where most do not."""
    moving = [
        one.run.name
        for one in seen
        if one.answers and not _begins_in_motion(one) and _moves_first(one.run, one.answers[0], one.quiet)
    ]
    # most: not a mistake but what this plant does, as something shakes it, or its zero drifts
    return frozenset() if 2 * len(moving) > len(seen) else frozenset(moving)


def _unusable(one: _Seen, usual: float, moving: Collection[str]) -> _Stretch | None:
    """The stretch at a run's start in which the drive was not on, something jumped or the cart already moves."""
    found = one.answers
    weakest = min((abs(a.change) for a in found if a.lag is not None and a.rests), default=np.inf)
    alive = (i for i, a in enumerate(found) if not _dead(a, weakest, usual, one.run.sample_time))
    dead = next(alive, len(found))
    if dead:
        return _Stretch("in which its input changes but nothing answers (was the amplifier off?)", dead)
    jump = _jump(one.run, one.quiet)
    if jump is not None:
        what = f"up to a jump of {length(jump[1])} from one sample to the next"
        return _Stretch(what, sum(a.at <= jump[0] for a in found))
    return _Stretch("in which the cart already moves", 1) if one.run.name in moving else None


def _begun_after(one: _Seen, stretch: _Stretch) -> tuple[Experiment | None, str]:
    """The run from the first step from rest behind an unusable stretch on, or None where there is none; and a note."""
    run, found, (what, changes) = one.run, one.answers, stretch
    good = next((a for a in found[changes:] if a.rests and a.lag is not None), None)
    begin = 0 if good is None else max(found[changes - 1].at + 1 if changes else 0, good.at - _LEAD)
    if good is None or run.position.size - begin < _LEAST:
        return None, f"Run {run.name!r} is left out: no step from rest follows the stretch {what}."
    return _cut(run, begin, good.before), f"Run {run.name!r}: the first {begin} samples, {what}, are left out."


def _answers(run: Experiment, quiet: float) -> list[_Answer]:
    """What follows each change of the input; nothing where it changes all the time, or never."""
    run = levelled(run)
    before = np.concatenate([[run.input_before], run.input[:-1]])
    at = np.flatnonzero(run.input != before)
    if run.is_release or at.size > 0.05 * run.input.size:
        return []
    out = []
    still = max(quiet, _STILL * float(np.ptp(run.position)))
    for begin, end in zip(at, np.append(at, run.input.size)[1:], strict=True):
        y = run.position[begin:end]
        moved = np.flatnonzero(np.abs(y - y[0]) > still)
        lag = float(moved[0]) * run.sample_time if moved.size else None
        led = run.position[max(0, begin - _REST) : begin + 1]
        rests = float(np.ptp(led)) <= still
        change = float(run.input[begin] - before[begin])
        out.append(_Answer(int(begin), int(end), change, float(before[begin]), lag, rests))
    return out


def _dead(found: _Answer, weakest: float, usual: float, sample_time: float) -> bool:
    """Tell whether a change as strong as those that move the cart does not, or far too late."""
    if abs(found.change) < _LIKE * weakest:
        return False
    patience = _LATE * usual + _LEAD * sample_time
    if found.lag is None:
        return (found.end - found.at) * sample_time > patience
    return found.lag > patience


def _moves_first(run: Experiment, first: _Answer, quiet: float) -> bool:
    led = run.position[: first.at + 1]
    return led.size > 4 and float(np.ptp(led)) > max(quiet, 0.1 * float(np.ptp(run.position)))


def _begins_in_motion(one: _Seen) -> bool:
    """Tell whether a run's initial state is fitted, and it moves from its first samples on."""
    run = one.run
    if run.starts != "auto":
        return run.starts == "motion"
    return float(np.ptp(run.position[:_FIRST])) > one.quiet and starts_in_motion(run)


def _jump(run: Experiment, quiet: float) -> tuple[int, float] | None:
    """Sample and size [m] of a jump near the start that no cart makes: many times any other change of the reading."""
    change = np.abs(np.diff(run.position))
    early = max(4, change.size // 20)
    at = int(np.argmax(change[:early]))
    others = np.delete(change, at)
    if change[at] > 3.0 * float(others.max()) and change[at] > 4.0 * quiet:
        return at, float(change[at])
    return None


def _cut(run: Experiment, begin: int, before: float) -> Experiment:
    fields = {name: getattr(run, name) for name in type(run).model_fields}
    arrays = {name: fields[name][begin:] for name in ("time", "position", "input")}
    return Experiment(**(fields | arrays | {"input_before": before, "starts": "auto"}))
