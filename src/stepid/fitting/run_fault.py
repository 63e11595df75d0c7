"""One run that one deviation sets apart: a wrong label, mass, scale, sign or start. An accusation needs a size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.deviations import FAULTS, promised, promised_by, with_fault
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.problem import fixes_mass
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.run_fault_size import (
    DECIDES,
    REACHED,
    noise_cost,
    noise_level,
    scatter_of_others,
    standard_error,
)
from stepid.fitting.run_fault_words import DRIFT, ROUND, UNITS, fault_words
from stepid.simulation.records import Records
from stepid.simulation.simulator import Simulator

_WORTH = {"added_mass": 0.02, "stiffness": 0.05, "damping": 0.05, "gain": 0.03, "start_time": 1.0}
# worth mentioning, as a share of the run's stiffness, damping and gain, and in samples; of the moving mass, by which a
# run would have to weigh less than none
_HINT = 0.15  # share of the misfit that a linearized step must promise: a fault takes 0.7, a step tells a quarter of it
_TRIED = 6  # fits
_STANDS_OUT = 0.3  # share of the cost left, by far less than by any other run's fault, where more is missing
_NEAR, _ROUGH = 0.03, 0.15  # relative, of a factor to a round one: linear plants, plants with effects
_SHARED = 0.5  # share of a run's gain by a drift that a drift in all runs may have
_GROSS = 5.0  # times the floor, misfit that no curve of the drive turns into noise by one mass or stiffness
_ALIKE = 0.3  # relative difference of inputs that are of one size
_UNIT, _SHARP = 0.05, 1e-6  # χ², and share of the cost, that no longer matter to a fit
_ROUNDS, _SETTLED = 6, 1e-3  # of a drift's rate and the plant in turn; its relative change at the end


@dataclass(frozen=True)
class _Found:
    """A fault's fit: what it changes, by how much, and the cost [m²] left."""

    run: int
    kind: str
    size: float
    error: float  # of the size, at the level of the residual
    scatter: float  # of the same deviation over the other runs
    optimum: Optimum

    @property
    def cost(self) -> float:
        return self.optimum.cost


class Accusation(NamedTuple):
    """A fault of one run, and the cost [m²] that all records leave with it mended."""

    fault: RecordFault
    cost: float


def find_fault(optimum: Optimum, floor: float, *, sure: float = 5.0) -> RecordFault | None:
    """Find the run that one deviation brings in line with the others; see `accuse`."""
    found = accuse(optimum, floor, sure=sure)
    return None if found is None else found.fault


def accuse(optimum: Optimum, floor: float, *, sure: float = 5.0, patterned: bool = False) -> Accusation | None:
    """Find the run that one deviation brings in line with the others.

    Parameters
    ----------
    optimum : Optimum
        A fit to all runs, of the linear plant or with effects.
    floor : float
        m, noise floor.
    sure : float
        Times what the other runs scatter by, and its own standard error, that a fault must be.
    patterned : bool
        Whether the rest has a pattern beside white noise: it counts below the floor, too, known to a few per cent.

    Returns
    -------
    Accusation or None
        None where no fault is as large as that, worth mentioning, and explains the misfit. `kind` is
        ``"added_mass"`` [kg], ``"stiffness"`` [N/m], ``"damping"`` [N·s/m] (what the run has less what its record
        says), ``"gain"`` (factor on its readings), ``"start_time"`` [s] or ``"sensor_drift"`` [m/s].
    """
    records = optimum.problem.records
    excess = optimum.cost - (REACHED * floor) ** 2 * records.weighed_size
    if patterned:
        excess = max(excess, (sure * floor) ** 2 / _HINT)
    if len(records.runs) < 3 or excess <= 0:
        return None
    found = _all_fitted(optimum, _candidates(optimum, excess), floor)
    level = max(floor, np.sqrt(found[0].cost / records.weighed_size)) if found else floor
    close = [f for f in found if f.cost < found[0].cost + DECIDES * level**2]  # a worse explanation is none
    for best in close:
        others = [f for f in found if f.run != best.run]
        if not (_has_size(best, sure) and _explains(best, optimum, others, floor)):
            continue
        near = best.cost + DECIDES * level**2
        rivals = dict.fromkeys(records.runs[f.run].name for f in others if f.cost < near and _has_size(f, sure))
        fault = RecordFault(
            run=records.runs[best.run].name,
            kind=best.kind,
            size=told(best.optimum, best.run, best.kind, best.size),
            unit=UNITS[best.kind],
            words=fault_words(
                best.optimum,
                best.run,
                best.kind,
                best.size,
                tuple(rivals),
                agree=best.cost <= noise_cost(records, floor),
            ),
        )
        last = best.optimum
        done = minimize(last.problem, last.shared, last.local, tolerance=_UNIT * floor**2)  # for a cost to compare
        return Accusation(fault, best.cost if done is None else min(best.cost, done.cost))
    return None


