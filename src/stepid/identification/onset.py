"""When a response begins: of a plant of second order at its step, of a drive that came on late not."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.errors import NoStepError

_BEGUN = 0.02  # of the final level: a second-order plant is there after a fifteenth of its time to the peak
_LATE = 0.4  # of the time to the peak: then it is late by more than half of what the peak takes


def check_onset(who: str, time: Array, swing: Array, *, level: float, peak_time: float, tolerance: float) -> None:
    """Refuse a response that begins long after its step: its peak time would make a plant of its own.

    Parameters
    ----------
    who : str
        The run and its step, for the message.
    time, swing : array, shape (n,)
        s since the step, and m from rest, turned upward.
    level, peak_time, tolerance : float
        m, the final level; s; m, what stands out of noise and grid.

    Raises
    ------
    stepid.errors.NoStepError
    """
    still = np.flatnonzero((swing <= max(_BEGUN * level, tolerance)) & (time < peak_time))
    begun = float(time[still[-1]]) if still.size and tolerance < 0.5 * level else 0.0
    if begun > _LATE * peak_time:
        raise NoStepError(
            f"{who}: nothing answers the step for {begun:.3g} s of the {peak_time:.3g} s to its peak",
            "Was the amplifier switched on late? Correct the recorded input, or leave the run out.",
        )
