"""The samples of a record: whether they make one, and what the input does between them."""

from __future__ import annotations

from typing import Literal

import numpy as np

from stepid.core.base import Array

InputBetween = Literal["held", "lines", "smooth"]
"""What the input does from each sample to the next: held, joined by straight lines, the cubic spline through all."""
WAYS: tuple[InputBetween, ...] = ("held", "lines", "smooth")
Starts = Literal["auto", "rest", "motion"]
"""How a record starts: as its data show, at rest under the input before it, in motion."""
STARTS: tuple[Starts, ...] = ("auto", "rest", "motion")


def check_samples(time: Array, position: Array, volts: Array, counts_per_meter: float | None) -> None:
    """Raise ValueError where samples, shape (n,) each, are too few, differ in number or are not uniform in time."""
    n = time.size
    if n < 8:
        raise ValueError(f"has {n} samples; a step response needs at least 8")
    if position.size != n or volts.size != n:
        raise ValueError(f"time, position and input differ in length ({n}, {position.size}, {volts.size})")
    if counts_per_meter == 0:
        raise ValueError("counts_per_meter is zero; give counts per meter, negative where +V gives falling counts")
    step = (float(time[-1]) - float(time[0])) / (n - 1)
    if not step > 0:
        raise ValueError("time does not increase")
    with np.errstate(all="ignore"):  # times near the largest float overflow here, and are then not uniform
        off = np.abs(time - time[0] - step * np.arange(n)) / step
    worst = int(np.argmax(off))
    if not off[worst] <= 0.01:
        raise ValueError(
            f"time is not uniform: sample {worst} is {off[worst]:.2g} of a sample time off; "
            "rebuild it from the sample number and the sample time"
        )


def course(time: Array, volts: Array, between: InputBetween) -> Array:
    """Polynomial of an input from each sample to the next, in the time since that sample.

    Parameters
    ----------
    time : array, shape (n,)
        s.
    volts : array, shape (n,)
        V.
    between : "held", "lines" or "smooth"

    Returns
    -------
    array, shape (n, 1), (n, 2) or (n, 4)
        V, V/s, V/s², V/s³; held from the last sample on.
    """
    if between == "held":
        return volts[:, None]
    if between == "lines":
        return np.column_stack([volts, np.append(np.diff(volts) / np.diff(time), 0.0)])
    from scipy.interpolate import CubicSpline

    pieces = CubicSpline(time, volts).c[::-1].T
    return np.concatenate([pieces, [[volts[-1], 0.0, 0.0, 0.0]]])
