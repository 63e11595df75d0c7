"""Parameters of a joint fit with their standard uncertainties and correlations."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import chdtri, stdtrit

from stepid.core.base import Array
from stepid.core.estimate import Estimate
from stepid.core.once import once
from stepid.effects.base import Effect, Parameter
from stepid.fitting.added_masses import WeightErrors, moved, weight_errors, with_added_masses
from stepid.fitting.correlation import Block, autocorrelations, disagreement, inflation
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.mean_of_runs import NORMAL, between_runs, centered, mean_of_runs
from stepid.fitting.random_effects import sizes_of_scatter
from stepid.simulation.magnitudes import lengths, with_mass
from stepid.simulation.records import mass_span

_STEPS = 6
_BELIEVED = 4.0  # standard deviations of a weight's error
_MISFIT = 1.2  # times the floor, beyond which what is left is not noise
_ENOUGH = 0.01  # in 2 ln L, below which a step is not worth a simulation
_REACHED = 1.05  # times the floor, where weights are free within their uncertainty
_CHANCE = 0.01  # that χ² is larger


def effect_parameters(effects: tuple[Effect, ...]) -> dict[str, Parameter]:
    """Parameters of effects by name, in the order of the fit; a label in another name may have a dot in it, too."""
    return {f"{e.name}.{q.name}": q for e in effects for q in e.parameters}


def parameter_names(optimum: Optimum, effects: tuple[Effect, ...]) -> tuple[tuple[str, str], ...]:
    """Name and unit of every shared parameter, in the order of the fit."""
    r = optimum.problem.records
    one = len(r.bases) == 1
    out = [("base_mass" if one else f"base_mass[{label}]", "kg") for label in r.bases]
    out += [(f"stiffness[{label}]", "N/m") for label in r.springs]
    out += [(f"damping[{label}]", "N·s/m") for label in r.dampers]
    out.append(("force_gain", "N/V"))
    out += [(name, q.unit) for name, q in effect_parameters(effects).items()]
    return tuple(out)


class Uncertain(NamedTuple):
    """A fit to first order about its optimum: n free parameters, K independent parts of the added masses' errors.

    Parameters
    ----------
    noise, weights : array, shape (n, n)
        Covariances of the free parameters that come from the readings' noise and from the added masses.
    open : array of bool, shape (n,)
        Parameters that the data leave open.
    step : array, shape (n,)
        From the optimum to the most likely parameters, the added masses free within their uncertainty.
    errors : array, shape (K,)
        The most likely parts of the added masses' errors; see `stepid.fitting.added_masses`.
    gain : float
        What the step promises, in 2 ln L.
    level : float
        m, of the noise, or of what the fit leaves.
    excess : array, shape (n,)
        Variance by noise over that by white noise of this level.
    """

    noise: Array
    weights: Array
    open: npt.NDArray[np.bool_]
    step: Array
    errors: Array
    gain: float
    level: float
    excess: Array


@once
def uncertain(optimum: Optimum, floor: float) -> Uncertain:
    """Covariances of the free parameters, by their causes, and how far the most likely ones are.

    The added masses are nuisance parameters with a prior: where runs say more of them than is known beforehand, what is
    left of their uncertainty is less than propagation would give, and so is the misfit. What differs from run to run
    has one, too: its bound, or what the runs scatter by. The noise is taken as white of
    size `floor` or the residual's RMS, whichever is larger, inflated by the residual's own correlation: J⁺ Ω J⁺ᵀ with Ω
    from the residual's autocovariance over one swing at most (a sandwich). Where more than noise is left, what the runs
    say one by one is counted, too.
    """
    problem = optimum.problem
    prior = weight_errors(problem.records)
    n, k = int(problem.free.sum() + problem.active.sum()), prior.found.size
    square = np.zeros(n + k)
    blocks = tuple(_finite_blocks(optimum, prior))
    for _, columns, rows, grown in blocks:
        square[columns] += grown**2 @ np.einsum("ij,ij->i", rows, rows)
    scale = np.where(square > 0, np.sqrt(square), 1.0)
    residual = problem.residual(optimum.solved)
    matrix, pull, left = _triangle(optimum, blocks, scale, residual)
    level = math.sqrt(max(floor**2, left / max(residual.size - n - k, 1)))
    precision = np.append(_precision(optimum), np.ones(k))
    longer = np.hypot(1.0, level * precision / scale)  # the prior's rows are of length one at most
    scale = scale * longer
    rows_of_prior = np.diag(level * precision / scale)[precision > 0]
    _, s, vt = np.linalg.svd(np.concatenate([matrix / longer, rows_of_prior]), full_matrices=False)
    usable = s > 1e-6 * s[0]  # the sensitivities are no better than that
    inverse = (vt.T * np.where(usable, 1 / np.where(usable, s, 1.0), 0.0)) / scale[:, None]
    known = level * inverse[n:]
    of_prior = known.T @ known
    share = 1.0 - np.diag(of_prior)
    excess = inflation(blocks, autocorrelations(optimum, residual), inverse, share)
    split = disagreement(blocks, residual, inverse, share, level)
    if level <= _MISFIT * floor:  # what chance does not make
        split = np.where(split > _by_chance(len(problem.records.runs), split.size), split, 1.0)
    excess = np.maximum(excess, split)
    root = np.sqrt(excess)
    of_noise = root[:, None] * (np.diag(usable.astype(float)) - of_prior) * root
    noise, weights = (level**2 * inverse @ part @ inverse.T for part in (of_noise, of_prior))
    white = np.sum((inverse @ (np.diag(usable.astype(float)) - of_prior)) * inverse, axis=1)[:n] * level**2
    ratio = np.maximum(np.diag(noise)[:n] / np.where(white > 0, white, np.inf), 1.0)
    open_ = np.abs(vt.T * ~usable).max(axis=1) > 1e-3 if not usable.all() else np.zeros(s.size, dtype=bool)
    held = np.append(at_bound(optimum), np.zeros(k, dtype=bool))  # errors of the weights have no bounds
    target = np.concatenate([pull, np.zeros(len(rows_of_prior) - k), -level * prior.found])
    slope = np.concatenate([matrix / longer, rows_of_prior])[:, ~held]
    step = np.zeros(n + k)
    step[~held] = np.linalg.lstsq(slope, target, rcond=1e-6)[0]
    gain = float(np.sum((slope @ step[~held]) ** 2)) / level**2
    step /= scale
    return Uncertain(noise[:n, :n], weights[:n, :n], open_[:n], step[:n], prior.found + step[n:], gain, level, ratio)


def _by_chance(runs: int, directions: int) -> float:
    """What the variance by what runs say one by one, over that of the noise, exceeds in one fit of a hundred."""
    free = max(runs - 1, 1)
    return float(chdtri(free, 0.01 / directions) / free)


def _precision(optimum: Optimum) -> Array:
    """One over the standard deviation by which the free parameters are known beforehand, 0 where nothing is known.

    What differs from run to run within a bound is as good as known to half of it, or to what two runs are found to
    differ by, √2 of the scatter: shared parameters take one degree of freedom of that, and of few runs it is known as
    little as Student's quantile says.
    """
    problem = optimum.problem
    shared = np.zeros(int(problem.free.sum()))
    known = np.full(problem.active.shape, np.inf) if problem.most is None else problem.most / 2
    for kind, size in sizes_of_scatter(optimum).items():
        row = problem.layout.deviation(kind)
        count = int(problem.active[row].sum())
        if size > 0 and count > 1:  # a fault of one run is not drawn, and has no bound
            few = math.sqrt(2 * count / (count - 1)) * float(stdtrit(count - 1, 0.975)) / NORMAL
            known[row] = np.where(np.isfinite(known[row]), np.minimum(known[row], few * size), known[row])
    return np.append(shared, 1 / known[problem.active])


def at_bound(optimum: Optimum) -> npt.NDArray[np.bool_]:
    """Free parameters that sit at a bound, of the columns of the Jacobian."""
    problem = optimum.problem
    shared = optimum.shared
    out = ((shared <= problem.lower) | (shared >= problem.upper))[problem.free]
    return np.append(out, np.zeros(int(problem.active.sum()), dtype=bool))


def _finite_blocks(optimum: Optimum, prior: WeightErrors) -> Iterator[Block]:
    """The blocks of the Jacobian, the added masses' columns last, zero at a runaway's edge."""
    problem = optimum.problem
    n, k = int(problem.free.sum() + problem.active.sum()), prior.found.size
    for run, (piece, columns, rows) in enumerate(problem.blocks(optimum.solved)):
        rows = np.nan_to_num(rows, copy=False, posinf=0.0, neginf=0.0)
        mass = (columns == problem.records.base[run]).astype(float)  # an added mass acts as the base's
        grown = np.concatenate([np.eye(columns.size), prior.spread[run][:, None] * mass])
        yield Block(piece, np.append(columns, n + np.arange(k)), rows, grown)


def _triangle(optimum: Optimum, blocks: Sequence[Block], scale: Array, residual: Array) -> tuple[Array, Array, float]:
    """Square matrix with the products of the Jacobian, its columns scaled, the residual's share, and what is beyond.

    Each run's own parameters are set aside.
    """
    n = int(optimum.problem.free.sum())
    k = scale.size - n - int(optimum.problem.active.sum())
    shared = np.append(np.arange(n), scale.size - k + np.arange(k))
    out, pull = np.zeros((scale.size, scale.size)), np.zeros(scale.size)
    common, at = [np.zeros((n + k + 1, n + k + 1))], 0
    for piece, columns, rows, grown in blocks:
        plain = np.asarray(np.linalg.qr(np.concatenate([rows, residual[None, piece]]).T, mode="r"))
        scaled = np.column_stack([plain[:, :-1] @ grown.T / scale[columns], plain[:, -1]])
        r: Array = np.asarray(np.linalg.qr(scaled, mode="r"))
        own = columns.size - n - k
        some = r[:own]
        out[at : at + len(some), columns], pull[at : at + len(some)] = some[:, :-1], some[:, -1]
        common.append(r[own:, own:])
        at += own
    rest = np.asarray(np.linalg.qr(np.concatenate(common), mode="r"))
    out[at:, shared], pull[at:] = rest[:-1, :-1], rest[:-1, -1]
    return out, pull, float(rest[-1, -1] ** 2)


def most_likely(optimum: Optimum, floor: float) -> Optimum:
    """Move an optimum to the most likely parameters, the added masses free within their uncertainty.

    The records of the answer hold the added masses that were found. What was fitted with exact masses is near: a few
    Gauss–Newton steps do it. Where a weight would have to be off by more than its uncertainty allows, something else is
    wrong, and the optimum stays as it is.
    """
    given, fresh = optimum, True
    for _ in range(_STEPS):
        near = uncertain(optimum, floor)
        if near.errors.size == 0 or np.abs(near.errors).max() > _BELIEVED:
            return given
        if near.gain < _ENOUGH:
            return optimum
        records = with_added_masses(optimum.problem.records, near.errors)
        n = int(optimum.problem.free.sum())
        shared, local = optimum.shared.copy(), optimum.local.copy()
        shared[optimum.problem.free] += near.step[:n]
        local[optimum.problem.active] += near.step[n:]
        there = moved(optimum, records, shared, local)
        better = there is not None and _loss(there, near.level) < _loss(optimum, near.level)
        if there is not None and better:
            optimum, fresh = there, False
            continue
        solved = None if fresh else optimum.problem.solve(optimum.shared, optimum.local)
        if solved is None:
            return optimum
        optimum, fresh = replace(optimum, solved=solved), True
    return optimum


def _loss(optimum: Optimum, level: float) -> float:
    return optimum.cost / level**2 + float(np.sum(weight_errors(optimum.problem.records).found ** 2))


@once
def by_weights(linear: Optimum, floor: float) -> Optimum | None:
    """The linear plant with the most likely added masses, where errors of these are seen and leave only noise.

    They must be such as their uncertainty makes, and gain more than errors of noise do, by χ².
    """
    likely = most_likely(linear, floor)
    if likely is linear or likely.rms > _REACHED * floor:
        return None
    found = weight_errors(likely.problem.records).found
    most = float(chdtri(found.size, _CHANCE))
    seen = _loss(linear, floor) - _loss(likely, floor) > most
    return likely if seen and float(found @ found) <= most else None


def _parameters(names: tuple[tuple[str, str], ...], effects: tuple[Effect, ...]) -> tuple[Parameter, ...]:
    own = tuple(q for e in effects for q in e.parameters)
    return (*(Parameter(name, unit) for name, unit in names[: len(names) - len(own)]), *own)


def mass_is_held(optimum: Optimum) -> bool:
    """Tell whether a base mass is held where what weights can tell ends; see `problem.within_weights`."""
    problem = optimum.problem
    return mass_span(problem.records) > 0 and not problem.free[problem.layout.base_mass].all()


def estimates(optimum: Optimum, effects: tuple[Effect, ...], floor: float) -> tuple[dict[str, Estimate], Array]:
    """Estimates by name, and the correlation matrix of the free shared parameters.

    A parameter that was held fixed (no mass difference, no input) or that the data leave open has no uncertainty. Nor
    has any that goes with the mass, where weights that differ do not tell a base mass, which is held at the end of
    what they can. What differs from run to run is the mean of the runs; see `centered`.
    """
    optimum = centered(optimum)
    problem = optimum.problem
    near = uncertain(optimum, floor)
    names = parameter_names(optimum, effects)
    parameters = _parameters(names, effects)
    longer = lengths(parameters, optimum.shared)[problem.free]
    known = ~with_mass(parameters) if mass_is_held(optimum) else np.ones(len(names), dtype=bool)
    scaled = problem.records.scale_uncertainty * longer
    mean = mean_of_runs(optimum)
    runs, quantile = between_runs(optimum)
    cov = {"noise": mean @ near.noise @ mean.T, "weights": mean @ near.weights @ mean.T, "runs": runs}
    cov["scale"] = np.outer(scaled, scaled)
    sigma = {cause: np.sqrt(np.maximum(np.diag(part), 0.0)) for cause, part in cov.items()}
    whole = np.sqrt(sum(part**2 for part in sigma.values()))
    half = np.sqrt(np.maximum((NORMAL * whole) ** 2 + (quantile**2 - NORMAL**2) * sigma["runs"] ** 2, 0.0))
    out: dict[str, Estimate] = {}
    column = 0
    for index, (name, unit) in enumerate(names):
        value = float(optimum.shared[index])
        out[name] = Estimate(value=value, unit=unit)
        if problem.free[index] and known[index] and not near.open[column]:
            parts = {cause: float(part[column]) for cause, part in sigma.items() if part[column] > 0}
            few = parts.get("runs") and (value - float(half[column]), value + float(half[column]))
            out[name] = Estimate(
                value=value, uncertainty=float(whole[column]), unit=unit, parts=parts, limits=few or None
            )
        column += int(problem.free[index])
    safe = np.where(whole > 0, whole, 1.0)
    return out, sum(cov.values()) / safe[:, None] / safe[None, :]
