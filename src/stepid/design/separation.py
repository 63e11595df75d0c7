"""Whether a design tells two effects apart: what the wrong one leaves of a plant that has the other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stepid.core.base import Array
from stepid.design.candidate import Design, Step
from stepid.design.information import Point, information, inverted, lay_out_steps, simulated
from stepid.effects.base import Effect, Scales
from stepid.errors import ConvergenceError
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.problem import build
from stepid.simulation.model import EffectModel, PlantModel
from stepid.simulation.records import Records

_PLAINLY = 10.0  # χ² by which the right effect has to be better to be named
_CLOSE = 1e-10  # of the motion, in power: a fit without noise is near enough
_SURELY = 1.645  # standard deviations: in 95 of 100 campaigns
NEEDED = (_SURELY + math.sqrt(_SURELY**2 + _PLAINLY)) ** 2
"""Expected χ² at which noise, which spreads it by twice its root, leaves enough to name the right effect."""


@dataclass(frozen=True)
class Confusion:
    """A plant that has one effect, taken for one that has another: `plant` is the truth, `rival` what it is taken for.

    `best` are all shared parameters of the rival where it comes nearest.
    """

    plant: PlantModel
    effects: tuple[Effect, ...]
    rival: tuple[Effect, ...]
    best: Array

    def by_step(self, steps: Sequence[Step], duration: float) -> dict[Step, Array]:
        """Information of each run about the rival's parameters, and, last, what it leaves of the truth."""
        truth = simulated(self.plant, self.effects, lay_out_steps(steps, self.plant, duration))
        problem = build(truth.records, self.rival)
        local = np.zeros((problem.layout.n_run, len(steps)))
        solved = problem.solve(self.best, local)
        if solved is None:
            raise _runaway(self.rival)
        point = Point(problem, solved, self.best, local)
        return dict(zip(steps, information(point, problem.residual(solved)), strict=True))

    def fitted(self, design: Design) -> float:
        """What the rival, fitted to the design's records without noise, leaves of the truth, m²."""
        truth = simulated(self.plant, self.effects, lay_out_steps(design.steps, self.plant, design.duration))
        found = nearest(truth.records, self.rival, [self.best])
        return found.cost


def confusions(
    plant: PlantModel,
    pair: tuple[tuple[Effect, EffectModel], tuple[Effect, EffectModel | None]],
    others: tuple[Effect, ...],
    steps: Sequence[Step],
    duration: float,
    scales: Scales,
) -> list[Confusion]:
    """Both ways to take one effect for the other; the one without a size gets that at which it looks like the first.

    Parameters
    ----------
    plant : PlantModel
        With the effects that are there in any case, `others`.
    pair : two of effect and model
    others : tuple of Effect
    steps : sequence of Step
        On which the nearest rival is looked for.
    duration : float
        s.
    scales : Scales
    """
    (one, first), (two, second) = pair
    out = []
    records = lay_out_steps(steps, plant, duration)
    with_first = plant.model_copy(update={"effects": (*plant.effects, first)})
    truth = simulated(with_first, (*others, one), records)
    nearby = nearest(truth.records, (*others, two), _starts(with_first, truth, two, scales))
    if one.name not in two.contains:
        out.append(Confusion(with_first, (*others, one), (*others, two), nearby.shared))
    if two.name not in one.contains:
        if second is None:
            values = nearby.shared[nearby.problem.layout.values[-1]]
            named = zip(two.parameters, map(float, values), strict=True)
            second = EffectModel(name=two.name, values={q.name: v for q, v in named})
        with_second = plant.model_copy(update={"effects": (*plant.effects, second)})
        other = simulated(with_second, (*others, two), records)
        back = nearest(other.records, (*others, one), _starts(with_second, other, one, scales))
        out.append(Confusion(with_second, (*others, two), (*others, one), back.shared))
    return out


def _starts(plant: PlantModel, truth: Point, rival: Effect, scales: Scales) -> list[Array]:
    common = truth.shared[: truth.problem.layout.values[-1].start]
    return [np.concatenate([common, values]) for values in rival.starts(scales)]


def nearest(records: Records, effects: tuple[Effect, ...], starts: Sequence[Array]) -> Optimum:
    """Fit effects to records from some starts; the best end.

    Raises
    ------
    stepid.errors.ConvergenceError
        If all of them run away.
    """
    problem = build(records, effects)
    local = np.zeros((problem.layout.n_run, len(records.runs)))
    least = _CLOSE * float(np.sum(records.weighted(records.position) ** 2))
    ends = [minimize(problem, start, local, tolerance=least) for start in starts]
    found = [end for end in ends if end is not None]
    if not found:
        raise _runaway(effects)
    return min(found, key=lambda end: end.cost)


def _runaway(effects: tuple[Effect, ...]) -> ConvergenceError:
    names = ", ".join(effect.name for effect in effects)
    return ConvergenceError(f"no plant with {names} follows these steps", "Give smaller levels, or another pair.")


def expected(steps: Sequence[Step], known: Mapping[Step, Array], *, variance: float) -> float:
    """χ² that the rival leaves in some runs, to first order about where it comes nearest."""
    total = np.sum([known[step] for step in steps], axis=0)
    inverse, _ = inverted(total[:-1, :-1])
    left = float(total[-1, -1] - total[-1, :-1] @ inverse @ total[:-1, -1])
    return max(left, 0.0) / variance

