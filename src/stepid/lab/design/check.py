"""A plan's prediction beside what simulated campaigns give."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stepid.core.base import Array, Model, NonNegative
from stepid.core.mass_offset import weight_parts
from stepid.core.quantities import quantities_of
from stepid.core.tables import text_table
from stepid.effects import resolve
from stepid.errors import InputError
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.problem import build
from stepid.lab.design.guess import parameter_values
from stepid.lab.design.information import (
    Point,
    information,
    inverted,
    lay_out_steps,
    simulated,
    with_weights,
)
from stepid.simulation.records import Records
from stepid.simulation.threads import single_threaded

if TYPE_CHECKING:
    from stepid.lab.design.result import Plan

_FEWEST = 10
_LAPS = 20


class PlanCheck(Model):
    """Scatter of the estimates over simulated campaigns.

    Parameters
    ----------
    count : int
        Campaigns that were fitted.
    scatter : mapping
        Parameter to the root mean square of estimate minus truth, in its unit.
    predicted : mapping
        The plan's standard uncertainty.
    units : mapping
        Parameter to its unit.
    """

    count: int
    scatter: Mapping[str, NonNegative]
    predicted: Mapping[str, NonNegative]
    units: Mapping[str, str] = {}

    @property
    def ratio(self) -> dict[str, float]:
        """Scatter over prediction; 1 but for chance, a share of 0.7/√count."""
        return {name: self.scatter[name] / spread for name, spread in self.predicted.items() if spread}

    def summary(self) -> str:
        """Return scatter and prediction as a table."""
        rows = [
            [name, f"{self.predicted[name]:.3g}", f"{self.scatter[name]:.3g}", self.units.get(name, ""), f"{ratio:.2f}"]
            for name, ratio in self.ratio.items()
        ]
        header = ["parameter", "predicted", "scatter", "unit", "ratio"]
        return text_table(header, rows, title=f"{self.count} campaigns")

    def __str__(self) -> str:
        return self.summary()


@single_threaded
def check(plan: Plan, *, count: int, seed: int) -> PlanCheck:
    """Simulate the advice `count` times and fit each; see `Plan.check`."""
    for name, given, least in (("count", count, _FEWEST), ("seed", seed, 0)):
        if not isinstance(given, int) or isinstance(given, bool) or given < least:
            raise InputError(f"{name} = {given!r} cannot be", f"Give a whole number, {least} or more.")
    design, stream = plan.advice, np.random.default_rng(seed)
    effects = resolve([e.name for e in plan.plant.effects])
    truth = simulated(plan.plant, effects, lay_out_steps(design.steps, plan.plant, design.duration))
    parts = weight_parts(np.array(design.added_masses), plan.weight_uncertainty)
    sim, offset = truth.problem.simulator, truth.problem.layout.deviation("added_mass")
    ends = []
    for _ in range(count):
        local = truth.local.copy()
        local[offset] = parts @ stream.standard_normal(parts.shape[1])
        reading = sim.readings(truth.shared[None], local[None])[0]
        end = refitted(plan, truth, reading + _noise(plan, truth.records, stream))
        if end is not None:
            ends.append(end)
    error = np.sqrt(np.mean((np.array(ends) - truth.shared) ** 2, axis=0))
    own = quantities_of(plan)
    units = {name: own.unit(unit) for name, (_, unit) in parameter_values(plan.plant, effects).items()}
    predicted = {name: spread for name, spread in design.uncertainty.items() if spread is not None}
    scatter = {name: float(e) for name, e in zip(units, error, strict=True) if name in predicted}
    return own.bear(PlanCheck(count=len(ends), scatter=scatter, predicted=predicted, units=units))


def refitted(plan: Plan, truth: Point, position: Array) -> Array | None:
    """Fit the advice's records, begun at the truth, the errors of the weights too; None where the fit runs away.

    Parameters
    ----------
    plan : Plan
    truth : Point
        The guessed plant on the advice's runs.
    position : array, shape (S,)
        m, what was read in all runs.
    """
    noisy = replace(truth.records, position=position)
    found = minimize(build(noisy, truth.problem.simulator.effects), truth.shared, truth.local, iterations=_LAPS)
    if found is None:
        return None
    parts = weight_parts(np.array(plan.advice.added_masses), plan.weight_uncertainty)
    variance = plan.variance(plan.advice.sample_time)
    point = Point(found.problem, found.solved, found.shared, found.local)
    tables = information(point, found.problem.residual(found.solved))
    inverse, _ = inverted(with_weights([table[:-1, :-1] for table in tables], parts, variance))
    pull = np.array([table[:-1, -1] for table in tables])
    step = inverse @ np.concatenate([pull.sum(axis=0), parts.T @ pull[:, 0]]) / variance
    out: Array = found.shared + step[: found.shared.size]
    return out


def _noise(plan: Plan, records: Records, stream: np.random.Generator) -> Array:
    white = plan.noise * stream.standard_normal(records.size)
    if not plan.noise_time:
        return white
    kept = math.exp(-plan.advice.sample_time / plan.noise_time)
    out = white.copy()
    for piece in records.pieces():
        for i in range(piece.start + 1, piece.stop):
            out[i] = kept * out[i - 1] + math.sqrt(1 - kept**2) * white[i]
    return out
