"""What repeated runs differ by: start time, gain, damping and friction of each run, and what a free one promises."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.core.once import once
from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.problem import free_starts
from stepid.simulation.layout import STARTS

SCATTER = ("start_time", "gain", "damping", "friction")
"""What runs of a healthy plant differ by; their rest positions differ, too, and need no parameter."""
FAULTS = ("damping", "stiffness", "added_mass", "gain", "start_time")
"""What may be wrong with one run."""

Mask = npt.NDArray[np.bool_]
Kind = str | tuple[int, str]  # in all runs; in one run, by index

_STARTS = tuple(q.name for q in STARTS)
_MOST = 0.25  # relative: labs scatter by 1 to 6 %, and two runs of the latter differ by more once in 300; more is a law
_LATE = 6.0  # samples: three standard deviations of two, by which triggers of labs jitter; more is a delay or a fault
_SLIGHT = 1e-6  # of the largest singular value: the sensitivities are no better than that
_OPEN = 1e-7  # share of a deviation's power that other parameters leave, below which the data leave it open


class Promise(NamedTuple):
    """One linearized step along a deviation, all other parameters free.

    Parameters
    ----------
    gain : float
        m², decrease of the cost.
    values : array, shape (R,)
        The deviation's change in each run, in its unit; 0 where it has none.
    errors : array, shape (R,)
        Standard errors of `values` per meter of white noise.
    """

    gain: float
    values: Array
    errors: Array


def conditions(kinds: frozenset[str]) -> int:
    """Number of conditions that these are: offset and velocity of a start are one."""
    return len(kinds.difference(_STARTS)) + (not kinds.isdisjoint(_STARTS))


def applies(problem: Problem, kind: str) -> Mask:
    """Runs in which a deviation makes sense, shape (R,); parts of one recording differ in how they start only."""
    records, effects = problem.records, problem.simulator.effects
    every = np.full(len(records.runs), not records.one_recording)
    if kind == "start_time":
        return every & records.driven & ~records.moving
    if kind in _STARTS:
        free: Mask = free_starts(records, effects)[problem.layout.deviation(kind)]
        return ~free
    if kind == "gain":
        return every & records.driven
    if kind == "friction":
        return every & any(_held_by(e) for e in effects)
    return every


def _held_by(effect: Effect) -> bool:
    return effect.dry and any(q.force for q in effect.parameters)


def with_deviations(problem: Problem, kinds: Iterable[str]) -> Problem:
    """Free deviations in every run that may have them, but for one of those whose common change is a global parameter.

    Parameters
    ----------
    problem : Problem
    kinds : iterable of str
        Of `SCATTER` or `STARTS`, or ``"stiffness"``. Start times are free in every driven run, unless an effect delays
        the input. They differ by six samples, relative changes by a quarter at most: what differs by more does not
        scatter, it follows a law or is a fault.
    """
    active, most = problem.active.copy(), np.full(problem.active.shape, np.inf)
    for kind in kinds:
        use, row = applies(problem, kind), problem.layout.deviation(kind)
        use[_references(problem, kind, use)] = False
        active[row] |= use
        late = _LATE * problem.records.sample_time
        most[row] = late if kind == "start_time" else np.inf if kind in _STARTS else _MOST
    return replace(problem, active=active, most=most)


def starts_kept(problem: Problem, effects: tuple[Effect, ...]) -> frozenset[str]:
    """`STARTS` that are free in a problem and would not be with some of its effects."""
    lost = problem.active[:2] & ~free_starts(problem.records, effects)
    return frozenset(name for name, runs in zip(_STARTS, lost, strict=True) if runs.any())


@once
def without_deviations(optimum: Optimum, tolerance: float) -> Optimum:
    """Fit anew with conditions alike in all runs, as far as that can be done.

    Parameters
    ----------
    optimum : Optimum
    tolerance : float
        As in `stepid.fitting.levenberg_marquardt.minimize`.
    """
    problem = optimum.problem
    active = problem.active.copy()
    active[problem.layout.deviations] = False
    active[:2] &= free_starts(problem.records, problem.simulator.effects)
    local = np.where(active, optimum.local, 0.0)
    return minimize(replace(problem, active=active), optimum.shared, local, tolerance=tolerance) or optimum


def with_fault(problem: Problem, run: int, kind: str) -> Problem:
    """Free one deviation in one run, given by its index."""
    active, row = problem.active.copy(), problem.layout.deviation(kind)
    active[row, run] = True
    most = problem.most
    if most is not None:
        most = most.copy()
        most[row, run] = np.inf
    return replace(problem, active=active, most=most)


def _references(problem: Problem, kind: str, use: Mask) -> list[int]:
    """Runs that stand for the plant: the first of those whose common deviation is a free global parameter."""
    records, n = problem.records, len(problem.records.runs)
    groups = {"damping": records.damper, "stiffness": records.spring}.get(kind, np.zeros(n, dtype=np.intp))
    if kind in _STARTS:
        return []
    if kind == "start_time" and not any(type(e).delay is not Effect.delay for e in problem.simulator.effects):
        return []
    if kind == "gain" and not problem.free[problem.layout.force_gain]:
        return []
    return [int(np.flatnonzero(use & (groups == g))[0]) for g in np.unique(groups[use])]


def scatter_values(optimum: Optimum) -> dict[str, Array]:
    """Deviations of each run about their own mean, for every kind that is free in some run, and rest positions.

    Returns
    -------
    dict
        ``"rest"`` [m] and kinds of `SCATTER` and `STARTS` to array, shape (R,), not a number in runs that have none.
        Damping's are about the mean of each damper label.
    """
    problem = optimum.problem
    records, of = problem.records, problem.layout
    square = records.weight**2
    left = records.position - optimum.solved.reading
    rest = np.add.reduceat(left * square, records.first) / np.add.reduceat(square, records.first)
    out = {"rest": rest - rest.mean()}
    for kind in (*SCATTER, *_STARTS):
        row = of.deviation(kind)
        if not problem.active[row].any():
            continue
        use = applies(problem, kind)
        if not problem.active[row, use].any():  # of those that are free, whatever the kind
            continue
        groups = records.damper if kind == "damping" else np.zeros_like(records.damper)
        values = np.full(len(records.runs), np.nan)
        for g in np.unique(groups[use]):
            own = use & (groups == g)
            if own.sum() > 1:
                common = 0.0 if kind in _STARTS else optimum.local[row, own].mean()
                values[own] = optimum.local[row, own] - common
        out[kind] = values
    return out


def promised(optimum: Optimum, kinds: Iterable[Kind]) -> dict[Kind, Promise]:
    """What one linearized step along each deviation would gain, all free parameters adapted: no fit, no search.

    Parameters
    ----------
    optimum : Optimum
    kinds : iterable of str or (int, str)
        A kind of `SCATTER` is freed as by `with_deviations`, the kind of one run as by `with_fault`.

    Returns
    -------
    dict
        Kind to Promise, nothing for a kind that is free already, makes no sense or goes beyond the simulation.
    """
    problem = optimum.problem
    masks = {kind: _fresh(problem, kind) for kind in kinds}
    masks = {kind: mask for kind, mask in masks.items() if mask.any()}
    basis = _Basis(optimum) if masks else None
    if basis is None or not basis.finite:
        return {}
    where = np.argwhere(np.any(list(masks.values()), axis=0))
    columns = columns_by(optimum, where)
    pull, gram = basis.project(columns)
    own = np.sum(columns**2, axis=0)
    out: dict[Kind, Promise] = {}
    for kind, mask in masks.items():
        chosen = np.flatnonzero(mask[where[:, 0], where[:, 1]])
        usable = chosen[own[chosen] > 0]
        values, errors = np.zeros(mask.shape[1]), np.full(mask.shape[1], np.inf)
        if usable.size:
            scale = np.sqrt(own[usable])
            w, v = np.linalg.eigh(gram[np.ix_(usable, usable)] / np.outer(scale, scale))
            good = w > _OPEN
            inverse = (v[:, good] / w[good]) @ v[:, good].T
            step = inverse @ (pull[usable] / scale)
            runs = where[usable, 1]
            values[runs] = step / scale
            determined = np.sum(v[:, good] ** 2, axis=1) > 0.5
            errors[runs] = np.where(determined, np.sqrt(np.diag(inverse)) / scale, np.inf)
            out[kind] = Promise(float(step @ (pull[usable] / scale)), values, errors)
    return out


def promised_by(optimum: Optimum, columns: Array) -> tuple[Array, Array, Array]:
    """What one step along each of some changes of the reading would gain, one at a time, all else adapted.

    All else are the fit's own free parameters: a step in one run is from what the other runs say.

    Parameters
    ----------
    optimum : Optimum
    columns : array, shape (S, n)
        Derivatives of the weighted reading; see `Records.weighted`.

    Returns
    -------
    gain, value, error : array, shape (n,)
        Decrease of the cost [m²], step, its standard error per meter of white noise; 0, 0, infinite where left open.
    """
    basis = _Basis(optimum)
    if not basis.finite:
        return np.zeros(columns.shape[1]), np.zeros(columns.shape[1]), np.full(columns.shape[1], np.inf)
    pull, gram = basis.project(columns)
    power = np.diag(gram)
    power = np.where(power > _OPEN * np.sum(columns**2, axis=0), power, np.inf)
    return pull**2 / power, pull / power, np.where(np.isfinite(power), 1 / np.sqrt(power), np.inf)


class _Basis:
    """What the free parameters of a fit can do to the reading: orthonormal, those that depend on others left out."""

    def __init__(self, optimum: Optimum) -> None:
        problem = optimum.problem
        jacobian, residual = problem.jacobian(optimum.solved), problem.residual(optimum.solved)
        self.finite = bool(np.isfinite(jacobian).all())
        if not self.finite:
            return
        size = np.linalg.norm(jacobian, axis=0)
        jacobian /= np.where(size > 0, size, np.inf)
        u, s, _ = np.linalg.svd(jacobian, full_matrices=False)
        self._q = u[:, s > _SLIGHT * s.max(initial=1e-300)]
        self._left = residual - self._q @ (self._q.T @ residual)

    def project(self, columns: Array) -> tuple[Array, Array]:
        """Products of columns with the residual, and with one another, all less what the free parameters can do."""
        inside = self._q.T @ columns
        return columns.T @ self._left, columns.T @ columns - inside.T @ inside


def _fresh(problem: Problem, kind: Kind) -> Mask:
    """Rows and runs that a kind would free."""
    if isinstance(kind, str):
        return with_deviations(problem, (kind,)).active & ~problem.active
    run, name = kind
    if not applies(problem, name)[run]:
        return np.zeros_like(problem.active)
    return with_fault(problem, run, name).active & ~problem.active


def columns_by(optimum: Optimum, where: npt.NDArray[np.intp]) -> Array:
    """Weighted derivatives of the reading by some per-run parameters (row, run), shape (S, n); zero if not finite."""
    problem, solved = optimum.problem, optimum.solved
    active = np.zeros_like(problem.active)
    active[where[:, 0], where[:, 1]] = True
    none = np.zeros_like(problem.free)
    _, by_run = problem.simulator.derivatives(
        optimum.shared, optimum.local, solved.reading, none, active, solved.states
    )
    with np.errstate(all="ignore"):
        seen = problem.records.weighted(by_run)
    out = np.zeros((problem.records.size, len(where)))
    pieces = problem.records.pieces()
    for column, (row, run) in enumerate(where):
        out[pieces[run], column] = np.nan_to_num(seen[row, pieces[run]], posinf=0.0, neginf=0.0)
    return out
