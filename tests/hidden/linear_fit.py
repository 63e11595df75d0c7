"""The best joint linear fit, by code of its own: exact held-input recursion, and what is linear eliminated.

Shared: base mass (a base label), stiffness (a spring label), damping (a damper label), one force gain. Per run: the
rest position and, for a free release, the initial state. Masses, stiffness and damping are searched; gain, rest
positions and initial states are eliminated exactly (variable projection).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter


@dataclass(frozen=True)
class LinearFit:
    base_mass: dict[str, float]
    stiffness: dict[str, float]
    damping: dict[str, float]
    force_gain: float
    rms: float
    residuals: tuple[np.ndarray, ...]


def unit_response(mass: float, stiffness: float, damping: float, force: np.ndarray, period: float) -> np.ndarray:
    """Position from rest under a force held over each sample."""
    decay = damping / (2 * mass)
    rate = np.sqrt(complex(stiffness / mass - decay**2)) or 1e-12
    fall = np.exp(-decay * period)
    cosine, sine = np.cos(rate * period).real, (np.sin(rate * period) / rate).real
    first = (1 - fall * (cosine + decay * sine)) / stiffness
    trace, determinant = 2 * fall * cosine, fall**2
    second = (1 - trace + determinant) / stiffness - first
    return np.asarray(lfilter([0.0, first, second], [1.0, -trace, determinant], force))


def free_response(mass: float, stiffness: float, damping: float, times: np.ndarray) -> np.ndarray:
    decay = damping / (2 * mass)
    rate = np.sqrt(complex(stiffness / mass - decay**2)) or 1e-12
    fall = np.exp(-decay * times)
    return np.column_stack([fall * np.cos(rate * times).real, fall * (np.sin(rate * times) / rate).real])


def linear_fit(
    experiments: Any,
    *,
    base_mass: Mapping[str, float],
    stiffness: Mapping[str, float],
    damping: Mapping[str, float],
    positions: list[np.ndarray] | None = None,
) -> LinearFit:
    """Fit the linear plant to `experiments` (as in a `stepid.Campaign`) from the given start."""
    bases = sorted({e.base for e in experiments})
    springs = sorted({e.spring for e in experiments})
    dampers = sorted({e.damper for e in experiments})
    measured = [np.asarray(e.position) for e in experiments] if positions is None else positions
    moving = [not np.any(e.input) and e.input_before == 0 for e in experiments]
    # without a difference of mass only ratios are fixed: hold the base mass
    fixed = len({e.added_mass for e in experiments}) == 1
    start = [base_mass[b] for b in bases] + [stiffness[s] for s in springs] + [damping[d] for d in dampers]

    def unpack(p: np.ndarray) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
        values = np.exp(np.concatenate([np.log(start[: len(bases)]), p]) if fixed else p)
        names = [bases, springs, dampers]
        cuts = np.cumsum([len(n) for n in names])
        parts = np.split(values, cuts[:-1])
        m, k, c = (dict(zip(n, map(float, v), strict=True)) for n, v in zip(names, parts, strict=True))
        return m, k, c

    def solve(p: np.ndarray) -> tuple[float, list[np.ndarray]]:
        m, k, c = unpack(p)
        driven, left = [], []
        for e, y, free in zip(experiments, measured, moving, strict=True):
            plant = (m[e.base] + e.added_mass, k[e.spring], c[e.damper])
            if free:
                columns = np.column_stack([np.ones(y.size), free_response(*plant, e.sample_time * np.arange(y.size))])
                basis, _ = np.linalg.qr(columns)
                left.append(y - basis @ (basis.T @ y))
                driven.append(np.zeros(y.size))
            else:
                s = unit_response(*plant, np.asarray(e.input) - e.input_before, e.sample_time)
                driven.append(s - s.mean())
                left.append(y - y.mean())
        power = sum(float(s @ s) for s in driven)
        gain = sum(float(s @ y) for s, y in zip(driven, left, strict=True)) / power if power else 0.0
        return gain, [y - gain * s for s, y in zip(driven, left, strict=True)]

    scale = max(float(np.std(np.concatenate(measured))), 1e-9)

    def residual(p: np.ndarray) -> np.ndarray:
        with np.errstate(over="ignore", invalid="ignore"):
            out = np.concatenate(solve(p)[1]) / scale
        return np.where(np.isfinite(out), out, 1e3)

    best = None
    for stretch in (1.0, 1.5):
        begin = np.log(start)
        begin[len(bases) + len(springs) :] += np.log(stretch)
        begin = begin[len(bases) :] if fixed else begin
        found = least_squares(residual, np.clip(begin, -9, 12), bounds=(-10, 14), xtol=1e-12, ftol=1e-13, gtol=1e-12)
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    gain, residuals = solve(best.x)
    m, k, c = unpack(best.x)
    rms = float(np.sqrt(np.mean(np.concatenate(residuals) ** 2)))
    return LinearFit(m, k, c, gain, rms, tuple(residuals))