def _all_fitted(optimum: Optimum, candidates: list[tuple[int, str]], floor: float) -> list[_Found]:
    """Fit each fault, the best first; none where no fit comes near what would explain the misfit, see `_explains`."""
    aim = max(_STANDS_OUT * optimum.cost, noise_cost(optimum.problem.records, floor))
    tried = [_fitted(optimum, run, kind, floor, aim) for run, kind in candidates]
    found = [f for f in tried if f is not None]
    if not any(f.cost <= aim for f in found):
        return []
    ended = [f if f.cost <= aim or f.optimum.converged else _fitted(optimum, f.run, f.kind, floor) for f in found]
    return sorted((f for f in ended if f is not None), key=lambda f: f.cost)


def _candidates(optimum: Optimum, excess: float) -> list[tuple[int, str]]:
    """Runs and kinds whose fit is worth the time, most promising first."""
    records = optimum.problem.records
    kinds = [k for k in FAULTS if k != "added_mass" or fixes_mass(records) is None]
    every = [(run, kind) for run in range(len(records.runs)) for kind in kinds]
    steps = promised(optimum, every)
    gains = {key: steps[key].gain for key in every if key in steps}
    everywhere = float(promised_by(optimum, records.weighted(records.time)[:, None])[0][0])
    drifts = {(run, DRIFT): float(gain) for run, gain in enumerate(_drifts(optimum)[0])}
    gains |= {key: gain for key, gain in drifts.items() if everywhere < _SHARED * gain}
    return sorted((key for key, gain in gains.items() if gain > _HINT * excess), key=lambda key: -gains[key])[:_TRIED]


def _tolerance(optimum: Optimum, floor: float) -> float:
    """Predicted decrease of the cost that does not matter [m²]."""
    return max(_UNIT * floor**2, _SHARP * optimum.cost)


def _fitted(optimum: Optimum, run: int, kind: str, floor: float, aim: float = np.inf) -> _Found | None:
    """Fit all runs with one fault in one of them; `aim` as in `minimize`."""
    if kind == DRIFT:
        return _drifted(optimum, run, floor)
    problem = with_fault(optimum.problem, run, kind)
    row = problem.layout.deviation(kind)
    tolerance = _tolerance(optimum, floor)
    aim = np.inf if kind == "gain" else aim  # a round factor may come from a rough one
    found = minimize(problem, optimum.shared, optimum.local, tolerance=tolerance, aim=aim)
    if found is None:
        return None
    size = float(found.local[row, run])
    if kind == "gain":
        better = _rescaled(optimum, run, 1.0 + size, tolerance)
        if better is not None and better[1].cost < found.cost:
            size, found = better[0] - 1.0, better[1]
    error = standard_error(found, optimum.problem, run, kind, floor)
    return _Found(run, kind, size, error, scatter_of_others(found, run, kind), found)


def _rescaled(optimum: Optimum, run: int, factor: float, tolerance: float) -> tuple[float, Optimum] | None:
    """Fit with the readings of a run divided by the nearest round factor: with effects that is no matter of gain."""
    effects = optimum.problem.simulator.effects
    near = [r for r in ROUND if abs(factor / r - 1) < _ROUGH]
    if not effects or not near:
        return None
    nearest = min(near, key=lambda r: abs(factor / r - 1))
    records = optimum.problem.records
    own = records.pieces()[run]
    position, weight = records.position.copy(), records.weight.copy()
    position[own] /= nearest
    weight[own] *= abs(nearest)  # its noise is divided, too
    found = _refit(optimum, replace(records, position=position, weight=weight), tolerance)
    return None if found is None else (nearest, found)


def _refit(optimum: Optimum, records: Records, tolerance: float) -> Optimum | None:
    sim = optimum.problem.simulator
    other = Simulator(records, sim.effects, sim.tolerance, workers=sim.workers, patience=sim.patience)
    return minimize(replace(optimum.problem, simulator=other), optimum.shared, optimum.local, tolerance=tolerance)


def _drifts(optimum: Optimum) -> tuple[Array, Array, Array]:
    """Of a drifting zero in each run alone: promised gain [m²], rate [m/s], its error per meter of noise."""
    records = optimum.problem.records
    clocks = np.where(np.arange(len(records.runs))[:, None] == records.run, records.time, 0.0)
    return promised_by(optimum, records.weighted(clocks).T)


