"""What a real sensor and a real recorder add to a reading: noise that is not white, wrong and missing samples."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter


def colored(n: int, period: float, time_constant: float, rng: np.random.Generator) -> np.ndarray:
    """AR(1) noise of unit RMS."""
    keep = float(np.exp(-period / time_constant))
    white = rng.standard_normal(n)
    white[1:] *= np.sqrt(1 - keep**2)
    return np.asarray(lfilter([1.0], [1.0, -keep], white))


def pink(n: int, rng: np.random.Generator) -> np.ndarray:
    """1/f noise of unit RMS, without a mean."""
    spectrum = rng.standard_normal(n // 2 + 1) + 1j * rng.standard_normal(n // 2 + 1)
    spectrum[0] = 0.0
    spectrum[1:] /= np.sqrt(np.arange(1, n // 2 + 1))
    noise = np.fft.irfft(spectrum, n)
    return np.asarray(noise / np.sqrt(np.mean(noise**2)))


def hum(n: int, period: float, frequency: float, phase: float) -> np.ndarray:
    """A line of unit amplitude, folded where the samples are too slow for it."""
    return np.asarray(np.sin(2 * np.pi * frequency * period * np.arange(n) + phase))


def wrong(n: int, share: float, low: float, high: float, rng: np.random.Generator) -> np.ndarray:
    """Isolated samples that are off by `low` to `high`, either way; at least one, and no two side by side."""
    off = np.zeros(n)
    for at in rng.choice(np.arange(1, n // 2 - 1), size=max(1, round(share * n)), replace=False):
        off[2 * at] = rng.choice([-1.0, 1.0]) * rng.uniform(low, high)
    return off


def lost(inputs: np.ndarray, share: float, longest: int, rng: np.random.Generator) -> np.ndarray:
    """Which samples never arrive: singles and bursts, at least one, none at the ends or where the input changes."""
    n = inputs.size
    keep = np.zeros(n, bool)
    keep[:3] = keep[-2:] = True
    changes = np.flatnonzero(np.diff(inputs)) + 1
    for shift in (-1, 0, 1):
        keep[np.clip(changes + shift, 0, n - 1)] = True
    gone = np.zeros(n, bool)
    wanted = max(1, round(share * n))
    for _ in range(50):
        if gone.sum() >= wanted:
            break
        begin = int(rng.integers(3, n - 2))
        gone[begin : begin + int(rng.integers(1, longest + 1))] = True
        gone &= ~keep
    return gone


def repeated(x: np.ndarray, gone: np.ndarray) -> np.ndarray:
    """The reading of a recorder that writes the last sample again where one is missing."""
    last = np.maximum.accumulate(np.where(gone, 0, np.arange(x.size)))
    return np.asarray(x[last])


def eccentric(x: np.ndarray, size: float, pitch: float, phase: float) -> np.ndarray:
    """Reading of an encoder wheel that is not centered on its shaft; right at x = 0."""
    return np.asarray(x + size * (np.sin(2 * np.pi * x / pitch + phase) - np.sin(phase)))


def late(x: np.ndarray, samples: float) -> np.ndarray:
    """A record that begins `samples` (0 or more) before the motion does: held at its first value until then."""
    at = np.arange(x.size) - samples
    return np.where(at < 0, x[0], CubicSpline(np.arange(x.size), x)(np.maximum(at, 0.0)))
