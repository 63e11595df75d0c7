"""An encoder that sits off its axis: a line in position on the readings of all runs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.record_fault import ALL_RUNS, RecordFault

_BINS = 2048  # of the travel
_PADDED = 4  # times as many for the transform
_TURNS = (2.0, 200.0)  # of the encoder within the travel, that can be told
_EVIDENCE = 50.0  # n ln(RSS / RSS) of the line
_MOST = 0.5  # share of what is left above the noise that the line must take
_ALIKE = 0.3  # of the amplitude, by which runs may differ
_SCATTER = 4.0  # standard deviations, the same


class Eccentricity(NamedTuple):
    """The reading is off by ``amplitude·sin(2π·reading/pitch + phase)``, m, m and rad; and its fault in words."""

    amplitude: float
    pitch: float
    phase: float
    fault: RecordFault


def find_eccentricity(fit: Optimum, floor: float) -> Eccentricity | None:
    """Find a line in position, the same in all runs, that takes most of what a fit leaves above the noise.

    Parameters
    ----------
    fit : Optimum
        Best fit so far.
    floor : float
        m.

    Returns
    -------
    Eccentricity or None
    """
    records = fit.problem.records
    residual = records.centered(records.position - fit.solved.reading)
    y, use = records.position, records.weight > 1e-3
    excess = float(np.sum(residual[use] ** 2)) - floor**2 * int(use.sum())
    if excess <= 0 or np.ptp(y) <= 0:
        return None
    pitch = _pitch(y[use], residual[use])
    if pitch is None:
        return None
    waves = records.centered(np.array([np.sin(2 * np.pi * y / pitch), np.cos(2 * np.pi * y / pitch)]))
    values, gained = _fitted(waves[:, use], residual[use])
    before = float(np.sum(residual[use] ** 2))
    evidence = use.sum() * np.log(before / max(before - gained, 1e-30))
    if evidence < _EVIDENCE or gained < _MOST * excess:
        return None
    amplitude, noise = float(np.hypot(*values)), np.sqrt((before - gained) / use.sum())
    for piece in records.pieces():
        own, _ = _fitted(waves[:, piece] * use[piece], residual[piece] * use[piece])
        error = noise * np.sqrt(2.0 / max(float(np.sum(waves[:, piece] ** 2)) / 2, 1e-30))
        if np.hypot(*(own - values)) > _ALIKE * amplitude + _SCATTER * error:
            return None
    words = (
        f"All runs: the readings are off by {1e6 * amplitude:.2g} µm in turn every {1e3 * pitch:.3g} mm of travel, "
        "whatever the mass and speed: an encoder or a pulley that sits off its axis."
    )
    fault = RecordFault(run=ALL_RUNS, kind="encoder eccentricity", size=amplitude, unit="m", words=words)
    return Eccentricity(amplitude, pitch, float(np.arctan2(values[1], values[0])), fault)


def without_eccentricity(campaign: Campaign, found: Eccentricity) -> Campaign:
    """Subtract an encoder's line from the readings of a campaign."""
    runs = []
    for run in campaign.experiments:
        turn = 2 * np.pi * run.position / found.pitch + found.phase
        position = run.position - found.amplitude * np.sin(turn)
        position.setflags(write=False)
        runs.append(run.model_copy(update={"position": position}))
    return campaign.model_copy(update={"experiments": tuple(runs)})


def _fitted(waves: Array, residual: Array) -> tuple[Array, float]:
    values: Array = np.asarray(np.linalg.lstsq(waves.T, residual, rcond=None)[0], dtype=np.float64)
    return values, float(values @ (waves @ residual))


def _pitch(y: Array, residual: Array) -> float | None:
    """Pitch [m] of the strongest line in position: of the sums over bins of the travel, then refined."""
    travel = float(np.ptp(y))
    place = np.minimum(((y - y.min()) / travel * _BINS).astype(int), _BINS - 1)
    sums = np.bincount(place, residual, _BINS)
    power = np.abs(np.fft.rfft(sums, _PADDED * _BINS)) ** 2
    turns = np.arange(power.size) / _PADDED
    usable = (turns > _TURNS[0]) & (turns < _TURNS[1])
    if not usable.any():
        return None
    first = float(turns[int(np.argmax(np.where(usable, power, 0.0)))])
    near = first + np.linspace(-0.5, 0.5, 41)
    gains = []
    for count in near:
        angle = 2 * np.pi * count * y / travel
        gains.append(_fitted(np.array([np.sin(angle), np.cos(angle)]), residual)[1])
    return travel / float(near[int(np.argmax(gains))])