def _drifted(optimum: Optimum, run: int, floor: float) -> _Found | None:
    """Fit with a drift of one run's zero: its rate and the plant in turn, until the rate stays."""
    records, total, found = optimum.problem.records, 0.0, optimum
    own = records.pieces()[run]
    for _ in range(_ROUNDS):
        rate = float(_drifts(found)[1][run])
        total += rate
        position = records.position.copy()
        position[own] -= total * records.time[own]
        again = _refit(found, replace(records, position=position), _tolerance(found, floor))
        if again is None:
            return None
        found = again
        if abs(rate) < _SETTLED * abs(total):
            break
    _, rates, errors = _drifts(found)
    error, scatter = float(errors[run]) * noise_level(found, floor), float(np.std(np.delete(rates, run), ddof=1))
    return _Found(run, DRIFT, total, error, scatter, found)


def _has_size(found: _Found, sure: float) -> bool:
    """Tell whether a fault is beyond what the other runs and its error allow, and worth mentioning in its unit."""
    size = abs(found.size)
    if size < sure * max(found.error, found.scatter):
        return False
    if found.kind == DRIFT:
        return True
    records = found.optimum.problem.records
    if found.kind == "added_mass":
        change = told(found.optimum, found.run, found.kind, found.size)
        return not (may_be_weights(records, change, sure) or less_than_none(found.optimum, found.run, found.size))
    unit = float(records.sample_time[found.run]) if found.kind == "start_time" else 1.0
    return size >= _WORTH[found.kind] * unit


def _explains(found: _Found, optimum: Optimum, others: list[_Found], floor: float) -> bool:
    """Tell whether a fault leaves nothing but noise, or stands out where more is missing in all runs.

    A law that bends with the amplitude gives the run with the largest or smallest input a plant of its own.
    """
    records, effects = optimum.problem.records, optimum.problem.simulator.effects
    samples = records.weighed_size
    at_floor = found.cost <= noise_cost(records, floor)
    round_ = found.kind == "gain" and any(abs((1 + found.size) / r - 1) < _NEAR for r in ROUND)
    if found.kind != DRIFT and not round_ and is_witness(records, found.run, beside=effects):
        hard = found.kind not in ("gain", "damping") and optimum.cost > (_GROSS * floor) ** 2 * samples
        return at_floor and hard
    second = min((f.cost for f in others), default=np.inf)
    return at_floor or found.cost <= _STANDS_OUT * min(optimum.cost, second)


def may_be_weights(records: Records, size: float, sure: float) -> bool:
    """Tell whether an added mass is off by no more than its weights may be [kg], which is no fault."""
    return abs(size) < sure * records.weight_uncertainty


def less_than_none(optimum: Optimum, run: int, size: float) -> bool:
    """Tell whether a run would have to have a weight less than none added, by more than is worth mentioning."""
    records = optimum.problem.records
    worth = _WORTH["added_mass"] * float(optimum.problem.layout.mass(optimum.shared)[run])
    return bool(records.added_mass[run] + size < -max(worth, records.weight_uncertainty))


def is_witness(records: Records, run: int, *, beside: Sequence[Effect]) -> bool:
    """Tell whether a run alone shows what a law does at its input, or a release at its travel: no other is near it.

    Beside effects any such run: without it another law is as good. Beside a linear plant that of the largest or
    smallest: what is linear below and above is so in between.
    """
    others = np.arange(len(records.runs)) != run
    if records.driven[run]:
        sizes = np.maximum.reduceat(np.abs(records.volts - records.before[records.run]), records.first)
        others &= records.driven
    else:
        sizes = np.array([np.ptp(records.position[piece]) for piece in records.pieces()])
    own, others = sizes[run], sizes[others]
    if np.any(np.abs(others - own) < _ALIKE * own):
        return False
    return bool(beside or np.all(others > own) or np.all(others < own))


def told(optimum: Optimum, run: int, kind: str, size: float) -> float:
    """Size of a deviation in the unit that users know: labels in N/m and N·s/m, scales as the factor.

    No weight is less than none: a run without one has no wrong one, whatever would fit.
    """
    of, records, shared = optimum.problem.layout, optimum.problem.records, optimum.shared
    if kind == "stiffness":
        return size * float(shared[of.stiffness][records.spring[run]])
    if kind == "damping":
        return size * float(shared[of.damping][records.damper[run]])
    if kind == "added_mass":
        return max(size, -float(records.added_mass[run]))
    return 1.0 + size if kind == "gain" else size
