"""The clock of a record: when its samples were taken, where its time stamps are not even."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.once import once
from stepid.core.samples import CLOSE, divided_differences, even_clock, is_even, off_even_clock
from stepid.core.words import capitalized, runs_named

_BETTER = 0.9  # times the spread on the even clock, above which the stamps' own times are no better
_ORDER = 8  # of the differences that are compared
_FAST = 0.5  # of the highest speed, above which differences are compared: where the cart rests, any clock will do
_HIGHEST = 0.98  # quantile of the speed that is the highest but for outliers
_UNEVEN = "are taken as they are"
_SMOOTHER = "they are taken as they are, with which the motion is smoother"
_EVEN = "an even clock is taken for them, with which the motion is as smooth or smoother"


@once
def clock(experiment: Experiment) -> Array:
    """Return the time of each sample, s: the stamps, or an even clock where that makes the smoother motion.

    Stamps that are within half a sample of an even clock may be late or rounded, the samples even; or both may be
    uneven. The motion tells where the cart is fast: on a wrong clock a smooth one is rough.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    array, shape (n,)
    """
    own = experiment.time
    if is_even(own) or off_even_clock(own).max() > CLOSE:
        return own
    even = even_clock(own)
    moved = np.ptp(np.lib.stride_tricks.sliding_window_view(experiment.position, _ORDER + 1), axis=1)
    fast = moved >= _FAST * np.quantile(moved, _HIGHEST)
    spread = [np.abs(divided_differences(t, experiment.position, order=_ORDER)[fast]) for t in (own, even)]
    rough = [float(np.median(one)) for one in spread]
    return own if rough[0] < _BETTER * rough[1] else even


def clock_notes(runs: Iterable[Experiment]) -> list[str]:
    """Say how the time stamps of records are taken where they are not even; runs of which that is the same together."""
    taken: dict[str, list[Experiment]] = {}
    for run in runs:
        if not is_even(run.time):
            taken.setdefault(_way(run), []).append(run)
    return [_note(some, way) for way, some in taken.items()]


def _way(run: Experiment) -> str:
    if off_even_clock(run.time).max() > CLOSE:
        return _UNEVEN
    return _SMOOTHER if clock(run) is run.time else _EVEN


def _note(runs: list[Experiment], way: str) -> str:
    named = capitalized(runs_named([run.name for run in runs]))
    who = f"{named}: {'their' if len(runs) > 1 else 'its'} time stamps are"
    if way == _UNEVEN:
        longest = max(float(np.diff(run.time).max()) for run in runs)
        return f"{who} uneven, at most {longest:.4g} s apart, and {way}."
    worst = max(float(off_even_clock(run.time).max()) for run in runs)
    return f"{who} up to {worst:.2g} of a sample off an even clock; {way}."
