"""Whether the noise of the readings is white: a mixture of white and first-order colored noise, or 1/f."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array, Model, NonNegative, Positive
from stepid.core.noise import rms
from stepid.core.words import length
from stepid.fitting.noise_floor import noise_floor
from stepid.fitting.spectrum import strongest_period
from stepid.simulation.records import Records

_LONG, _HALF = 2.0, 1.0  # windows in strongest periods: that which is fitted, and that which must agree
_WIDTHS = (12, 16, 24, 32, 48, 64)  # samples that a window may have
_DEGREE = 5  # of the polynomial that is projected out
_SHARES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # of the variance that is colored
_CORRELATIONS = (0.2, 0.35, 0.5, 0.65, 0.75, 0.83, 0.89, 0.93, 0.96, 1.0)  # of successive samples; 1 stands for 1/f
_AMOUNTS = (0.0, 0.01, 0.1, 1.0, 10.0)  # smooth misfit over noise, of the variance
_EVIDENCE = 9.0  # in 2 ln L: white noise gave at most 3 in a hundred campaigns, where the motion is modeled
_EVIDENCE_BESIDE = 36.0  # the same beside a misfit of `_MISFIT` times the noise or more, which gave at most 33 in 450
_MISFIT = 3.0
_AGREES = 2.0  # the same that half the window must find for the same model
_SLOW = 12.0  # correlation times in a period: slower noise cannot be told from a misfit of the motion
_PLAINLY = 6.0  # in 2 ln L, by which a model must be better than a simpler or likelier one
_ODD = 3.3  # standard deviations by which one direction of 60 may be above the model; noise gave 2.9 in 60 campaigns
_BEHIND = 4.0  # the same beside a misfit, which a slower model may fit as well
_LOUDER = 1.12  # times the white floor that colored noise must reach to be told
_SLOWEST = 1000.0  # samples, longest correlation time of 1/f noise
_KINK = 4.0  # times the windows' usual energy, beyond which there is a kink in one
_ENOUGH = 3.0  # independent windows
_FEWEST = 100  # contrasts
_COUNTS = 2.5  # counts that a window must span
_DITHER = 0.4  # of the resolution: with less noise rounding errors are not white


class NoiseColor(Model):
    """Noise of the readings that is not white.

    Parameters
    ----------
    kind : "ar1" or "1/f"
        First-order autoregressive noise, or a spectrum that falls with the inverse of the frequency.
    correlation_time : float
        s; of 1/f noise that of the slowest part which the records can show.
    white, colored : float
        m, standard deviations of the two parts.
    effective_samples : float
        Samples of white noise that would tell as much of a mean.
    """

    kind: Literal["ar1", "1/f"]
    correlation_time: Positive
    white: NonNegative
    colored: Positive
    effective_samples: Positive

    @property
    def words(self) -> str:
        """The same in a sentence."""
        if self.kind == "1/f":
            return f"The noise of the readings is colored: {length(self.colored)} of it are 1/f noise, which wanders."
        return (
            f"The noise of the readings is colored: {length(self.colored)} of it are correlated over "
            f"{1e3 * self.correlation_time:.2g} ms."
        )


class _Shape(NamedTuple):
    """One model of the noise: share of the variance that is colored, correlation of successive samples (1: 1/f)."""

    share: float
    correlation: float


class _Found(NamedTuple):
    """A model of the noise, its gain over white noise in 2 ln L, its variance in m².

    Also how far it is from the data in standard deviations, and how far in 2 ln L behind the best of all models.
    """

    gain: float
    shape: _Shape
    variance: float
    odd: float
    behind: float


class _Windows(NamedTuple):
    """Mean product of the contrasts of windows, shape (d, d) [m²]; how many that are independent; their samples.

    Also what each model of the noise makes of them, shape (G,): its variance [m²] and −2 ln L.
    """

    product: Array
    number: float
    width: int
    scale: Array
    cost: Array


def colored_floor(
    records: Records, residual: Array | None = None, *, white: float | None = None
) -> tuple[float, NoiseColor | None]:
    """Noise floor with the colored part of the readings' noise, and its color.

    Parameters
    ----------
    records : Records
    residual : array, shape (S,), optional
        Unweighted residual of any fit, m: the better the fit, the more is seen of slow noise. The readings themselves
        where it is not given.
    white : float, optional
        m, noise floor of the readings, where known.

    Returns
    -------
    tuple
        Floor, m; and the color, None for white noise: then the floor is that of `noise_floor`.

    Notes
    -----
    Polynomials are projected out of short windows, and the covariance of what remains is fitted by (restricted) maximum
    likelihood as white noise plus first-order noise, or 1/f noise, beside a smooth misfit (force jumps or velocity
    jumps at random times, whose spectra fall with the sixth and fourth power of the frequency, those of noise with the
    second at most). Patterson & Thompson, Biometrika 58 (1971) 545.
    """
    floor = noise_floor(records) if white is None else white
    values = records.position if residual is None else residual
    period = strongest_period(records)
    half = _windows(records, values, floor, _HALF * period)
    if half is None or _best(half, 1.0).gain < _AGREES:
        return floor, None
    slowest = max(math.exp(-_SLOW * float(np.median(records.sample_time)) / period), _CORRELATIONS[0])
    long = _windows(records, values, floor, _LONG * period)
    found = _best(long if long is not None and long.number >= _ENOUGH else half, slowest)
    again = _best(half, slowest, found.shape)
    if again.gain < _AGREES or max(found.odd, again.odd) > _ODD:
        return floor, None
    misfit = math.sqrt(float(np.mean(records.centered(values) ** 2)))
    beside = misfit > _MISFIT * math.sqrt(found.variance)
    if found.gain < (_EVIDENCE_BESIDE if beside else _EVIDENCE) or (beside and found.behind > _BEHIND):
        return floor, None
    total = math.sqrt(found.variance)
    if total < _LOUDER * floor:
        return floor, None
    if residual is not None:
        total = max(floor, min(total, rms(records.weighted(residual))))
    return total, _color(records, found.shape, total)


def _color(records: Records, shape: _Shape, total: float) -> NoiseColor:
    step = float(np.median(records.sample_time))
    lengths = np.diff(records.bounds)
    effective = 0.0
    for n in lengths:
        lag = np.arange(1.0, n)
        together = float(np.sum(_correlation(lag, shape.correlation) * (1 - lag / n)))
        effective += float(n) / (1 + 2 * shape.share * together)
    slow = shape.correlation == 1.0
    return NoiseColor(
        kind="1/f" if slow else "ar1",
        correlation_time=_SLOWEST * step if slow else -step / math.log(shape.correlation),
        white=total * math.sqrt(1 - shape.share),
        colored=total * math.sqrt(shape.share),
        effective_samples=effective,
    )


def _windows(records: Records, values: Array, floor: float, length: float) -> _Windows | None:
    """Contrasts of windows, half over half, in which the reading moves and the input does not jump; no kinks."""
    most = length / float(np.median(records.sample_time))
    width = max([w for w in _WIDTHS if w <= most] or [_WIDTHS[0]])
    basis = _contrasts(width)
    found = []
    for run, piece, begin in zip(records.runs, records.pieces(), records.begin, strict=True):
        y = records.position[piece]
        if y.size < width:
            continue
        quiet = (run.resolution or 0.0) * (width if floor < _DITHER * (run.resolution or 0.0) else _COUNTS)
        use = np.ptp(_cut(y, width), axis=1) > quiet
        jumps = np.diff(run.input[int(begin) :], prepend=run.input[int(begin)]) != 0
        if jumps.mean() < 0.05:
            use &= ~_cut(jumps, width)[:, 1:].any(axis=1)
        use &= np.mean(_cut(records.weight[piece], width) > 0.1, axis=1) > 0.8
        found.append(_cut(values[piece], width)[use] @ basis)
    z = np.concatenate(found) if found else np.empty((0, basis.shape[1]))
    if z.size < 2 * _FEWEST:
        return None
    energy = np.sum(z**2, axis=1)
    z = z[energy <= _KINK * np.median(energy)]
    product, number = z.T @ z / z.shape[0], 0.5 * z.shape[0]
    _, inverse, logs = _covariances(width)
    d = len(product)
    both = product + np.tril(product, -1)  # of symmetric matrices one half tells all
    scale = inverse @ both[np.tril_indices(d)] / d  # traces of products
    return _Windows(product, number, width, scale, number * (d * np.log(scale) + logs))


def _cut(values: npt.NDArray[Any], width: int) -> npt.NDArray[Any]:
    return np.lib.stride_tricks.sliding_window_view(values, width)[:: width // 2]


@cache
def _contrasts(width: int) -> Array:
    """Orthonormal basis of what polynomials leave, shape (w, d)."""
    full = np.linalg.qr(np.vander(np.linspace(-1, 1, width), _DEGREE + 1), mode="complete")[0]
    out: Array = full[:, _DEGREE + 1 :]
    return out


def _correlation(lag: Array, correlation: float) -> Array:
    """Correlation over a lag in samples: of first-order noise, or of 1/f noise as a sum of such of many times."""
    if correlation < 1.0:
        return np.asarray(correlation**lag)
    out: Array = np.mean([np.exp(-lag / t) for t in np.geomspace(0.5, _SLOWEST, 12)], axis=0)
    return out


@cache
def _covariances(width: int) -> tuple[tuple[_Shape, ...], Array, Array]:
    """All models of the noise, their covariances' inverses (G, d (d + 1) / 2) and logarithms of determinants (G,)."""
    basis = _contrasts(width)
    d = basis.shape[1]
    lag = np.abs(np.subtract.outer(np.arange(width), np.arange(width))).astype(float)
    colors = {rho: basis.T @ _correlation(lag, rho) @ basis for rho in _CORRELATIONS}
    smooths = []
    walk = np.cumsum(np.eye(width), axis=0)
    for _ in range(2):  # velocity jumps, force jumps
        walk = np.cumsum(walk, axis=0)
        k = basis.T @ walk @ walk.T @ basis
        smooths.append(k / np.trace(k) * d)
    shapes, out = [], []
    for share in _SHARES:
        for rho in _CORRELATIONS if share else _CORRELATIONS[:1]:
            noise = (1 - share) * np.eye(d) + share * colors[rho]
            for order, smooth in enumerate(smooths):
                for amount in _AMOUNTS[min(order, 1) :]:
                    shapes.append(_Shape(share, rho))
                    out.append(noise + amount * np.trace(noise) / d * smooth)
    stack = np.array(out)
    lower = np.linalg.inv(stack)[:, *np.tril_indices(d)]
    return tuple(shapes), lower, np.linalg.slogdet(stack)[1]


