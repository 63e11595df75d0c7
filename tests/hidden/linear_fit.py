"""The best joint linear fit, by code of its own: exact held-input recursion, and what is linear eliminated.

Shared: base mass (a base label), stiffness (a spring label), damping (a damper label), one force gain. Per run: the
rest position and, for a free release, the initial state. Masses, stiffness and damping are searched; gain, rest
positions and initial states are eliminated exactly (variable projection).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg.lapack import dgeqrf
from scipy.optimize import least_squares

from .compiled import compiled

SMALL = float(np.sqrt(np.finfo(float).eps))  # step of the differences


@dataclass(frozen=True)
class LinearFit:
    base_mass: dict[str, float]
    stiffness: dict[str, float]
    damping: dict[str, float]
    force_gain: float
    rms: float
    residuals: tuple[np.ndarray, ...]


class _Records(NamedTuple):
    """All runs, one after the other; `where` has the places of their base, spring and damper among the values."""

    where: np.ndarray
    added: np.ndarray
    periods: np.ndarray
    free: np.ndarray
    cuts: np.ndarray
    forces: np.ndarray
    measured: np.ndarray


@compiled
def _waves(mass: float, stiffness: float, damping: float, t: float) -> tuple[float, float]:
    """Cosine, and sine over its rate, of a free swing at t; hyperbolic where it does not swing."""
    decay = damping / (2 * mass)
    square = stiffness / mass - decay**2
    rate = max(math.sqrt(abs(square)), 1e-12)
    fall = np.exp(-decay * t)
    if square < 0:
        return fall * np.cosh(rate * t), fall * np.sinh(rate * t) / rate
    return fall * math.cos(rate * t), fall * math.sin(rate * t) / rate


@compiled
def _respond(mass: float, stiffness: float, damping: float, force: np.ndarray, period: float, out: np.ndarray) -> None:
    cosine, sine = _waves(mass, stiffness, damping, period)
    first = (1 - cosine - damping / (2 * mass) * sine) / stiffness
    trace, determinant = 2 * cosine, np.exp(-damping / mass * period)
    second = (1 - trace + determinant) / stiffness - first
    x = before = push = 0.0
    for i in range(force.size):
        out[i] = x
        x, before = first * force[i] + second * push + trace * x - determinant * before, x
        push = force[i]


@compiled
def _release(mass: float, stiffness: float, damping: float, period: float, out: np.ndarray) -> None:
    for i in range(out.shape[1]):
        out[0, i], out[1, i] = _waves(mass, stiffness, damping, period * i)


def unit_response(mass: float, stiffness: float, damping: float, force: np.ndarray, period: float) -> np.ndarray:
    """Position from rest under a force held over each sample."""
    out = np.empty(force.size)
    _respond(float(mass), float(stiffness), float(damping), np.asarray(force, float), float(period), out)
    return out


def free_response(mass: float, stiffness: float, damping: float, size: int, period: float) -> np.ndarray:
    """What an initial position, and an initial speed, become; a column for each."""
    out = np.empty((2, size))
    _release(float(mass), float(stiffness), float(damping), float(period), out)
    return out.T


@compiled
def _without(left: np.ndarray, one: np.ndarray) -> float:
    """Take from `left` what one column can move; how much that was."""
    product, power = 0.0, 0.0
    for i in range(one.size):
        product += one[i] * left[i]
        power += one[i] * one[i]
    share = product / power if power > 0 else 0.0
    for i in range(one.size):
        left[i] -= share * one[i]
    return share


@compiled
def _left_over(values: np.ndarray, r: _Records, left: np.ndarray) -> float:
    """The best gain; what it leaves of all readings is written to `left`."""
    driven, constant = np.zeros(left.size), np.ones(left.size)
    for j in range(left.size):
        left[j] = r.measured[j]
    for i in range(r.added.size):
        low, high = r.cuts[i], r.cuts[i + 1]
        m, k, c = values[r.where[0, i]] + r.added[i], values[r.where[1, i]], values[r.where[2, i]]
        if r.free[i]:
            columns = np.ones((3, high - low))
            _release(m, k, c, r.periods[i], columns[1:])
            for one in range(3):
                for other in range(2 * one):  # once more for what rounding leaves
                    _without(columns[one], columns[other % one])
                _without(left[low:high], columns[one])
            continue
        _respond(m, k, c, r.forces[low:high], r.periods[i], driven[low:high])
        _without(left[low:high], constant[low:high])
        _without(driven[low:high], constant[low:high])
    return _without(left, driven)


@compiled
def _table(values: np.ndarray, held: int, r: _Records, scale: float) -> np.ndarray:
    """Derivatives of the residuals by the logarithms of all values but the first `held`; last the residuals."""
    searched = values.size - held
    out = np.empty((searched + 1, r.measured.size))
    for i in range(searched, -1, -1):
        moved, step = values.copy(), 1.0
        if i < searched:
            p = math.log(values[held + i])
            step = (p + SMALL * max(1.0, abs(p)) * (-1.0 if p < 0 else 1.0)) - p
            moved[held + i] = math.exp(p + step)
        _left_over(moved, r, out[i])
        for j in range(out.shape[1]):
            x = out[i, j] / scale
            x = x if np.isfinite(x) else 1e3
            out[i, j] = (x - out[searched, j]) / step if i < searched else x
    return out


def _records(experiments: Any, measured: list[np.ndarray], names: list[list[str]]) -> _Records:
    places = np.cumsum([0, *(len(n) for n in names)])
    labels = [[e.base for e in experiments], [e.spring for e in experiments], [e.damper for e in experiments]]
    where = [[at + n.index(label) for label in some] for at, n, some in zip(places, names, labels, strict=False)]
    return _Records(
        where=np.array(where),
        added=np.array([float(e.added_mass) for e in experiments]),
        periods=np.array([float(e.sample_time) for e in experiments]),
        free=np.array([not np.any(e.input) and e.input_before == 0 for e in experiments]),
        cuts=np.cumsum([0, *(y.size for y in measured)]),
        forces=np.concatenate([np.asarray(e.input, float) - e.input_before for e in experiments]),
        measured=np.concatenate(measured),
    )


def _least(table: Callable[[np.ndarray], np.ndarray], begin: np.ndarray) -> Any:
    """Least squares on the triangle of (derivatives, residuals): the same search as on all samples, but cheaper."""
    kept: dict[bytes, np.ndarray] = {}

    def triangle(p: np.ndarray) -> np.ndarray:
        if p.tobytes() not in kept:
            columns = table(p).T
            kept[p.tobytes()] = np.triu(dgeqrf(columns, overwrite_a=1)[0][: columns.shape[1]])
        return kept[p.tobytes()]

    def residual(p: np.ndarray) -> np.ndarray:
        return triangle(p)[:, -1]

    def derivatives(p: np.ndarray) -> np.ndarray:
        return triangle(p)[:, :-1]

    return least_squares(
        residual,
        np.clip(begin, -9, 12),
        jac=derivatives,
        bounds=(-10, 14),
        xtol=1e-12,
        ftol=1e-13,
        gtol=1e-12,
    )


def linear_fit(
    experiments: Any,
    *,
    base_mass: Mapping[str, float],
    stiffness: Mapping[str, float],
    damping: Mapping[str, float],
    positions: list[np.ndarray] | None = None,
) -> LinearFit:
    """Fit the linear plant to `experiments` (as in a `stepid.Campaign`) from the given start."""
    names = [sorted({getattr(e, label) for e in experiments}) for label in ("base", "spring", "damper")]
    measured = [np.asarray(y, float) for y in positions or [e.position for e in experiments]]
    records = _records(experiments, measured, names)
    start = np.log([known[n] for known, some in zip((base_mass, stiffness, damping), names, strict=True) for n in some])
    # without a difference of mass only ratios are fixed: hold the base mass
    held = start[: len(names[0]) if len({e.added_mass for e in experiments}) == 1 else 0]
    scale = max(float(np.std(records.measured)), 1e-9)

    def table(p: np.ndarray) -> np.ndarray:
        return _table(np.exp(np.concatenate([held, p])), held.size, records, scale)

    best = None
    for stretch in (1.0, 1.5):
        begin = start.copy()
        begin[len(names[0]) + len(names[1]) :] += np.log(stretch)
        found = _least(table, begin[held.size :])
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    values = np.exp(np.concatenate([held, best.x]))
    left = np.empty(records.measured.size)
    gain = _left_over(values, records, left)
    cuts = np.cumsum([len(n) for n in names])[:-1]
    parts = zip(names, np.split(values, cuts), strict=True)
    m, k, c = (dict(zip(some, map(float, v), strict=True)) for some, v in parts)
    rms = float(np.sqrt(np.mean(left**2)))
    return LinearFit(m, k, c, float(gain), rms, tuple(np.split(left, records.cuts[1:-1])))
