"""The clock of a record: when its samples were taken, where its time stamps are not even."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.once import once
from stepid.core.samples import CLOSE, divided_differences, even_clock, is_even, off_even_clock

_BETTER = 0.9  # times the spread on the even clock, above which the stamps' own times are no better
_ORDER = 8  # of the differences that are compared
_FAST = 0.5  # of the highest speed, above which differences are compared: where the cart rests, any clock will do
_HIGHEST = 0.98  # quantile of the speed that is the highest but for outliers


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


def clock_note(experiment: Experiment) -> str | None:
    """Say how the time stamps of a record are taken, None where they are even."""
    if is_even(experiment.time):
        return None
    used, worst = clock(experiment), float(off_even_clock(experiment.time).max())
    who = f"Run {experiment.name!r}: its time stamps"
    if worst > CLOSE:
        longest, usual = float(np.diff(experiment.time).max()), experiment.sample_time
        return f"{who} are uneven ({usual:.4g} s apart, at most {longest:.4g} s) and are taken as they are."
    if used is experiment.time:
        how = "are taken as they are, with which the motion is smoother"
    else:
        how = "an even clock is taken for them, with which the motion is as smooth or smoother"
    return f"{who} are up to {worst:.2g} of a sample off an even clock; {how}."