@cache
def _places(width: int) -> Array:
    """Shares and correlations of all models, shape (2, G)."""
    return np.array(_covariances(width)[0]).T


@cache
def _directions(width: int, shape: int) -> tuple[Array, Array]:
    """Eigenvalues and eigenvectors of the inverse covariance of a model, by its place among all."""
    d = _contrasts(width).shape[1]
    inverse = np.zeros((d, d))
    inverse[np.tril_indices(d)] = _covariances(width)[1][shape]
    values, vectors = np.linalg.eigh(inverse)  # of the lower half
    return values, vectors


def _oddest(windows: _Windows, shape: int, scale: float) -> float:
    """Standard deviations by which the strongest of all directions is above a model: a line in time is, noise is not.

    By the cube root of χ² over its freedom (Wilson & Hilferty 1931).
    """
    values, vectors = _directions(windows.width, shape)
    share = values / scale * np.sum(vectors * (windows.product @ vectors), axis=0)
    error = 2.0 / (9.0 * windows.number)
    return float((np.cbrt(share.max()) - 1 + error) / math.sqrt(error))


def _best(windows: _Windows, slowest: float, only: _Shape | None = None) -> _Found:
    """Best model of the noise, or the given one, beside a smooth misfit, and its gain over white noise.

    What is slower than correlation `slowest` is a misfit: where it is plainly better there is no gain.
    """
    shapes = _covariances(windows.width)[0]
    scale, cost = windows.scale, windows.cost
    share, correlation = _places(windows.width)
    white = share == 0
    fast = correlation <= slowest
    if only is not None:
        asked = np.array([s == only for s in shapes])
    elif cost[correlation == 1].min() < cost[fast].min() - _PLAINLY:
        asked = correlation == 1
    else:
        asked = fast
    best = int(np.argmin(np.where(asked, cost, np.inf)))
    odd = _oddest(windows, best, float(scale[best]))
    gain = float(cost[white].min() - cost[best])
    better = float(cost[best] - cost.min())
    return _Found(gain if only is not None or better < _PLAINLY else 0.0, shapes[best], float(scale[best]), odd, better)
