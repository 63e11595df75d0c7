"""What the best linear response of each run alone leaves of it: noise, or a law that the method does not know."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.hand import release_index
from stepid.core.input_levels import levelled
from stepid.core.noise import noise_level
from stepid.core.samples import means_of_blocks
from stepid.core.words import length
from stepid.identification.free_response import is_free_response

_MORE = 1.2  # times the noise, beyond which more than noise is left
_SLOW = 6.0  # standard deviations by which means over a tenth of a period exceed those of noise
_ROUNDS = 8  # Gauss–Newton steps
_STEP = 1e-6  # relative, of a forward difference
_SETTLED = 1e-7  # relative change at the end
_STILL = 0.3  # of the noise, a swing that no longer counts
_ENOUGH = 6  # means that say how noise averages out
_COUNTS = 0.6  # of the resolution, noise below which the errors of rounding are no noise
_FINE = 2000  # samples a period, beyond which means of neighbors tell the rates as well
_EXACT = 1e-9  # of the motion: no reading is finer
_FEW = 8  # changes of the input, beyond which convolving is cheaper than adding up their responses


class Remainder(NamedTuple):
    """What a linear response leaves of one run.

    Parameters
    ----------
    square, noise : float
        m², sum of squares that is left, and that noise would leave.
    means : float
        Sum of squares of the means over a tenth of a period, over what noise would leave; 0 where rounding hides it.
    samples, blocks : int
        How many of each, less what was fitted.
    """

    square: float
    noise: float
    means: float
    samples: int
    blocks: int


class _Samples(NamedTuple):
    """What is fitted, and what moves it: the input's changes, and when; None of a release."""

    time: Array
    position: Array
    changes: Array | None
    when: Array

    def thinned(self, width: int) -> _Samples:
        """Means of neighbors, at their middle; the changes stay where they are."""
        return self._replace(time=means_of_blocks(self.time, width), position=means_of_blocks(self.position, width))


def remainder(run: Experiment, *, damped_frequency: float, damping_ratio: float) -> Remainder | None:
    """Fit a linear second-order response to one run: frequency, decay, gain, rest, and of a release its start.

    Parameters
    ----------
    run : Experiment
    damped_frequency, damping_ratio : float
        rad/s and –, where to start.

    Returns
    -------
    Remainder or None
        None where the input is not held between its samples, or the fit does not settle.
    """
    if run.input_between != "held" or not 0 < damping_ratio < 1:
        return None
    run = levelled(run)
    first = release_index(run) if is_free_response(run) else 0
    time, y = run.time[first:] - run.time[first], run.position[first:]
    decay = damped_frequency * damping_ratio / math.sqrt(1 - damping_ratio**2)
    rates, residual, fitted = _fitted(_samples(run, time, y), np.array([decay, damped_frequency]))
    grid = run.resolution or 0.0
    noise = max(noise_level(residual, resolution=grid), _EXACT * float(np.ptp(y)))
    period = 2 * math.pi / rates[1]
    width = max(2, round(0.1 * period / run.sample_time))
    last = np.flatnonzero(np.diff(run.input[first:]))
    begin = int(last[-1]) + 1 if last.size else 0
    swing = np.exp(-rates[0] * (time - time[begin])) * np.ptp(fitted)
    tail = residual[(np.arange(y.size) > begin) & (swing < _STILL * noise)]
    usual = noise**2 / width
    if tail.size >= _ENOUGH * width:  # at rest one sees how noise averages out, whatever its color
        still = means_of_blocks(tail - tail.mean(), width)
        usual = max(usual, float(np.sum(still**2)) / (still.size - 1))
        noise = max(noise, float(np.std(tail)))
    means = means_of_blocks(residual, width)
    hidden = grid > 0 and noise < _COUNTS * grid
    count = 0 if hidden else max(means.size - 2, 0)
    lost = 5 if is_free_response(run) else 4
    return Remainder(
        square=float(residual @ residual),
        noise=noise**2 * (y.size - lost),
        means=float(np.sum(means**2)) / usual * (count > 0),
        samples=y.size - lost,
        blocks=count,
    )


