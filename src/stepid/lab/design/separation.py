"""Whether a design tells two effects apart: what the wrong one leaves of a plant that has the other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stepid.core.base import Array
from stepid.core.latex import parameter_name
from stepid.effects.base import Effect, Scales
from stepid.errors import ConvergenceError
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.problem import build
from stepid.lab.design.candidate import Design, Step
from stepid.lab.design.information import Point, information, inverted, lay_out_steps, simulated
from stepid.simulation.model import EffectModel, PlantModel
from stepid.simulation.records import Records

_PLAINLY = 10.0  # χ² by which the right effect has to be better to be named
_ALIKE = 1e-6  # of what a fit without the effect leaves, in power: the rival is the same law
_ROUNDS, _FACTOR = 3, 5.0  # by which a size is found, each at most by this factor
_DIFFER = ("gain", "damping", "start_time")  # what `stepid.diagnose` lets runs differ in before it names an effect
_CLOSE = 1e-10  # of the motion, in power: a fit without noise is near enough
_SURELY = 1.645  # standard deviations: in 95 of 100 campaigns
NEEDED = (_SURELY + math.sqrt(_SURELY**2 + _PLAINLY)) ** 2
"""Expected χ² at which noise, which spreads it by twice its root, leaves enough to name the right effect."""

VISIBLE = 1.1
"""Times the noise that a fit without the effects must leave: at 1.05 `stepid.diagnose` calls it adequate."""


@dataclass(frozen=True)
class Confusion:
    """A plant that has an effect, taken for one that has another, none, or differs from run to run.

    `plant` and `effects` are the truth, `rival` what is fitted to it, `best` its shared parameters where it comes
    nearest. `differs` is the deviation, as in `stepid.simulation.layout.DEVIATIONS`, that is free in every run.
    """

    plant: PlantModel
    effects: tuple[Effect, ...]
    rival: tuple[Effect, ...]
    best: Array
    differs: str = ""

    def by_step(self, steps: Sequence[Step], duration: float) -> dict[Step, Array]:
        """Information of each run about the rival's parameters, and, last, what it leaves of the truth."""
        truth = simulated(self.plant, self.effects, lay_out_steps(steps, self.plant, duration))
        problem = _problem(truth.records, self.rival, self.differs)
        local = np.zeros((problem.layout.n_run, len(steps)))
        solved = problem.solve(self.best, local)
        if solved is None:
            raise _runaway(self.rival)
        point = Point(problem, solved, self.best, local)
        return dict(zip(steps, information(point, problem.residual(solved)), strict=True))

    @property
    def plain(self) -> bool:
        """Whether it is taken for a plant without either effect, the same in every run."""
        return len(self.rival) < len(self.effects) and not self.differs

    def fitted(self, design: Design) -> float:
        """What the rival, fitted to the design's records without noise, leaves of the truth, m²."""
        truth = simulated(self.plant, self.effects, lay_out_steps(design.steps, self.plant, design.duration))
        return nearest(truth.records, self.rival, [self.best], self.differs).cost

    def price(self, runs: int, samples: int) -> float:
        """What the rival pays for the more parameters that it has than the truth, in χ² (BIC)."""
        if not self.differs:
            return 0.0
        free = runs - (self.differs != "start_time")  # a gain or damping that all share is no difference
        return (free - len(self.effects[-1].parameters)) * math.log(samples)


def _problem(records: Records, effects: tuple[Effect, ...], differs: str) -> Problem:
    problem = build(records, effects)
    if not differs:
        return problem
    active = problem.active.copy()
    active[problem.layout.deviation(differs)] = True
    return replace(problem, active=active)


