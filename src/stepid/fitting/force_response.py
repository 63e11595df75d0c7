"""How a plant answers to added forces: the linear one, or a fitted one where it swings out of step with that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.simulation.records import Records
from stepid.simulation.simulator import Simulator

_AT_ONCE = 8  # forces whose responses are simulated together
_ASTRAY = 0.2  # share of the motion that the linear plant leaves, beyond which it swings out of step
_SLIGHT = 1e-4  # of the spring's largest force: a force that hardly changes the motion


def force_responses(context: FitContext, forces: list[Array]) -> Array:
    """Reading's response of the linear plant to added forces, shapes (S,) each to (S, n)."""
    linear, records = context.outline, context.sketch
    free = np.append(linear.shared[:-1], 1.0)
    out = np.empty((len(forces), records.size))
    for i in range(0, len(forces), _AT_ONCE):  # the plant driven by the forces, in N, beside each other
        some = forces[i : i + _AT_ONCE]
        pushed = records.repeated(len(some)).with_input(np.concatenate([_means(force, records) for force in some]))
        pushed = replace(pushed, before=np.zeros(len(pushed.runs)))
        still = np.zeros((1, linear.local.shape[0], len(pushed.runs)))
        out[i : i + len(some)] = Simulator(pushed, ()).readings(free[None], still).reshape(len(some), -1)
    return out.T


def _means(force: Array, records: Records) -> Array:
    """Mean of a force, given at all samples, from each sample of a sketch to the next, shape (S,)."""
    between = 0.5 * (force[:-1] + force[1:])
    if records.at is not None:
        sums = np.concatenate([[0.0], np.cumsum(between)])
        between = np.diff(sums[records.at]) / np.diff(records.at)
    return np.append(between, 0.0)


def responses_along(base: Optimum, context: FitContext, forces: list[Array]) -> Array:
    """Reading's response of a fitted plant to slight added forces, per newton, shapes (S,) each to (S, n)."""
    problem, records = base.problem, context.sketch
    of, gain = problem.layout, float(base.shared[problem.layout.force_gain])
    stiffness = float(base.shared[of.stiffness].mean())
    shared = base.shared.copy()
    if gain == 0:
        shared[of.force_gain] = gain = 1.0
    out = np.empty((len(forces), records.size))
    for i in range(0, len(forces), _AT_ONCE):
        some = [_means(force, records) for force in forces[i : i + _AT_ONCE]]
        sizes = [_SLIGHT * stiffness * problem.simulator.scale / max(float(np.abs(f).max()), 1e-300) for f in some]
        volts = np.concatenate([records.volts + size * f / gain for size, f in zip(sizes, some, strict=True)])
        pushed = records.repeated(len(some)).with_input(volts)
        readings = Simulator(pushed, problem.simulator.effects).readings(
            shared[None], np.tile(base.local, len(some))[None]
        )
        changed = readings.reshape(len(some), -1) - Simulator(records, problem.simulator.effects).readings(
            base.shared[None], base.local[None]
        )
        out[i : i + len(some)] = changed / np.array(sizes)[:, None]
    return out.T


def astray(context: FitContext, base: Optimum) -> bool:
    """Tell whether the linear plant swings so unlike a fit that its response to a force is not the plant's."""
    effects = base.problem.simulator.effects
    if any(type(e).drive is not Effect.drive or type(e).delay is not Effect.delay for e in effects):
        return False
    records = context.records
    motion = float(np.linalg.norm(records.weighted(records.position)))
    return bool(effects) and float(np.sqrt(context.linear.cost)) > _ASTRAY * motion
