"""What swings in the records and in a residual: periods, resonances, lines."""

from __future__ import annotations

import math

import numpy as np

from stepid.core.base import Array
from stepid.core.once import once
from stepid.simulation.records import Records

_FINE = 4  # bins of the padded spectrum to one of the record's own
_AROUND = 20  # bins of the record's own around a line, with which its height is compared
_BESIDE = 3  # of the shortest record's own bins: beside the peak of a line, whatever the record
_LINE = 30.0  # times that a line stands out; noise reached 11 in 300 draws of three runs, 54 of one: one start more
_HEARD = 30.0  # times the noise that a swing stands out; noise alone reaches ln(bins), 11 for 10⁵ samples
_APART = 0.15  # of a frequency: what is nearer is the same


def fast_length(least: int) -> int:
    """The next 2ⁿ or 3·2ⁿ: zeros up to there make a transform faster, that of a prime length twenty times."""
    whole = 1 << (least - 1).bit_length()
    return 3 * whole // 4 if 3 * whole >= 4 * least else whole


@once
def strongest_period(records: Records) -> float:
    """Period [s] of the strongest oscillation over all records.

    The velocity swings as strongly as the position, but white noise in the readings grows with frequency in it: a swing
    has to stand out from what the upper half of the band says that noise does at its own frequency. Where none does,
    a quarter of the shortest record, whatever the unit of time.
    """
    best, power, shortest = 0.0, 0.0, math.inf
    for r in range(len(records.runs)):
        step, position = records.evenly(r, records.position)
        shortest = min(shortest, step * (position.size - 1))
        y = np.diff(position)
        spectrum = np.abs(np.fft.rfft(y * np.hanning(y.size), 4 * y.size)) ** 2
        frequency = np.fft.rfftfreq(4 * y.size, step)
        noise = np.sin(np.pi * frequency * step) ** 2  # of differences of white readings
        upper = spectrum.size // 2
        level = np.median(spectrum[upper:] / noise[upper:])
        usable = (frequency > 1.5 / (y.size * step)) & (spectrum > _HEARD * level * noise)
        k = int(np.argmax(np.where(usable, spectrum, 0.0)))
        if usable[k] and spectrum[k] > power:
            best, power = 1.0 / float(frequency[k]), float(spectrum[k])
    return best or shortest / 4


def resonances(records: Records, residual: Array, count: int = 3) -> tuple[float, ...]:
    """Frequencies [Hz] at which the residual is strongest over all runs, strongest first.

    The sharpest line follows if it is none of them: a steady disturbance, however faint, rings as long as the records.
    """
    duration, grid, total, height = _spectrum(residual, records)
    found: list[float] = []
    height = height.copy()
    left = np.where(grid < 1.0 / duration, 0.0, total)
    for _ in range(count):
        k = int(np.argmax(left))
        if left[k] <= 0:
            break
        found.append(float(grid[k]))
        near = np.abs(grid - grid[k]) < max(1.5 / duration, _APART * grid[k])
        left[near] = height[near] = 0.0
    k = int(np.argmax(height))
    if height[k] > _LINE:
        found.append(float(grid[k]))
    return tuple(found)


def sharp_line(records: Records, residual: Array, *, above: float) -> float | None:
    """Frequency [Hz] of the sharpest line above a frequency over all runs, None where none stands out."""
    _, grid, _, every = _spectrum(residual, records)
    height = np.where(grid > above, every, 0.0)
    k = int(np.argmax(height))
    return float(grid[k]) if height[k] > _LINE else None


def _height(records: Records, total: Array) -> Array:
    """How far lines stand out from the median around, and from what is just beside, on the skirts of a swing.

    Zero where a spectrum stands out too little from what is beside to be a line.
    """
    aside = round(_BESIDE * _FINE * float(np.max(records.time)) / float(records.time[records.bounds[1:] - 1].min()))
    wide = np.pad(total, aside, mode="edge")
    beside = np.maximum(np.maximum(wide[: total.size], wide[2 * aside :]), np.finfo(float).tiny)
    lines = np.flatnonzero(total > _LINE * beside)
    around = np.pad(total, _FINE * _AROUND, mode="edge")
    median = np.median(np.lib.stride_tricks.sliding_window_view(around, 2 * _FINE * _AROUND + 1)[lines], axis=1)
    out: Array = np.zeros_like(total)
    out[lines] = total[lines] / np.maximum(median, beside[lines])
    return out


@once
def _spectrum(residual: Array, records: Records) -> tuple[float, Array, Array, Array]:
    """Longest record [s], frequencies [Hz], sum of all runs' power there, and how far lines stand out in it."""
    duration = float(np.max(records.time))
    step = float(records.sample_time.min())
    grid: Array = np.fft.rfftfreq(_FINE * int(duration / step), step).astype(np.float64)
    total: Array = np.zeros_like(grid)
    for r in range(len(records.runs)):
        own, y = records.evenly(r, residual)
        n = _FINE * y.size
        power = np.abs(np.fft.rfft(y * np.hanning(y.size), n)) ** 2
        total += np.interp(grid, np.fft.rfftfreq(n, own), power)
    return duration, grid, total, _height(records, total)
