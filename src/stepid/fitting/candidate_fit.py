"""The fit of one set of effects in the race: its starts side by side, the best run on, then fitted to all samples."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.deviations import with_deviations
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.multistart import FitContext, Start
from stepid.fitting.multistart_modes import adapted, stronger
from stepid.fitting.multistart_sticking import other_sticking, other_turns
from stepid.fitting.problem import build, phase_rows, start_local, start_phases
from stepid.simulation.simulator import COARSE

_SAME = 0.01  # share of what is left above the floor, by which two ends are one
_SHORT = 2.5e5  # steps times states, of a fit in the race: some 30 ms
_FAR = 1e2  # m, beyond which a plant runs away
_POOR = 0.1  # share of what is left to gain that the best of many starts must take away, for more than one to be run


def is_short(work: float) -> bool:
    """Tell whether fits that take so much work, see `CandidateFit.work`, are short enough for a hundred of them."""
    return work < _SHORT


class CandidateFit:
    """One set of effects in the search: its starts, and the best fit so far.

    `deviations` are conditions that differ from run to run, see `stepid.fitting.deviations`.
    """

    def __init__(
        self, context: FitContext, effects: tuple[Effect, ...], deviations: frozenset[str] = frozenset()
    ) -> None:
        self.context, self.effects, self.deviations = context, effects, deviations
        coarse = build(context.decimated, effects, tolerance=COARSE, workers=context.workers)
        self.coarse = with_deviations(coarse, deviations)
        self.best: Optimum | None = None
        self._behind: Optimum | None = None  # the best end of another start: it may lead further
        self.polished: Optimum | None = None  # on all samples
        self.rested: tuple[Optimum, Optimum] | None = None  # a polished fit, and the better of it and the one at rest
        self._looked_from: Optimum | None = None  # for other valleys: it is where they led last
        self._turned_from: Optimum | None = None  # for stops half a swing apart, likewise
        self._tolerance = 0.0  # with which the best fit so far ended, m²

    @cached_property
    def fine(self) -> Problem:
        """The fit to all samples."""
        return with_deviations(build(self.context.records, self.effects, workers=self.context.workers), self.deviations)

    @property
    def names(self) -> tuple[str, ...]:
        """Canonical names."""
        return tuple(e.name for e in self.effects)

    @property
    def work(self) -> int:
        """Steps of the simulation that the race has taken so far, times the states that each of them follows."""
        return self.coarse.simulator.taken * self.coarse.layout.n_states

    @property
    def excess(self) -> float:
        """Cost above that of the noise floor, m²; 0 at the floor."""
        return max(self.cost - self.context.noise_cost, 0.0)

    @property
    def cost(self) -> float:
        """Sum of squared residuals of the best fit so far, m²."""
        return np.inf if self.best is None else self.best.cost

    @property
    def _alike(self) -> float:
        """Difference of cost within which another end is that of the best fit so far, m²."""
        return _SAME * self.excess + self.context.unit

    def begin(
        self, starts: list[Start], *, like: Optimum, keep: int = 3, iterations: int = 3, patient: bool = False
    ) -> None:
        """Try starts: simulate them side by side, run a few iterations from the best.

        Parameters
        ----------
        starts : list of Start
        like : Optimum
            Where their local parameters begin.
        keep : int
            Starts that are run on.
        iterations : int
            Steps from each.
        patient : bool
            Give each its steps, whatever the others promise.
        """
        problem = self.coarse
        sim = problem.simulator
        shared, local = self._laid(starts, like)
        order = list(range(len(starts)))
        many = 1 if any(e.run_parameters for e in self.effects) else 3  # with their phases they can be told apart
        if any(e.reverses or e.n_switches for e in self.effects) or (len(starts) > min(many, keep) and not sim.linear):
            follows = patient or self.deviations  # the linear plant does not follow what differs from run to run
            costs = self._reaches(shared, local, like if follows else self.context.coarse_linear)
            if not patient and min(costs) > like.cost - _POOR * (like.cost - self.context.noise_cost):
                keep = 1  # none shows much
            order = [int(i) for i in np.argsort(costs) if np.isfinite(costs[i])][:keep]
        for i in order:
            begin = local[i]
            if problem.active[sim.layout.own_states].any():
                begin = adapted(problem, shared[i], begin)
            aim = np.inf if patient else self.cost + self._alike  # above it is no better
            ended = [self._try(variant, shared[i], begin, like, iterations, aim) for variant in self._variants()]
            if any(ended):
                break

    def _laid(self, starts: list[Start], like: Optimum) -> tuple[Array, Array]:
        """Global and local parameters of starts, shapes (C, P) and (C, Q, R)."""
        problem = self.coarse
        shared = np.array([np.concatenate([s.linear, *s.values]) for s in starts])
        shared = np.clip(shared, problem.lower, problem.upper)
        local = np.repeat(start_local(problem, like)[None], len(starts), axis=0)
        for own, start in zip(local, starts, strict=True):
            if start.displacement is not None:
                known = problem.active[0] & np.isfinite(start.displacement)
                own[0] = np.where(known, start.displacement, own[0])
        return shared, start_phases(problem, shared, local) if phase_rows(problem) else local

    def _reaches(self, shared: Array, local: Array, like: Optimum) -> list[float]:
        """Cost [m²] that each trajectory would leave after a fit has adapted to it."""
        records, tangent = self.context.decimated, self.context.tangent(like)
        out = []
        for reading in self.coarse.simulator.readings(shared, local):
            if not np.isfinite(reading).all() or np.abs(reading).max() > _FAR:
                out.append(np.inf)
                continue
            left = records.weighted(records.position - reading)
            left = tangent.beyond(left) if tangent.directed else left
            out.append(float(left @ left))
        return out

    def _variants(self) -> list[Problem]:
        """The problem; before it, with runs that begin at rest, where they need not."""
        if not any(e.never_rests for e in self.effects):
            return [self.coarse]
        active = self.coarse.active.copy()
        active[:2] = self.context.decimated.moving
        return [replace(self.coarse, active=active), self.coarse]

    def _try(self, problem: Problem, shared: Array, local: Array, like: Optimum, iterations: int, aim: float) -> bool:
        """Run a few steps from a start; True at the floor, or where a start before it ended, better than `like`."""
        context = self.context
        tolerance = context.slight_beside(min(self.cost, like.cost) - context.noise_cost)
        found = minimize(problem, shared, local, tolerance=tolerance, iterations=iterations, aim=aim)
        if found is None:
            return False
        gained = like.cost - found.cost > _SAME * (like.cost - context.noise_cost) + context.unit
        again = gained and self.best is not None and abs(found.cost - self.cost) < self._alike
        ahead = found.cost < self.cost
        behind = self.best if ahead else found
        if ahead:
            self.best, self._tolerance = found, tolerance
        if behind is not None and self.cost + self._alike < behind.cost < like.cost:
            self._behind = min(filter(None, (self._behind, behind)), key=lambda end: end.cost)
        return found.converged and (again or found.cost < 1.02 * context.noise_cost)

    def run(self, *, iterations: int, tolerance: float = 0.0, others: bool = False) -> None:
        """Go on from the best fit so far, until a step promises less than `tolerance` [m²].

        With `others`, and where that ends above the noise, also from the best end of another start, and from where dry
        friction stops the runs half a swing earlier or later.
        """
        tolerance = max(self.context.tolerance, tolerance)
        if self.best is None:
            return
        if not self.best.converged or self._tolerance > tolerance:
            self._go_on_from(self.best, iterations, tolerance)
        above = self.best.converged and self.cost > self.context.noise_limit
        if others and above and self._behind is not None:
            behind, self._behind = self._behind, None
            self._go_on_from(behind, iterations, tolerance)
        if others and above and self.best is not self._turned_from:
            self._turned_from = self._move(other_turns(self.best, tolerance=tolerance), tolerance)

    def _go_on_from(self, begun: Optimum, iterations: int, tolerance: float) -> None:
        """Go on from an end; kept where it leads no higher than the best fit so far."""
        found = _go_on(self.coarse, begun, tolerance=tolerance, iterations=iterations)
        if found is not None and found.cost <= self.cost:
            self.best, self.polished, self._tolerance = found, None, tolerance

    def other_valleys(self) -> bool:
        """Try other patterns of sticking, and stronger modes, from the best fit so far; True where one is better."""
        if self.best is None or self._looked_from is self.best:
            return False
        tolerance = self.context.slight_beside(self.excess)
        begun, moved = self.best, self.best
        if any(e.dry for e in self.effects):
            moved = other_turns(other_sticking(moved, tolerance=tolerance), tolerance=tolerance)
        self._looked_from = self._move(stronger(moved, tolerance=tolerance), tolerance)
        return self.best is not begun

    def _move(self, end: Optimum, tolerance: float) -> Optimum:
        """Take another end for the best fit so far, where it is one."""
        if end is not self.best:
            self.best, self.polished, self._tolerance = end, None, tolerance
        return end

    def polish(self, *, iterations: int, tolerance: float = 0.0) -> None:
        """Fit all samples, from the best fit of the race or from where the last polish ended."""
        last = self.polished
        if self.best is None or (last is not None and last.converged):
            return
        tolerance = max(self.context.tolerance, tolerance)
        self.polished = _go_on(self.fine, last or self.best, tolerance=tolerance, iterations=iterations) or last


def _go_on(problem: Problem, begun: Optimum, *, tolerance: float, iterations: int) -> Optimum | None:
    """Fit from where another fit ended; where that is of this problem, its simulation is at hand."""
    known = begun.solved if begun.problem is problem else None
    return minimize(problem, begun.shared, begun.local, tolerance=tolerance, iterations=iterations, solved=known)
