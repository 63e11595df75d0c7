"""How much each effect could explain of a residual, by one linearized step on the measured motion: for starts only."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.once import once
from stepid.effects.base import Effect, Scales
from stepid.effects.drive import acts_on_input
from stepid.fitting.absent import Absent
from stepid.fitting.levenberg_marquardt import Optimum, Problem
from stepid.fitting.multistart import FitContext, Scored, Start
from stepid.fitting.problem import build, start_local
from stepid.fitting.tangent import Tangent, scaled_parts
from stepid.simulation.records import Records
from stepid.simulation.simulator import COARSE, Simulator

_HARDLY = 0.02  # share of the change to a general law that a linearized step must ask for
_STARTS = 3  # of each effect: of what rings, the loudest may not be what is missing
_AT_ONCE = 16  # forces whose responses are simulated together
_ASTRAY = 0.2  # share of the motion that the linear plant leaves, beyond which it swings out of step
_SLIGHT = 1e-4  # of the spring's largest force: a force that hardly changes the motion


class Column(NamedTuple):
    """Responses of a plant to one start of an effect, and what turns their coefficients into its values."""

    effect: Effect
    responses: Array  # (S, k), weighted
    values: Callable[[Array], tuple[float, ...] | None]


def force_responses(context: FitContext, forces: list[Array]) -> Array:
    """Reading's response of the linear plant to added forces, shapes (S,) each to (S, n)."""
    linear, records = context.coarse_linear, context.decimated
    plant, of = linear.shared.copy(), linear.problem.layout
    felt = float(np.abs(plant[of.stiffness]).mean()) * linear.problem.simulator.scale  # N
    plant[of.force_gain] = felt  # under 1 N a soft one runs away
    out = np.empty((len(forces), records.size))
    for i in range(0, len(forces), _AT_ONCE):  # the plant driven by the forces, beside each other
        some = forces[i : i + _AT_ONCE]
        pushed = records.repeated(len(some)).with_input(_means(some, records).ravel())
        pushed = replace(pushed, before=np.zeros(len(pushed.runs)))
        still = np.zeros((1, linear.local.shape[0], len(pushed.runs)))
        out[i : i + len(some)] = Simulator(pushed, ()).readings(plant[None], still).reshape(len(some), -1)
    out /= felt
    return out.T


def _means(forces: list[Array], records: Records) -> Array:
    """Means of forces, given at all samples, from each decimated sample to the next, shape (n, S)."""
    force, none = np.array(forces), np.zeros((len(forces), 1))
    between = 0.5 * (force[:, :-1] + force[:, 1:])
    if records.at is not None:
        sums = np.concatenate([none, np.cumsum(between, axis=1)], axis=1)
        between = np.diff(sums[:, records.at], axis=1) / np.diff(records.at)
    return np.concatenate([between, none], axis=1)


def responses_along(base: Optimum, records: Records, forces: list[Array]) -> Array:
    """Reading's response of a fitted plant to slight added forces, per newton, shapes (S,) each to (S, n)."""
    problem = base.problem
    of, gain = problem.layout, float(base.shared[problem.layout.force_gain])
    stiffness = float(base.shared[of.stiffness].mean())
    shared = base.shared.copy()
    if gain == 0:
        shared[of.force_gain] = gain = 1.0
    plain = Simulator(records, problem.simulator.effects).readings(base.shared[None], base.local[None])
    out = np.empty((len(forces), records.size))
    for i in range(0, len(forces), _AT_ONCE):
        some = _means(forces[i : i + _AT_ONCE], records)
        sizes = _SLIGHT * stiffness * problem.simulator.scale / np.maximum(np.abs(some).max(axis=1), 1e-300)
        pushed = records.repeated(len(some)).with_input((records.volts + sizes[:, None] * some / gain).ravel())
        readings = Simulator(pushed, problem.simulator.effects).readings(
            shared[None], np.tile(base.local, len(some))[None]
        )
        out[i : i + len(some)] = (readings.reshape(len(some), -1) - plain) / sizes[:, None]
    return out.T


