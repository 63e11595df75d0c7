"""The sample time of a record whose time is printed rounded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stepid.core.base import Array
from stepid.errors import InputError
from stepid.io.ecp_layout import SAMPLE, TIME, Export

ENOUGH = 1e-3  # relative standard uncertainty of a sample time that may be used unasked


def fit_sample_time(sample: Array, time: Array, *, resolution: float) -> tuple[float, float]:
    """Fit the sample time by least squares of Time on Sample.

    Parameters
    ----------
    sample : array, shape (n,)
        Sample numbers, n at least 2.
    time : array, shape (n,)
        s, rounded to `resolution`.
    resolution : float
        s, the last printed digit.

    Returns
    -------
    sample_time, uncertainty : float
        s; the standard uncertainty is that of rounding, resolution/√12 a row.
    """
    centered = sample - sample.mean()
    scatter = float(centered @ centered)
    return float(centered @ time) / scatter, resolution / np.sqrt(12.0 * scatter)


def rebuild_time(
    sample: Array,
    time: Array | None,
    *,
    resolution: float,
    sample_time: float | None,
    lines: Sequence[int],
    where: str,
) -> Array:
    """Rebuild the time of every sample from its number.

    Parameters
    ----------
    sample : array, shape (n,)
        Consecutive sample numbers.
    time : array, shape (n,) or None
        s, as printed, rounded to `resolution`.
    resolution : float
        s, the last printed digit of `time`.
    sample_time : float or None
        s, if known; else fitted to `time`.
    lines : sequence of int
        Line of each row, for errors.
    where : str
        The file, for errors.

    Returns
    -------
    array, shape (n,)
        s; sample number times sample time, plus whole samples where the printed clock starts elsewhere.

    Raises
    ------
    stepid.errors.InputError
        If the printed times disagree with one sample time, or do not determine it to 0.1 %.
    """
    if sample_time is not None and not (np.isfinite(sample_time) and sample_time > 0):
        raise InputError(f"{where}: sample_time is {sample_time:g} s", "Give a positive sample time in seconds.")
    if time is None:
        if sample_time is None:
            raise InputError(f"{where}: has no Time column", "Give the sample time with sample_time=… (s).")
        return sample * sample_time
    step, spread = fit_sample_time(sample, time, resolution=resolution)
    if not step > 0:
        raise InputError(f"{where}, column 'Time': time does not increase", "Export the record again.")
    known = step if sample_time is None else sample_time
    offset = float(np.mean(time - known * sample))
    off = np.abs(time - known * sample - offset)
    if not off.max() <= 0.6 * resolution + 0.05 * known:
        raise _disagreement(sample, time, step, sample_time, resolution, lines, where)
    if sample_time is None and spread > ENOUGH * step:
        raise InputError(
            f"{where}: {sample.size} rows with Time rounded to {resolution:g} s give the sample time only as "
            f"{step * 1e3:.3g} ± {spread * 1e3:.1g} ms",
            "Give it with sample_time=… (s); longer records of the same set-up tell it.",
        )
    # the clock of the newer program may start one sample early or late; that is no offset
    slack = 1.5 * max(known, resolution) + (
        0.0 if sample_time is not None else 4 * spread * float(np.abs(sample).max())
    )
    shift = 0.0 if abs(offset) <= slack else float(np.rint(offset / known))
    return (sample + shift) * known


def real_stamps(export: Export) -> Array | None:
    """Times of an export's rows as printed, s, where they increase and are no multiples of Sample; else None.

    Parameters
    ----------
    export : Export

    Returns
    -------
    array, shape (n,), or None
    """
    time, sample = export.get(TIME), export.get(SAMPLE)
    if time is None or not np.all(np.diff(time) > 0):
        return None
    sample = np.arange(time.size, dtype=np.float64) if sample is None else sample
    if not np.all(np.diff(sample) >= 1):
        return None
    step, _ = fit_sample_time(sample, time, resolution=export.time_resolution)
    off = time - step * sample
    follows = np.abs(off - off.mean()).max() <= 0.6 * export.time_resolution + 0.05 * step
    return None if follows and np.all(np.diff(sample) == 1) else time


def _disagreement(
    sample: Array,
    time: Array,
    fitted: float,
    given: float | None,
    resolution: float,
    lines: Sequence[int],
    where: str,
) -> InputError:
    own = np.abs(time - fitted * sample - np.mean(time - fitted * sample))
    if given is not None and own.max() <= 0.6 * resolution + 0.05 * fitted:
        return InputError(
            f"{where}: sample_time is given as {given:.8g} s, but its Time column says {fitted:.8g} s",
            "Leave sample_time out, or correct it.",
        )
    steps = np.diff(time)
    usual = float(np.median(steps))
    row = int(np.argmax(np.abs(steps - usual) > 1.5 * resolution + 0.05 * abs(usual)))
    if abs(steps[row] - usual) <= 1.5 * resolution + 0.05 * abs(usual):  # no single jump: the rate itself changes
        row = int(np.argmax(own)) - 1
    return InputError(
        f"{where}, line {lines[row + 1]}, column 'Time': {time[row + 1]:g} s does not follow from one sample time "
        f"(usual step about {usual:g} s)",
        "The record has a gap or two different sample times; export it again or split it.",
    )
