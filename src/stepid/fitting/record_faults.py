"""What would explain a run that disagrees with the others: labels, scale, sign, timing, drift."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.effects import resolve
from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_floor import structure
from stepid.fitting.problem import build, fixes_mass
from stepid.simulation.records import Records

WHITE = 6.0  # standard deviations of structure that noise may show
SLACK = 1.08  # times the floor that the other runs may leave
_LOOSE = 8.0  # the same for a run explained by the others' parameters, which are not exact
_ROOM = 1.2  # and times the floor, which one badly scaled run has pulled
_ODD = 0.02  # by which a factor must differ from 1 to be a mistake
_ROUND = (-1.0, 2.0, 0.5, -2.0, -0.5, 4.0, 0.25, 10.0, 0.1, 100.0, 0.01, 1000.0, 0.001, 2.54, 1 / 2.54)
_NEAR = 0.03  # relative
_ROUGH = 0.15
_EARLY = 6  # samples by which an input may lead


@dataclass(frozen=True)
class Mistake:
    """What would explain a run: in words, and what its misfit is then [m²].

    `plain` is a mistake in the manifest; `single` is one that no effect of the whole plant looks like.
    """

    words: str
    cost: float
    plain: bool
    single: bool = True


def known(problem: Problem) -> npt.NDArray[np.bool_]:
    """Shared parameters whose label occurs in the problem's runs."""
    r = problem.records
    used = [
        np.isin(np.arange(len(labels)), own)
        for labels, own in ((r.bases, r.base), (r.springs, r.spring), (r.dampers, r.damper))
    ]
    return np.concatenate([*used, np.ones(problem.free.size - sum(u.size for u in used), dtype=bool)])


def at_floor(context: FitContext, fit: Optimum, slack: float, white: float) -> bool:
    """Tell whether a fit leaves no more than so many times the floor, and nothing but noise."""
    records = fit.problem.records
    samples = float((records.weight**2).sum())
    level = np.sqrt(fit.cost / samples)
    far = structure(records, fit.problem.residual(fit.solved), context.floor, context.period)
    return bool(level <= (slack + 3.0 / np.sqrt(2.0 * samples)) * context.floor and far < white)


def mistakes(
    context: FitContext, fit: Optimum, others: Optimum, run: int, *, slack: float = _ROOM, white: float = _LOOSE
) -> Iterator[Mistake]:
    """What would bring the run to the floor, or to `slack` times it, under the others' parameters."""
    records = fit.problem.records.subset([run])
    effects, of = fit.problem.simulator.effects, fit.problem.layout
    base, spring = int(records.base[0]), of.stiffness.start + int(records.spring[0])
    damper = of.damping.start + int(records.damper[0])
    alone = Alone(context, records, effects, fit, others.shared, run, slack, white)
    lonely = ~known(others.problem)

    def added(value: float) -> str:
        mass = records.added_mass[0] + value - others.shared[base]
        return (
            f"With {mass:.4g} kg added instead of {records.added_mass[0]:g} kg it agrees: a wrong added mass. "
            "Weigh it again."
        )

    def stiff(value: float) -> str:
        labels = fit.problem.records.springs
        own = labels[spring - of.stiffness.start]
        known_values = others.shared[of.stiffness]
        near = [s for s, k in zip(labels, known_values, strict=True) if s != own and abs(k / value - 1) < 0.1]
        like = f", that of spring {near[0]!r}" if near else ""
        return (
            f"With a stiffness of {value:.4g} N/m{like} instead of the {others.shared[spring]:.4g} N/m of spring "
            f"{own!r} it agrees: a wrong spring label. Check which spring was in."
        )

    def damped(value: float) -> str:
        label = fit.problem.records.dampers[damper - of.damping.start]
        return (
            f"With a damping of {value:.3g} N·s/m instead of the {others.shared[damper]:.3g} N·s/m of damper {label!r} "
            "it agrees: a wrong damper label. Check its setting."
        )

    for index, say in ((base, added), (spring, stiff), (damper, damped)):
        if lonely[index] or (index == base and fixes_mass(fit.problem.records) is not None):
            continue
        found = alone.freed(index)
        if found is not None:
            yield Mistake(say(float(found.shared[index])), found.cost, True)
    yield from scaled(alone)
    yield from _shifted(alone)
    drift = alone.with_effect("sensor_drift", 0.0)
    if drift is not None:
        rate = float(drift.shared[-1])
        yield Mistake(f"With its zero drifting by {1e6 * rate:.3g} µm/s it agrees.", drift.cost, False, single=False)


