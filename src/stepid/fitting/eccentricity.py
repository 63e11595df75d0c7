"""An encoder that sits off its axis: a line in position on the readings of all runs."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.noise import reading_step
from stepid.core.samples import multiples
from stepid.core.words import length
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.noise_floor import repeats
from stepid.fitting.record_fault import ALL_RUNS, RecordFault
from stepid.simulation.records import Records

_TURNS = (1.0, 100.0)  # of the encoder within the travel, that can be told
_AGAIN = 2.0  # turns, below which runs have to move differently: in one motion any law of position looks so
_FINE = 0.25  # turns, by which pitches are told apart
_STEPS = 12  # Newton's, by which a reading is corrected
_LEAST_SLOPE = 0.2  # of the reading over the position, in these: where it hardly grows a step would go too far
_EVIDENCE = 50.0  # n ln(RSS / RSS) of the line
_MOST = 0.7  # share of what is left above the noise that the line must take
_TRACKS, _A_STEP = (2, 4), 0.05  # steps after which one track of a counter, or two, come again; how near to whole ones
_SAME = 1e-12  # of the product of two squares, by which sine and cosine differ at least
_ALIKE = 0.3  # of the amplitude, by which runs may differ
_SCATTER = 4.0  # standard deviations, the same


class Eccentricity(NamedTuple):
    """The reading is off by ``amplitude·sin(2π·position/pitch + phase)``, m, m and rad; and its fault in words."""

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
    problem, records = fit.problem, fit.problem.records
    residual, size = problem.residual(fit.solved), records.weighed_size
    excess = float(residual @ residual) - floor**2 * size
    line = _Line(problem.jacobian(fit.solved), residual, records, records.position - fit.residual)
    if excess <= 0 or line.travel <= 0 or not line.finite:
        return None
    turns = line.strongest()
    waves = line.waves(turns)
    values, gained = _fitted(waves, residual)
    if turns < _TURNS[0] + _FINE / 2:  # the longest that is tried: no pitch is the best
        return None
    if turns < _AGAIN and _move_alike(records):
        return None
    pitch = line.travel / turns
    amplitude, phase = _wave(values)
    if 2 * np.pi * amplitude >= pitch:  # such a reading would turn back while the cart goes on
        return None
    left = float(residual @ residual) - gained
    evidence = size * np.log((left + gained) / max(left, 1e-30))
    if evidence < _EVIDENCE or gained < _MOST * excess:
        return None
    noise = np.sqrt(left / size)
    for piece in records.pieces():
        own, _ = _fitted(waves[:, piece], residual[piece])
        error = noise * np.sqrt(2.0 / max(float(np.sum(waves[:, piece] ** 2)) / 2, 1e-30))
        if np.hypot(*(own - values)) > _ALIKE * amplitude + _SCATTER * error:
            return None
    words = (
        f"All runs: the readings are off by {length(amplitude)} in turn every {length(pitch)} of travel, "
        f"whatever the mass and speed: {_cause(pitch, records)}."
    )
    fault = RecordFault(run=ALL_RUNS, kind="encoder eccentricity", size=amplitude, unit="m", words=words)
    return Eccentricity(amplitude, pitch, phase, fault)


def _move_alike(records: Records) -> bool:
    """Tell whether all runs repeat one motion, or are parts of one: a plant that is left alone has only one."""
    repeated = any(len(group) == len(records.runs) for group in repeats(records))
    plants = {*zip(records.base, records.added_mass, records.spring, records.damper, strict=True)}
    return repeated or not (records.driven.any() or len(plants) > 1)


def _cause(pitch: float, records: Records) -> str:
    """What makes a line of a pitch [m], by the steps of the readings."""
    steps = pitch / max(float(np.median([reading_step(run) for run in records.runs])), 1e-30)
    for few in _TRACKS:
        if abs(steps - few) < _A_STEP:
            return f"that is every {few} steps of the counter, which are unequal"
    return "an encoder or a pulley that sits off its axis"


def _wave(values: Array) -> tuple[float, float]:
    """Amplitude and phase of a sine, by its shares of sine and cosine."""
    return float(np.hypot(*values)), float(np.arctan2(values[1], values[0]))


def _true(reading: Array, amplitude: float, phase: float, pitch: float) -> Array:
    """The positions of which a line is on the readings, by Newton's steps: the reading grows with the position."""
    position, turn = reading, 2 * np.pi / pitch
    for _ in range(_STEPS):
        angle = turn * position + phase
        off = position + amplitude * np.sin(angle) - reading
        position = position - off / np.maximum(1 + turn * amplitude * np.cos(angle), _LEAST_SLOPE)
    return position


