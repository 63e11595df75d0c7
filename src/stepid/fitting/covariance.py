"""Parameters of a joint fit with their standard uncertainties and correlations."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stepid.core.base import Array
from stepid.core.estimate import Estimate
from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.simulation.records import Index


def parameter_names(optimum: Optimum, effects: tuple[Effect, ...]) -> tuple[tuple[str, str], ...]:
    """Name and unit of every shared parameter, in the order of the fit."""
    r = optimum.problem.records
    one = len(r.bases) == 1
    out = [("base_mass" if one else f"base_mass[{label}]", "kg") for label in r.bases]
    out += [(f"stiffness[{label}]", "N/m") for label in r.springs]
    out += [(f"damping[{label}]", "N·s/m") for label in r.dampers]
    out.append(("force_gain", "N/V"))
    out += [(f"{e.name}.{q.name}", q.unit) for e in effects for q in e.parameters]
    return tuple(out)


def covariance(optimum: Optimum, floor: float) -> tuple[Array, Array]:
    """Covariance of the free parameters, shape (n, n), and which directions the data leave open, shape (n,).

    The noise is taken as white of size `floor` or the residual's RMS, whichever is larger, inflated by the residual's
    own correlation: J⁺ Ω J⁺ᵀ with Ω from the residual's autocovariance over one swing at most (a sandwich).
    """
    problem = optimum.problem
    size = int(problem.free.sum() + problem.active.sum())
    square = np.zeros(size)
    for _, columns, rows in _finite_blocks(optimum):
        square[columns] += np.sum(rows**2, axis=1)
    scale = np.where(square > 0, np.sqrt(square), 1.0)
    _, s, vt = np.linalg.svd(_triangle(optimum, scale))
    usable = s > 1e-6 * s[0]  # the sensitivities are no better than that
    inverse = (vt.T * np.where(usable, 1 / np.where(usable, s, 1.0), 0.0)) / scale[:, None]
    residual = problem.residual(optimum.solved)
    level = max(floor**2, float(residual @ residual) / max(residual.size - s.size, 1))
    inflation = _inflation(optimum, inverse, residual)
    out: Array = (inverse * (level * inflation)) @ inverse.T
    open_ = np.abs(vt.T * ~usable).max(axis=1) > 1e-3 if not usable.all() else np.zeros(s.size, dtype=bool)
    return out, open_


def _finite_blocks(optimum: Optimum) -> Iterator[tuple[slice, Index, Array]]:
    """The blocks of the Jacobian, zero at a runaway's edge."""
    for piece, columns, rows in optimum.problem.blocks(optimum.solved):
        yield piece, columns, np.nan_to_num(rows, copy=False, posinf=0.0, neginf=0.0)


def _triangle(optimum: Optimum, scale: Array) -> Array:
    """Square matrix with the products of the Jacobian, its columns scaled: each run's own parameters are set aside."""
    n = int(optimum.problem.free.sum())
    out, common, at = np.zeros((scale.size, scale.size)), [np.zeros((n, n))], 0
    for _, columns, rows in _finite_blocks(optimum):
        r: Array = np.asarray(np.linalg.qr((rows / scale[columns, None]).T, mode="r"))
        own = columns.size - n
        out[at : at + len(r[:own]), columns] = r[:own]
        common.append(r[own:, own:])
        at += own
    out[at:, :n] = np.linalg.qr(np.concatenate(common), mode="r")
    return out


def _inflation(optimum: Optimum, inverse: Array, residual: Array) -> Array:
    """Variance of each direction's coefficient over that of white noise, at least 1; Bartlett lags."""
    pieces = optimum.problem.records.pieces()
    lags = 24
    square = float(residual @ residual)
    correlation = np.zeros(lags + 1)
    for piece in pieces:
        y = residual[piece]
        for lag in range(1, min(lags, y.size - 2) + 1):
            correlation[lag] += float(y[lag:] @ y[:-lag])
    correlation = correlation / square if square > 0 else correlation
    correlation[np.abs(correlation) < 2.5 / np.sqrt(residual.size)] = 0.0
    products = np.zeros((len(inverse), len(inverse)))
    for _, columns, rows in _finite_blocks(optimum):
        for lag in np.flatnonzero(correlation[: rows.shape[1] - 1]).tolist():
            taper = 1 - lag / (lags + 1)
            products[np.ix_(columns, columns)] += taper * correlation[lag] * (rows[:, lag:] @ rows[:, :-lag].T)
    out: Array = np.maximum(1.0 + 2.0 * np.sum(inverse * (products @ inverse), axis=0), 1.0)
    return out


def estimates(optimum: Optimum, effects: tuple[Effect, ...], floor: float) -> tuple[dict[str, Estimate], Array]:
    """Estimates by name, and the correlation matrix of the free shared parameters.

    A parameter that was held fixed (no mass difference, no input) or that the data leave open has no uncertainty.
    """
    problem = optimum.problem
    cov, open_ = covariance(optimum, floor)
    n = int(problem.free.sum())
    sigma = np.sqrt(np.maximum(np.diag(cov), 0.0))
    names = parameter_names(optimum, effects)
    out: dict[str, Estimate] = {}
    column = 0
    for index, (name, unit) in enumerate(names):
        uncertainty = None
        if problem.free[index]:
            uncertainty = None if open_[column] else float(sigma[column])
            column += 1
        out[name] = Estimate(value=float(optimum.shared[index]), uncertainty=uncertainty, unit=unit)
    safe = np.where(sigma[:n] > 0, sigma[:n], 1.0)
    return out, cov[:n, :n] / safe[:, None] / safe[None, :]