def astray(context: FitContext, base: Optimum) -> bool:
    """Tell whether the linear plant swings so unlike a fit that its response to a force is not the plant's."""
    effects = base.problem.simulator.effects
    if any(map(acts_on_input, effects)):
        return False
    records = context.records
    motion = float(np.linalg.norm(records.weighted(records.position)))
    return bool(effects) and float(np.sqrt(context.linear.cost)) > _ASTRAY * motion


def columns(
    context: FitContext, effects: tuple[Effect, ...], scales: Scales | None = None, base: Optimum | None = None
) -> list[Column]:
    """Responses of the linear plant to every effect at each of its starts; of a fitted one where it swings otherwise.

    Parameters
    ----------
    context : FitContext
    effects : tuple of Effect
    scales : Scales, optional
        For the starts, the context's by default.
    base : Optimum, optional
        The fit, on the context's decimated records.
    """
    if base is not None and astray(context, base):
        return _columns(context, effects, scales or context.scales, base)
    if scales is not None:
        return _columns(context, effects, scales)
    new = tuple(e for e in effects if e not in context.columns)
    fresh = _columns(context, new, context.scales)
    context.columns |= {e: [c for c in fresh if c.effect is e] for e in new}
    return [c for e in effects for c in context.columns[e]]


def _columns(
    context: FitContext, effects: tuple[Effect, ...], scales: Scales, base: Optimum | None = None
) -> list[Column]:
    found: list[Column] = []
    forces: list[Array] = []
    pending: list[tuple[Effect, int, Callable[[Array], tuple[float, ...] | None]]] = []
    for effect in effects:
        regressors = context.regressors(effect, scales)
        for regressor in regressors:
            pending.append((effect, len(regressor.forces), regressor.values))
            forces.extend(regressor.forces)
        if not regressors:
            for values in effect.starts(scales):
                key = (effect, tuple(values))
                if key not in context.responses:
                    context.responses[key] = difference(context.coarse_linear, *key)
                response = context.responses[key]
                if response is not None:
                    weighted = context.decimated.weighted(response.T).T
                    found.append(Column(effect, weighted, scaled(effect, tuple(values))))
    if forces:
        pushed = force_responses(context, forces) if base is None else responses_along(base, context.decimated, forces)
        responses = context.decimated.weighted(pushed.T).T
        at = 0
        for effect, width, convert in pending:
            found.append(Column(effect, responses[:, at : at + width], convert))
            at += width
    return found


def scaled(effect: Effect, values: tuple[float, ...]) -> Callable[[Array], tuple[float, ...] | None]:
    """Values at which the effect is as strong as the coefficient of its response says, a factor of 20 at most."""

    def convert(coefficients: Array) -> tuple[float, ...]:
        share = float(coefficients[0])
        if effect.run_parameters:  # a cosine and a sine a run
            share = float(np.sqrt(np.mean(np.square(coefficients)) * 2))
        return effect.faint(values, min(max(share, 0.05), 20.0))

    return convert


def difference(linear: Optimum, effect: Effect, values: tuple[float, ...]) -> Array | None:
    """What an effect changes in the motion of a linear plant, and the derivatives of that, m, shape (S, k).

    None where the plant runs away. Beside the change at these values stand the derivatives by them, and those by the
    effect's own states where a run starts in motion; of an effect with a phase, cosine and sine of each run.
    """
    problem, local = _asked(linear, effect)
    records, of = problem.records, problem.layout
    solved = problem.solve(np.concatenate([linear.shared, values]), local)
    if solved is None:
        return None
    by_shared, by_local = solved.derivatives
    parts = [(solved.reading - linear.solved.reading)[:, None]]
    if effect.run_parameters:  # a phase a run: both quadratures are free
        split = np.zeros((records.size, 2 * len(records.runs)))
        for r, piece in enumerate(records.pieces()):
            split[piece, 2 * r] = parts[0][piece, 0]
            split[piece, 2 * r + 1] = by_local[2, piece]
        return split
    parts.append(by_shared[of.linear.stop :].T)
    pieces = records.pieces()
    for row, run in np.argwhere(problem.active):
        started = np.zeros((records.size, 1))
        started[pieces[run], 0] = by_local[row, pieces[run]]
        parts.append(started)
    return np.concatenate(parts, axis=1)