def without_eccentricity(campaign: Campaign, found: Eccentricity) -> Campaign:
    """Subtract an encoder's line from the readings of a campaign."""
    runs = []
    for run in campaign.experiments:
        position = _true(run.position, found.amplitude, found.phase, found.pitch)
        position.setflags(write=False)
        runs.append(run.model_copy(update={"position": position}))
    return campaign.model_copy(update={"experiments": tuple(runs)})


class _Line:
    """Waves in position, less what the fit's own parameters can take of them: these have taken it of the residual.

    The position is the model's: in the readings' own is the noise that is to be explained.
    """

    def __init__(self, jacobian: Array, residual: Array, records: Records, position: Array) -> None:
        size = np.linalg.norm(jacobian, axis=0)
        self.finite = bool(np.isfinite(size).all())
        self._own = np.linalg.qr(jacobian[:, size > 0] / size[size > 0])[0] if self.finite else jacobian
        self._residual, self._records = residual, records
        self.travel = float(np.ptp(position))
        self.position = position

    @cached_property
    def _rest(self) -> Array:
        """What the fit's own parameters cannot take of the residual."""
        return self._residual - self._own @ (self._own.T @ self._residual)

    def waves(self, turns: float) -> Array:
        """Sine and cosine of so many turns within the travel, shape (2, S)."""
        both = self._whole(np.exp(1j * turns * self._angle))
        out: Array = both - (both @ self._own) @ self._own.T
        return out

    @property
    def _angle(self) -> Array:
        """Of one turn within the travel, rad."""
        return 2 * np.pi * self.position / self.travel

    def _whole(self, wave: Array) -> Array:
        """Weighted sine and cosine with all that the fit's own parameters can take of them, shape (2, S)."""
        return self._records.weighted(np.array([wave.imag, wave.real]))

    def strongest(self) -> float:
        """Turns of the line that takes most of the residual."""
        first = self._strongest_of_all()
        from scipy.optimize import minimize_scalar  # slow to import, seldom needed

        angle = self._angle
        ends = (max(first - _FINE, _TURNS[0]), min(first + _FINE, _TURNS[1]))
        found = minimize_scalar(
            lambda turns: -self._gain(np.exp(1j * turns * angle)), bounds=ends, options={"xatol": 1e-4}
        )
        return float(found.x)

    def _strongest_of_all(self) -> float:
        least, most = (round(turns / _FINE) for turns in _TURNS)
        gains = [self._gain(wave) for wave in multiples(_FINE * self._angle, least, most)]
        return _FINE * (least + int(np.argmax(gains)))

    def _gain(self, wave: Array) -> float:
        """What sine and cosine take of the residual, by their normal equations, m²."""
        waves = self._whole(wave)
        (y, z), taken = waves @ self._rest, waves @ self._own
        (a, b), (_, d) = waves @ waves.T - taken @ taken.T
        product, determinant = max(a * d, 1e-300), a * d - b * b
        if determinant <= _SAME * product:  # one wave is no line
            return 0.0
        return float((d * y * y - 2 * b * y * z + a * z * z) / determinant)


def _fitted(waves: Array, residual: Array) -> tuple[Array, float]:
    values: Array = np.asarray(np.linalg.lstsq(waves.T, residual, rcond=None)[0], dtype=np.float64)
    return values, float(values @ (waves @ residual))