@dataclass(frozen=True)
class Alone:
    """The suspected run by itself, under the others' parameters."""

    context: FitContext
    records: Records
    effects: tuple[Effect, ...]
    fit: Optimum
    shared: Array
    run: int
    slack: float
    white: float

    def _fit(self, problem: Problem, shared: Array, index: int) -> Optimum | None:
        free = np.zeros_like(problem.free)
        free[index] = True
        active = problem.active.copy()
        local = np.zeros((problem.layout.n_run, 1))
        here, there = problem.layout, self.fit.problem.layout
        rows = slice(0, min(here.own_states.stop, there.own_states.stop))
        for to, of in ((rows, rows), (here.deviations, there.deviations)):
            active[to] = self.fit.problem.active[of][:, [self.run]]
            local[to] = self.fit.local[of][:, [self.run]]
        found = minimize(replace(problem, free=free, active=active), shared, local, tolerance=self.context.tolerance)
        return found if found is not None and at_floor(self.context, found, self.slack, self.white) else None

    @property
    def has_equal(self) -> bool:
        """Whether another run has an input of the same size: then no dead zone sets this one apart."""
        runs = self.fit.problem.records.runs
        sizes = np.array([np.abs(r.input - r.input_before).max() for r in runs])
        own = sizes[self.run]
        return bool(np.any(np.abs(np.delete(sizes, self.run) - own) < 0.01 * own))

    def freed(self, index: int) -> Optimum | None:
        """With one shared parameter of its own."""
        return self._fit(build(self.records, self.effects), self.shared, index)

    def with_effect(self, name: str, start: float) -> Optimum | None:
        """With one more effect, in this run only."""
        if any(e.name == name for e in self.effects):
            return None
        problem = build(self.records, (*self.effects, *resolve([name])))
        return self._fit(problem, np.append(self.shared, start), problem.free.size - 1)

    def changed(self, records: Records) -> Alone:
        """With other readings or inputs."""
        return replace(self, records=records)


def scaled(alone: Alone) -> Iterator[Mistake]:
    """A reading that is wrong by a factor: seen as a gain of its own, where there is an input."""
    if not np.any(alone.records.volts):
        return
    problem = build(alone.records, alone.effects)
    gain = problem.layout.force_gain
    free = np.zeros_like(problem.free)
    free[gain] = True
    active = np.zeros_like(problem.active)
    rough = minimize(replace(problem, free=free, active=active), alone.shared, np.zeros((active.shape[0], 1)))
    if rough is None or alone.shared[gain] == 0:
        return
    rough_factor = float(rough.shared[gain] / alone.shared[gain])
    # dry friction is not scaled along, so that a round factor may look less round
    tried = [
        r
        for r in _ROUND
        if abs(rough_factor / r - 1) < (_NEAR if alone.slack == _ROOM and not alone.effects else _ROUGH)
    ]
    for factor in (*tried, rough_factor):
        if abs(factor) < 1e-6 or abs(factor - 1) < _ODD:
            continue
        found = alone.changed(replace(alone.records, position=alone.records.position / factor)).freed(gain)
        if found is not None:
            yield Mistake(_say_factor(factor), found.cost, factor in _ROUND, factor in _ROUND or alone.has_equal)
            return


def _say_factor(factor: float) -> str:
    if factor == -1.0:
        return "With its sign turned it agrees: check the sign of its counts_per_meter, or of its input."
    if factor in _ROUND:
        return f"Its readings are {factor:.4g} times what the others ask for: check its counts_per_meter."
    return f"Its readings, or its input, are {factor:.3g} times what the others ask for: check scale and amplifier."


def _shifted(alone: Alone) -> Iterator[Mistake]:
    """An input that is out of step with the readings, by up to a few samples."""
    h = float(alone.records.sample_time[0])
    changes = np.flatnonzero(alone.records.volts != alone.records.before[0])
    early = min(_EARLY, int(changes[0])) if changes.size else 0
    volts = alone.records.volts
    advanced = np.concatenate([volts[early:], np.full(early, volts[-1])])
    found = alone.changed(alone.records.with_input(advanced)).with_effect("input_delay", early * h)
    if found is not None:
        late = float(found.shared[-1]) / h - early
        if abs(late) > 0.1:
            way = "after" if late > 0 else "before"
            words = f"Its readings come {abs(late):.2g} samples {way} its input: check how the two were put together."
            yield Mistake(words, found.cost, False)