@once
def _asked(linear: Optimum, effect: Effect) -> tuple[Problem, Array]:
    """What `difference` derives by: the effect's parameters and own states, or its phase; and the local parameters."""
    problem = build(linear.problem.records, (effect,), tolerance=COARSE)
    of = problem.layout
    free, active = problem.free.copy(), np.zeros_like(problem.active)
    free[slice(None) if effect.run_parameters else of.linear] = False
    rows = slice(2, 3) if effect.run_parameters else of.own_states
    active[rows] = problem.active[rows]
    return replace(problem, free=free, active=active), start_local(problem, linear)


def score(base: Optimum, table: list[Column], *, instead: Absent | None = None) -> list[Scored]:
    """Score every start against the residual of a fit to the decimated records: the best few of each effect.

    Parameters
    ----------
    base : Optimum
    table : list
        From `columns`.
    instead : Absent, optional
        What is taken away for it: then this is scored on what the fit leaves without it.

    Returns
    -------
    list of Scored
        Most promising first, whatever the effect; no more than three of one.
    """
    tangent = Tangent(base, instead)
    if not tangent.directed:
        return []
    residual = tangent.left
    total = float(residual @ residual)
    found = []
    for column, r in zip(table, scaled_parts(tangent.beyond, [c.responses for c in table]), strict=True):
        if r is None:
            continue
        gain, coefficients = _fitted(r[0], residual)
        found.append((gain, column, coefficients / r[1]))
    out: list[Scored] = []
    starts = Counter[Effect]()
    for gain, column, coefficients in sorted(found, key=lambda item: -item[0]):
        values = column.values(coefficients) if starts[column.effect] < _STARTS else None
        if values is None:
            continue
        starts[column.effect] += 1
        shared = tangent.adapted(column.responses @ coefficients)
        out.append(Scored(column.effect, values, gain, shared, total - gain))
    return out


def _fitted(part: Array, residual: Array) -> tuple[float, Array]:
    """What columns of a norm of one take of a residual, m², and their coefficients."""
    if part.shape[1] == 1:
        along = part.T @ residual
        return float(along[0]) ** 2, along
    triangle = np.asarray(np.linalg.qr(np.column_stack([part, residual]), mode="r"))
    found = np.linalg.lstsq(triangle[:, :-1], triangle[:, -1], rcond=1e-9)[0]
    left = triangle[:, -1] - triangle[:, :-1] @ found
    return float(triangle[:, -1] @ triangle[:, -1] - left @ left), found


def promises(context: FitContext, inner: Optimum, effects: tuple[Effect, ...], starts: list[Start]) -> list[float]:
    """Decrease of the cost [m²] that each start of a more general law promises over a simpler one's fit.

    By one linearized step: the change of the reading from the simpler law to the start is fitted to the residual, with
    what the simpler law's own parameters can do about it. Infinite where it cannot tell: let it race.
    """
    jacobian = inner.problem.jacobian(inner.solved)
    if not starts or not np.isfinite(jacobian).all():
        return [np.inf] * len(starts)
    sim = Simulator(context.decimated, effects, COARSE)
    shared = np.array([np.concatenate([start.linear, *start.values]) for start in starts])
    local = np.zeros((sim.layout.n_run, inner.local.shape[1]))
    of = inner.problem.layout
    local[: of.own_states.start] = inner.local[: of.own_states.start]
    local[sim.layout.deviations] = inner.local[of.deviations]
    readings = sim.readings(shared, np.repeat(local[None], len(shared), axis=0))
    size = np.linalg.norm(jacobian, axis=0)
    size[size == 0] = np.inf
    q = np.linalg.qr(jacobian / size)[0]
    residual = inner.problem.residual(inner.solved)
    found = []
    for reading in readings:
        seen = context.decimated.weighted(reading - inner.solved.reading)
        seen = seen - q @ (q.T @ seen)
        power, along = float(seen @ seen), float(seen @ residual)
        # a step that asks for hardly any of the change is the simpler law's, seen from too far for a line to tell
        gain = along**2 / power if power > 0 and along > _HARDLY * power else 0.0
        found.append(gain if np.isfinite(seen).all() else np.inf)
    return found
