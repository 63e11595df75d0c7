"""The samples of a record: whether they make one, and what the input does between them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from stepid.core.base import Array

CLOSE = 0.5  # of a sample, times that are nearer to an even clock may be rounded or late
EVEN = 0.01  # of a sample, by which times may be off an even clock
InputBetween = Literal["held", "lines", "smooth"]
"""What the input does from each sample to the next: held, joined by straight lines, the cubic spline through all."""
WAYS: tuple[InputBetween, ...] = ("held", "lines", "smooth")
Starts = Literal["auto", "rest", "motion"]
"""How a record starts: as its data show, at rest under the input before it, in motion."""
STARTS: tuple[Starts, ...] = ("auto", "rest", "motion")


def check_samples(time: Array, position: Array, volts: Array, counts_per_meter: float | None) -> None:
    """Raise ValueError where samples, shape (n,) each, are too few, differ in number or do not follow in time."""
    n = time.size
    if n < 8:
        raise ValueError(f"has {n} samples; a step response needs at least 8")
    if position.size != n or volts.size != n:
        raise ValueError(f"time, position and input differ in length ({n}, {position.size}, {volts.size})")
    if counts_per_meter == 0:
        raise ValueError("counts_per_meter is zero; give counts per meter, negative where +V gives falling counts")
    with np.errstate(all="ignore"):
        steps = np.diff(time)
    back = np.flatnonzero(~((steps > 0) & np.isfinite(steps)))
    if back.size == steps.size:
        raise ValueError("time does not increase")
    if back.size:
        row = int(back[0]) + 1
        rounded = "; are the times rounded? Give more digits, or count them from the sampling rate"
        raise ValueError(
            f"time does not increase: sample {row} is at {time[row]:.10g} s after {time[row - 1]:.10g} s"
            f"{rounded if time[row] == time[row - 1] else ''}"
        )
    if not np.isfinite(float(time[-1]) - float(time[0])):
        raise ValueError(f"time runs from {time[0]:.3g} s to {time[-1]:.3g} s, farther than numbers reach")


def off_even_clock(time: Array) -> Array:
    """How far times, shape (n,), are off the even clock nearest to them, in samples."""
    even = even_clock(time)
    out: Array = np.abs(time - even) * (time.size - 1) / (even[-1] - even[0])
    return out


def is_even(time: Array) -> bool:
    """Tell whether times, shape (n,), are multiples of one sample time, but for a hundredth of it."""
    return bool(off_even_clock(time).max() <= EVEN)


def even_clock(time: Array) -> Array:
    """Return the even clock nearest to times, shape (n,), by least squares."""
    number = np.arange(time.size) - (time.size - 1) / 2
    since = time - time[0]  # times far from zero keep their digits
    slope = float(number @ since) / float(number @ number)
    out: Array = time[0] + (float(since.mean()) + slope * number)
    return out


def divided_differences(time: Array, values: Array, *, order: int = 8) -> Array:
    """Differences of high order of values at uneven times, in units of their white noise.

    Parameters
    ----------
    time, values : array, shape (n,)
    order : int
        A polynomial of lower degree leaves nothing.

    Returns
    -------
    array, shape (n − order,)
        White noise of standard deviation σ gives σ.
    """
    windows = np.lib.stride_tricks.sliding_window_view(time, order + 1)
    span = (windows[:, -1:] - windows[:, :1]) / order
    apart = (windows[:, :, None] - windows[:, None, :]) / span[:, :, None]
    apart[:, np.arange(order + 1), np.arange(order + 1)] = 1.0
    factors = 1.0 / np.prod(apart, axis=2)
    factors /= np.linalg.norm(factors, axis=1, keepdims=True)
    out: Array = np.sum(factors * np.lib.stride_tricks.sliding_window_view(values, order + 1), axis=1)
    return out


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


def means_of_blocks(values: Array, width: int) -> Array:
    """Means of successive blocks of `width` values, shape (n // width,); what is left at the end does not count."""
    blocks = values.size // width
    out: Array = values[: blocks * width].reshape(blocks, width).mean(axis=1)
    return out


def lagged_products(values: Array, most: int) -> Array:
    """Sums of products of values that are 1, 2 … `most` − 1 samples apart, shape (most − 1,), by one transform."""
    spectrum = np.fft.rfft(values, 2 * values.size)
    out: Array = np.fft.irfft(np.abs(spectrum) ** 2)[1:most]
    return out


def multiples(angle: Array, first: int, stop: int) -> Iterator[Array]:
    """Cosine + i sine of successive multiples of an angle [rad], each turned on from the last: that is fast."""
    turn, wave = np.exp(1j * angle), np.exp(1j * first * angle)
    for _ in range(first, stop):
        yield wave
        wave = wave * turn
