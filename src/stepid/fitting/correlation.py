"""How a residual is correlated in time, and what that makes of the variance of what is fitted to it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array, Index
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.spectrum import fast_length

_QUIET = 5  # lags in a row without correlation that end it (Politis 2003)
_SAME = 1e-3  # relative difference of sample times that are the same


class Block(NamedTuple):
    """One run's share of the Jacobian: rows (c, samples), and how each of its C columns follows from them, (C, c)."""

    piece: slice
    columns: Index
    rows: Array
    grown: Array


def autocorrelations(optimum: Optimum, residual: Array) -> list[Array]:
    """Autocorrelation of each run's residual at the lags that count, from lag 1 on, in samples.

    Runs of one sample time are taken together. It ends where it is lost in chance, at one swing at the latest, and
    fades over as many lags again: the flat-top window with its bandwidth from the data (Politis, "Adaptive bandwidth
    choice", J. Nonparametric Statistics 15, 2003). So it does not depend on how fast the samples follow one another.

    Parameters
    ----------
    optimum : Optimum
    residual : array, shape (S,)
        Weighted, m.
    """
    records = optimum.problem.records
    pieces, swing = records.pieces(), _swing(optimum)
    out = [np.zeros(0)] * len(pieces)
    left = set(range(len(pieces)))
    while left:
        first = min(left)
        time = records.sample_time[first]
        group = [r for r in sorted(left) if abs(records.sample_time[r] - time) < _SAME * time]
        own = _faded([residual[pieces[r]] for r in group], max(1, round(swing / float(time))))
        for r in group:
            out[r] = own
        left -= set(group)
    return out


def _swing(optimum: Optimum) -> float:
    """The longest period of a run, s."""
    of, shared = optimum.problem.layout, optimum.shared
    stiffness = np.maximum(shared[of.stiffness][optimum.problem.records.spring], 1e-12)
    return float(2 * np.pi * np.sqrt(np.max(np.maximum(of.mass(shared), 1e-12) / stiffness)))


def _faded(parts: list[Array], longest: int) -> Array:
    """Autocorrelation of some residuals together, from lag 1 on, under the flat-top window."""
    size = sum(y.size for y in parts)
    square = math.fsum(float(y @ y) for y in parts)
    lags = min(2 * longest, max(y.size for y in parts) // 2)
    if square <= 0 or lags < 1:
        return np.zeros(0)
    total = np.zeros(lags + 1)
    for y in parts:
        length = fast_length(y.size + lags)
        spectrum = np.fft.rfft(y, length)
        seen = np.fft.irfft(np.abs(spectrum) ** 2, length)[: lags + 1]
        total[: min(y.size, lags + 1)] += seen[: min(y.size, lags + 1)]
    correlation = total[1:] / square
    loud = np.abs(correlation) > 2 * math.sqrt(math.log10(max(size, 10)) / size)
    width = next((m for m in range(min(longest, lags)) if not loud[m : m + _QUIET].any()), min(longest, lags))
    kept = min(2 * width, lags)
    window = np.minimum(1.0, 2.0 * (1.0 - np.arange(1, kept + 1) / (kept + 1)))
    return correlation[:kept] * window


def inflation(blocks: Iterable[Block], correlations: list[Array], inverse: Array, share: Array) -> Array:
    """Variance of each direction's coefficient over that of white noise, at least 1.

    Parameters
    ----------
    blocks : iterable
        Of each run.
    correlations : list of array
        Of each run; see `autocorrelations`.
    inverse : array, shape (n, n)
        Its columns are the directions.
    share : array, shape (n,)
        What noise has in each direction's variance.
    """
    if not any(own.size for own in correlations):
        return np.ones(inverse.shape[1])
    products = np.zeros((len(inverse), len(inverse)))
    for (_, columns, rows, grown), own in zip(blocks, correlations, strict=True):
        n = rows.shape[1]
        if not own.size:
            continue
        kernel = np.zeros(fast_length(n + own.size))
        kernel[1 : own.size + 1] = own
        kernel[-own.size :] += own[::-1]
        spectra = np.fft.rfft(rows, kernel.size, axis=1) * np.fft.rfft(kernel)
        lagged = rows @ np.fft.irfft(spectra, kernel.size, axis=1)[:, :n].T
        products[np.ix_(columns, columns)] += grown @ lagged @ grown.T
    extra = np.sum(inverse * (products @ inverse), axis=0)
    out: Array = np.maximum(1.0 + extra / np.maximum(share, 1e-9), 1.0)
    return out


def disagreement(blocks: Iterable[Block], residual: Array, inverse: Array, share: Array, level: float) -> Array:
    """Variance of each direction's coefficient by what the runs say of it one by one, over that of white noise.

    The cluster-robust sandwich (Liang & Zeger, Biometrika 73, 1986), a run a cluster; at least 1.

    Parameters
    ----------
    blocks, inverse, share
        As in `inflation`.
    residual : array, shape (S,)
        Weighted, m.
    level : float
        m, of the noise.
    """
    pulls = []
    for piece, columns, rows, grown in blocks:
        pull = np.zeros(len(inverse))
        pull[columns] = grown @ (rows @ residual[piece])
        pulls.append(inverse.T @ pull / level)
    runs = len(pulls)
    if runs < 2:
        return np.ones(inverse.shape[1])
    found = np.sum(np.square(pulls), axis=0) * runs / (runs - 1)
    out: Array = np.maximum(found / np.maximum(share, 1e-9), 1.0)
    return out