def _samples(run: Experiment, time: Array, y: Array) -> _Samples:
    change = np.diff(run.input, prepend=run.input_before)
    return _Samples(time, y, None, time[:0]) if is_free_response(run) else _Samples(time, y, change, time[change != 0])


def _fitted(samples: _Samples, rates: Array) -> tuple[Array, Array, Array]:
    """Decay rate and frequency [1/s, rad/s], residual and response [m]; what is linear is projected out."""
    width = int(2 * math.pi / rates[1] / (samples.time[1] - samples.time[0]) / _FINE)
    if width > 1 and samples.when.size <= _FEW:
        rates = _settled(samples.thinned(width), rates)[0]
        return rates, *_projected(samples, rates)
    return _settled(samples, rates)


def _settled(samples: _Samples, rates: Array) -> tuple[Array, Array, Array]:
    """The rates of least squares by Gauss–Newton steps, with residual and response."""
    residual, response = _projected(samples, rates)
    for _ in range(_ROUNDS):
        slope = np.empty((residual.size, 2))
        for i in range(2):
            there = rates.copy()
            there[i] += _STEP * rates[1]
            slope[:, i] = (_projected(samples, there)[0] - residual) / (_STEP * rates[1])
        step = -np.linalg.lstsq(slope, residual, rcond=None)[0]
        length = 1.0
        while length > 1e-3:
            there = rates + length * step
            if there[0] > 0 and there[1] > 0:
                ahead = _projected(samples, there)
                if ahead[0] @ ahead[0] <= residual @ residual:
                    break
            length /= 2
        else:
            return rates, residual, response
        rates, (residual, response) = there, ahead
        if np.abs(length * step).max() < _SETTLED * rates[1]:
            return rates, residual, response
    return rates, residual, response


def _projected(samples: _Samples, rates: Array) -> tuple[Array, Array]:
    """Residual and response with decay rate and frequency given: rest, gain or start by linear least squares."""
    decay, frequency = rates
    time, y, changes, when = samples
    basis = [np.ones(time.size)]

    def swings(since: Array) -> tuple[Array, Array]:
        shrink = np.exp(-decay * since)
        return shrink * np.cos(frequency * since), shrink * np.sin(frequency * since)

    def answer(since: Array) -> Array:
        cosine, sine = swings(since)
        out: Array = 1.0 - cosine - decay / frequency * sine
        return out

    if changes is None:
        basis += swings(time)
    elif when.size <= _FEW:
        moved = np.zeros(time.size)
        for at, change in zip(when.tolist(), changes[changes != 0].tolist(), strict=True):
            first = int(np.searchsorted(time, at))
            moved[first:] += change * answer(time[first:] - at)
        basis.append(moved)
    else:
        size = 2 * time.size
        basis.append(np.fft.irfft(np.fft.rfft(changes, size) * np.fft.rfft(answer(time), size), size)[: time.size])
    matrix = np.stack(basis, axis=1)
    response = matrix @ np.linalg.lstsq(matrix, y, rcond=None)[0]
    return y - response, response


def warning(found: Iterable[Remainder | None]) -> str | None:
    """Say in one sentence that more than noise is left of the runs together; None where it is noise.

    Parameters
    ----------
    found : iterable of Remainder or None
    """
    known = [r for r in found if r is not None]
    if not known:
        return None
    samples, blocks = sum(r.samples for r in known), sum(r.blocks for r in known)
    left = math.sqrt(sum(r.square for r in known) / samples)
    noise = math.sqrt(sum(r.noise for r in known) / samples)
    slow = (sum(r.means for r in known) - blocks) / math.sqrt(2.0 * max(blocks, 1))
    if left <= _MORE * noise and slow <= _SLOW:
        return None
    return (
        f"The best linear response of each run leaves {length(left)}, and the noise is {length(noise)}: the "
        "uncertainties hold for a linear plant, and the true values may lie far outside of them; a diagnosis "
        "(stepid.diagnose) looks for the cause."
    )
