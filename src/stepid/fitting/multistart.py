"""What fits of one campaign share: its records and noise, the linear fit, and where a fit with effects may start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Motion, Regressor, Scales
from stepid.fitting.covariance import by_weights
from stepid.fitting.decimation import decimated, fit_coarsely, shortest_period
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.noise_color import NoiseColor
from stepid.fitting.noise_floor import least_floor
from stepid.fitting.problem import fixes_mass, scales
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.spectrum import strongest_period
from stepid.fitting.tangent import Tangent
from stepid.fitting.weak_form import WeakForm, measured_motion
from stepid.simulation.records import Records

_SLIGHT = 0.003  # share of what is left above the floor, that no step needs to promise while others may do better


class Scored(NamedTuple):
    """A start of one effect on a fit: the part of the cost that it could remove [m²], the fit's parameters then.

    `shared` are all shared parameters of that fit, those of its own effects among them (`layout.linear`,
    `layout.values`). `left` is the cost that would be left, m².
    """

    effect: Effect
    values: tuple[float, ...]
    gain: float
    shared: Array
    left: float


class Start(NamedTuple):
    """Where a fit starts: the linear plant's shared parameters, and the values of each effect's, in their order.

    Also how far from rest each run starts [m], NaN where that is not known.
    """

    linear: Array
    values: tuple[tuple[float, ...], ...]
    displacement: Array | None = None


class FitContext:
    """What every search on one campaign shares: records, linear fit, scales, the weak form, the measured motion.

    Candidates race on `decimated`, a part of the samples; `coarse_linear` is the linear plant there. `faults` of the
    readings are removed already; `colored` is set where their noise is not white; `notes` say what was left out of the
    records. `first` are linear fit and floor before the residual of an answer said more of the readings.
    """

    def __init__(
        self,
        records: Records,
        linear: Optimum,
        floor: float,
        *,
        workers: int = 1,
        faults: tuple[RecordFault, ...] = (),
        colored: NoiseColor | None = None,
        first: tuple[Optimum, float] | None = None,
        notes: tuple[str, ...] = (),
    ) -> None:
        self.records, self.linear, self.floor, self.workers = records, linear, floor, workers
        self.faults, self.colored, self.first, self.notes = faults, colored, first or (linear, floor), notes
        self.scales: Scales = scales(records, linear, floor)
        self._scanned: dict[Effect, list[Regressor]] = {}
        self.columns: dict[Effect, list[Any]] = {}  # of `score_test`, kept for the next race
        self.responses: dict[tuple[Effect, tuple[float, ...]], Array | None] = {}  # to single starts, kept likewise
        self.joint: dict[Any, Any] = {}  # scores of sets, kept likewise
        self.laws: list[tuple[Optimum, Records, Any]] = []  # of any shape, in what a fit leaves, kept likewise
        self.period = period = strongest_period(records)
        self.measured: Motion = measured_motion(records, linear.shared, floor, period)
        self.motion = self.measured
        if linear.rms < 4 * floor:  # the fit is better known than the noisy velocity
            x, v = linear.solved.states[:2]
            self.motion = self.motion._replace(v=v, sign=np.where(v < 0, -1.0, 1.0))
            if linear.rms**2 < 2 * floor**2:  # it misses the position by less than the noise does
                self.motion = self.motion._replace(x=x)
        self.coarse_linear = fit_coarsely(decimated(records, linear, shortest_period(linear), floor), linear)
        self.decimated = self.coarse_linear.problem.records
        self._tangents: dict[Optimum, Tangent] = {}
        self.weak = WeakForm(records, 0.6 * period, fixed_mass=fixes_mass(records))

    @cached_property
    def by_weights(self) -> Optimum | None:
        """The linear plant with the most likely added masses, where errors of these leave only noise."""
        return by_weights(*self.first)

    @cached_property
    def rounding(self) -> float:
        """RMS that rounding leaves at least, m: a fit that leaves less follows the steps of the sensor."""
        return least_floor(self.records)

    @cached_property
    def rounding_cost(self) -> float:
        """Cost of all samples that rounding leaves at least, m²: less is no evidence."""
        return self.records.weighed_size * self.rounding**2

    @property
    def dithered(self) -> bool:
        """Whether rounding is noise, too: the sensor's own is half a step or more (Widrow 1956, IRE Trans. CT-3)."""
        return self.floor >= 2 * self.rounding

    @cached_property
    def noise_cost(self) -> float:
        """Cost of a perfect model in the race, m²."""
        square = self.records.weight**2
        return float((square if self.decimated.at is None else square[self.decimated.at]).sum()) * self.floor**2

    @cached_property
    def noise_limit(self) -> float:
        """Cost in the race below which nothing but noise is left, m²: the noise's own scatter above its cost."""
        return (1.05 + 3.0 / math.sqrt(2.0 * self.decimated.size)) ** 2 * self.noise_cost

    @cached_property
    def unit(self) -> float:
        """Cost in the race of one unit of χ² in all samples, m²."""
        return self.decimated.weighed_size / self.records.weighed_size * self.floor**2

    @cached_property
    def full_noise_cost(self) -> float:
        """Cost of a perfect model in all samples, m²."""
        return self.records.weighed_size * self.floor**2

    @property
    def tolerance(self) -> float:
        """Predicted decrease of the cost that no longer matters, m²."""
        return 0.05 * self.floor**2

    def slight_beside(self, excess: float) -> float:
        """Predicted decrease of the cost that no longer matters beside so much left above the floor, m²."""
        return max(self.tolerance, _SLIGHT * excess)

    def slight(self, optimum: Optimum) -> float:
        """The same beside what a fit to all samples leaves."""
        return self.slight_beside(optimum.cost - self.full_noise_cost)

    def tangent(self, base: Optimum) -> Tangent:
        """What a fit in the race can follow, kept for the next of many starts from it."""
        if base not in self._tangents:
            self._tangents[base] = Tangent(base)
        return self._tangents[base]

    def regressors(self, effect: Effect, scales: Scales) -> Sequence[Regressor]:
        """What to try of an effect; of a scan the deepest valleys of what the weak form leaves, each a basin."""
        if not effect.repeats:
            return effect.regressors(scales, self.motion)
        if effect not in self._scanned:
            self._scanned[effect] = self.weak.deepest(effect.regressors(scales, self.motion))
        return self._scanned[effect]

    def weak_starts(self, effect: Effect, count: int) -> list[Start]:
        """Best starts of one effect by linear least squares on the weak form."""
        found = []
        for regressor in self.regressors(effect, self.scales):
            solution = self.weak.solve(regressor.forces)
            if solution is None:
                continue
            if (values := regressor.values(solution.coefficients)) is not None:
                found.append((solution.left, Start(solution.shared, (values,))))
        found.sort(key=lambda item: item[0])
        return [start for _, start in found[:count]]