def confusions(
    plant: PlantModel,
    pair: tuple[tuple[Effect, EffectModel], tuple[Effect, EffectModel | None]],
    others: tuple[Effect, ...],
    steps: Sequence[Step],
    duration: float,
    scales: Scales,
) -> tuple[list[Confusion], tuple[EffectModel, EffectModel]]:
    """Both ways to take one effect for the other, and each for none; the one without a size gets a comparable one.

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
    records = lay_out_steps(steps, plant, duration)
    sized = [(one, first), (two, second or _as_plain(plant, others, (one, first), two, records, scales))]
    out = []
    for (true, model), (wrong, _) in (sized, sized[::-1]):
        there = plant.model_copy(update={"effects": (*plant.effects, model)})
        truth = simulated(there, (*others, true), records)
        common = truth.shared[: truth.problem.layout.values[-1].start]
        plain = nearest(truth.records, others, [common])
        out += [Confusion(there, (*others, true), others, plain.shared, what) for what in ("", *_DIFFER)]
        starts = [np.concatenate([common, values]) for values in wrong.starts(scales)]
        best = nearest(truth.records, (*others, wrong), starts)
        alike = best.cost < _ALIKE * plain.cost
        if not alike or len(wrong.parameters) <= len(
            true.parameters
        ):  # of a law and a more general one the first is named
            out.append(Confusion(there, (*others, true), (*others, wrong), best.shared))
    return out, (sized[0][1], sized[1][1])


def _as_plain(
    plant: PlantModel,
    others: tuple[Effect, ...],
    known: tuple[Effect, EffectModel],
    other: Effect,
    records: Records,
    scales: Scales,
) -> EffectModel:
    """An effect at the size at which a fit without it leaves as much as one without the known effect."""

    def left(effect: Effect, model: EffectModel) -> float:
        there = plant.model_copy(update={"effects": (*plant.effects, model)})
        truth = simulated(there, (*others, effect), records)
        common = truth.shared[: truth.problem.layout.values[-1].start]
        return nearest(truth.records, others, [common]).cost

    def of(values: tuple[float, ...]) -> EffectModel:
        named = zip(other.parameters, map(float, values), strict=True)
        return EffectModel(name=other.name, values={q.name: value for q, value in named})

    wanted, values = left(*known), tuple(other.starts(scales)[0])
    for _ in range(_ROUNDS):
        share = math.sqrt(wanted / max(left(other, of(values)), 1e-300))
        values = other.faint(values, min(max(share, 1 / _FACTOR), _FACTOR))
    return of(values)


def nearest(records: Records, effects: tuple[Effect, ...], starts: Sequence[Array], differs: str = "") -> Optimum:
    """Fit effects to records from some starts; the best end.

    Raises
    ------
    stepid.errors.ConvergenceError
        If all of them run away.
    """
    problem = _problem(records, effects, differs)
    local = np.zeros((problem.layout.n_run, len(records.runs)))
    least = _CLOSE * float(np.sum(records.weighted(records.position) ** 2))
    ends = [minimize(problem, start, local, tolerance=least) for start in starts]
    found = [end for end in ends if end is not None]
    if not found:
        raise _runaway(effects)
    return min(found, key=lambda end: end.cost)


def _runaway(effects: tuple[Effect, ...]) -> ConvergenceError:
    names = " and ".join(parameter_name(effect.name) for effect in effects)
    return ConvergenceError(f"no plant with {names} follows these steps", "Give smaller levels, or another pair.")


def apart(ways: Sequence[Confusion], left: Sequence[float], *, variance: float, design: Design) -> tuple[float, float]:
    """The least χ² by which a rival is worse than the truth, and what no effect at all leaves over the noise.

    `left` is what each rival leaves of the truth without noise, m².
    """
    each = [(way, value / variance) for way, value in zip(ways, left, strict=True)]
    worse = min(chi + way.price(design.runs, design.samples) for way, chi in each if not way.plain)
    missed = min(chi for way, chi in each if way.plain)
    return max(worse, 0.0), math.sqrt(1 + missed / design.samples)


def expected(steps: Sequence[Step], known: Mapping[Step, Array]) -> float:
    """What the rival leaves of the truth in some runs, m², to first order about where it comes nearest."""
    total = np.sum([known[step] for step in steps], axis=0)
    inverse, _ = inverted(total[:-1, :-1])
    return max(float(total[-1, -1] - total[-1, :-1] @ inverse @ total[:-1, -1]), 0.0)
