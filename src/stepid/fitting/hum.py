"""A hum on the readings: a line in time that all runs show alike, which no force on the cart makes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.words import length
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.record_fault import ALL_RUNS, RecordFault
from stepid.fitting.spectrum import sharp_line
from stepid.simulation.clock import clock
from stepid.simulation.records import Records

_ABOVE = 3.0  # times the plant's own frequency: below, its own motion is too strong
_FAR = 8.0  # times it, above which a force would have to be huge: `periodic_disturbance` is looked for below
_MOST = 3  # lines
_PARTS = 3  # of a run, in which the line must be the same
_CLEAR = 4.0  # times what is beside it
_SCATTER = 3.0  # the same, for differences between runs and parts
_ALIKE = 0.25  # share of its amplitude by which parts and runs may differ anyway
_MODEL = 0.05  # share of an amplitude to which a force's answer is known
_BETTER = 6.0  # by which χ² of equal amplitudes must be below that of equal forces
_MAINS = (50.0, 60.0)  # Hz
_BESIDE = (-6.0, -5.0, -4.0, -3.0, 3.0, 4.0, 5.0, 6.0)  # of the reciprocal length: where the background is read


class Hum(NamedTuple):
    """One line: its frequency in Hz, its complex amplitude in each run (R,) in m, and its fault in words."""

    frequency: float
    amplitude: Array
    fault: RecordFault


def find_hum(records: Records, linear: Optimum) -> tuple[Hum, ...]:
    """Find lines on the readings, the strongest first, in what the linear plant leaves.

    Parameters
    ----------
    records : Records
    linear : Optimum
        Fit of the linear plant to them.

    Returns
    -------
    tuple of Hum

    Notes
    -----
    A hum has the same amplitude whatever the mass, a force's answer does not; it is there from a run's beginning to its
    end, what a blow sets ringing is not; and it is far above the plant's own frequency.
    """
    residual = linear.residual
    own = _own_frequency(linear)
    found: list[Hum] = []
    while len(found) < _MOST:
        start = sharp_line(records, residual, above=_ABOVE * own)
        if start is None:
            break
        hum = _hum(records, linear, residual, start, own)
        if hum is None:
            break
        found.append(hum)
        residual = residual - np.real(hum.amplitude[records.run] * np.exp(2j * np.pi * hum.frequency * records.time))
    return tuple(found)


def without_hum(campaign: Campaign, hums: tuple[Hum, ...]) -> Campaign:
    """Subtract lines from the readings of a campaign whose runs are those in which they were found."""
    runs = []
    for i, run in enumerate(campaign.experiments):
        since = clock(run) - clock(run)[0]
        turns = np.exp([2j * np.pi * hum.frequency * since for hum in hums])
        lines = sum(np.real(hum.amplitude[i] * turn) for hum, turn in zip(hums, turns, strict=True))
        position = run.position - lines
        position.setflags(write=False)
        runs.append(run.model_copy(update={"position": position}))
    return campaign.model_copy(update={"experiments": tuple(runs)})


def _constants(linear: Optimum) -> tuple[Array, Array, Array]:
    """Mass, stiffness and damping of each run."""
    of, records, shared = linear.problem.layout, linear.problem.records, linear.shared
    return of.mass(shared), shared[of.stiffness][records.spring], shared[of.damping][records.damper]


def _own_frequency(linear: Optimum) -> float:
    mass, stiffness, _ = _constants(linear)
    return float(np.sqrt(np.max(stiffness / mass))) / (2 * np.pi)


def _amplitudes(time: Array, values: Array, frequencies: Array) -> Array:
    """Complex amplitudes of lines, by a Hann window that keeps neighbors apart."""
    window = np.hanning(time.size + 2)[1:-1]
    out: Array = 2 * np.exp(-2j * np.pi * np.outer(frequencies, time)) @ (window * values) / window.sum()
    return out


def _of_mains(records: Records, frequency: float, reach: float) -> str:
    """Say which mains hum samples this far apart show at a frequency [Hz], within `reach` [Hz]; '' where none."""
    steps = records.sample_time
    if float(np.ptp(steps)) > 0:
        return ""
    rate = 1 / float(steps[0])
    alias = {mains: abs(mains - rate * round(mains / rate)) for mains in _MAINS if mains > rate / 2}
    told = [f"{mains:g}" for mains, seen in alias.items() if abs(seen - frequency) < reach]
    return f" (or {told[0]} Hz, which {rate:.4g} samples a second show there)" if told else ""


def _hum(records: Records, linear: Optimum, residual: Array, start: float, own: float) -> Hum | None:
    pieces = records.pieces()
    longest = max(float(np.ptp(records.time[p])) for p in pieces)

    reach = 1.0 / longest

    def power(frequency: float) -> float:
        lines = [_amplitudes(records.time[p], residual[p], np.array([frequency]))[0] for p in pieces]
        return -float(np.sum(np.abs(lines) ** 2 * np.diff(records.bounds)))

    bounds = (start - reach, start + reach)
    from scipy.optimize import minimize_scalar  # slow to import, seldom needed

    best = minimize_scalar(power, bounds=bounds, method="bounded", options={"xatol": 1e-3 * reach})
    frequency = float(best.x)
    highest = 0.5 / float(records.sample_time.max()) - 3.0 / longest
    if not _ABOVE * own < frequency < highest:
        return None
    lines, background = [], []
    for p in pieces:
        line, beside, steady = _line(records.time[p], residual[p], frequency)
        if not steady:
            return None
        lines.append(line)
        background.append(beside)
    amplitude, spread = np.array(lines), np.array(background)
    if not _is_hum(np.abs(amplitude), spread, _answers(linear, frequency), frequency > _FAR * own):
        return None
    size = float(np.mean(np.abs(amplitude)))
    words = (
        f"All runs: a hum of {length(size)} at {frequency:.4g} Hz{_of_mains(records, frequency, reach)} lies on the "
        "readings, the same whatever the mass; "
        "it is subtracted. Check the shielding of the sensor's cable, and what the sensor stands on."
    )
    return Hum(frequency, amplitude, RecordFault(run=ALL_RUNS, kind="hum", size=size, unit="m", words=words))


def _line(time: Array, values: Array, frequency: float) -> tuple[complex, float, bool]:
    """Amplitude of a line in one run, the background beside it, and whether it is the same in all parts of the run."""
    line, beside = _with_background(time, values, frequency)
    steady = True
    for part in np.array_split(np.arange(time.size), _PARTS):
        own, around = _with_background(time[part], values[part], frequency)
        steady &= abs(own - line) <= _ALIKE * abs(line) + _SCATTER * around
    return line, beside, steady


def _with_background(time: Array, values: Array, frequency: float) -> tuple[complex, float]:
    near = frequency + np.array((0.0, *_BESIDE)) / float(np.ptp(time))
    found = _amplitudes(time, values, near)
    return complex(found[0]), float(np.sqrt(np.mean(np.abs(found[1:]) ** 2)))


def _answers(linear: Optimum, frequency: float) -> Array:
    """What a force of 1 N at a frequency moves in each run, m."""
    mass, stiffness, damping = _constants(linear)
    w = 2 * np.pi * frequency
    out: Array = 1.0 / np.abs(stiffness - mass * w**2 + 1j * w * damping)
    return out


def _is_hum(size: Array, spread: Array, answers: Array, far: bool) -> bool:
    """Tell whether all runs show one amplitude, and not answers to one force."""
    mean = float(np.average(size, weights=1 / spread**2))
    if mean < _CLEAR * float(np.median(spread)) or np.any(np.abs(size - mean) > _ALIKE * mean + _SCATTER * spread):
        return False
    error = np.hypot(spread, _MODEL * size)
    alike = float(np.sum(((size - mean) / error) ** 2))
    force = float(np.sum(size * answers / error**2) / np.sum((answers / error) ** 2))
    forced = float(np.sum(((size - force * answers) / error) ** 2))
    return alike < forced - _BETTER or (far and float(np.ptp(answers)) < _MODEL * float(answers.mean()))
