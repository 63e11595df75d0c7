"""One run that hides the law of the others: without it they agree, and what is wrong with it can be told then."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from stepid.core.base import Array
from stepid.core.words import length
from stepid.diagnosis.exchangeable import push
from stepid.diagnosis.selection.candidate import Candidate
from stepid.fitting.cross_validation import qualifying
from stepid.fitting.deviations import with_fault
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.problem import build, start_local
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.run_fault import is_witness, less_than_none, may_be_weights, told
from stepid.fitting.run_fault_size import noise_cost
from stepid.fitting.run_fault_words import ROUND, UNITS, fault_words
from stepid.simulation.records import Records
from stepid.simulation.simulator import Simulator

_STANDS_OUT = 0.3  # of the linear plant's misfit, per sample, that is left without the run: as much as a fault leaves
_NEARLY_ALL = 0.027  # the same for a run that no other is like, or that is one of few
_FARTHER = 1.1  # times the others' travel, from which on they tell nothing of a run's law
_FEWEST = 4  # runs: two others agree with any law
_SOME = 5  # runs: of fewer the three others may, too, and a mistake has to take nearly all of the misfit
_PARTS = np.array([-0.6, -0.4, -0.2, 0.2, 0.4, 0.7, 1.0, 1.5])  # of the moving mass: a wrong one is looked for from
_LAPS = 30  # steps of a fit
_LABELS, _ALIKE = ("stiffness", "damping"), 0.1  # relative, as far as a run's own is another label's

_Mistake = tuple[str, float, float, Optimum]


def outlying_runs(context: FitContext, laws: Sequence[Optimum] = ()) -> list[int]:
    """Runs without which the linear plant, or one of some laws, leaves far less, worst first, by index.

    What all runs follow is left by any of them; a run that is wrong takes most of the misfit with it. Only runs whose
    labels occur in others come into question.

    Parameters
    ----------
    context : FitContext
    laws : sequence of Optimum
        Fits to all runs, alike in all: beside a strong law no run stands out of what the linear plant leaves.
    """
    records = context.records
    every, found = range(len(records.runs)), dict[int, float]()
    for run in qualifying(records) if len(every) >= _FEWEST else ():
        kept = [i for i in every if i != run]
        rest = records.subset(kept)
        for whole in (context.linear, *laws):
            problem, local = build(rest, whole.problem.simulator.effects), whole.local[:, kept]
            without = minimize(problem, whole.shared, local, tolerance=context.tolerance, iterations=_LAPS)
            if without is not None:
                left = _mean_square(without) / _mean_square(whole)
                found[run] = min(left, found.get(run, left))
    return sorted((run for run, left in found.items() if left <= _STANDS_OUT), key=lambda run: found[run])


def fault_of(context: FitContext, run: int, shown: Candidate, floor: float, *, sure: float) -> RecordFault | None:
    """What is wrong with a run, by the model of all others; None where that may be a law.

    The plant is that of the others. One label, scale or start of the run is changed, from wherever such mistakes lead:
    what takes most of its misfit then is told, if the run is not odd any more. Else the run disagrees, if others like
    it do not, where these are left with noise only. Where they are left with more, it is odd if it is by far worse than
    the worst of them.

    Parameters
    ----------
    context : FitContext
        Of all runs.
    run : int
    shown : Candidate
        Fitted to the others.
    floor : float
        m, noise floor of the others.
    sure : float
        Times its uncertainty, that a weight must be wrong by.
    """
    records, shared = context.records, shown.optimum.shared
    plain = _alone(context, run, shown)
    if plain is None or not _is_odd(plain, shown):
        return None
    alone, before = plain.problem, plain.cost
    quiet = shown.optimum.cost <= noise_cost(shown.optimum.problem.records, floor)
    unsure = _stands_alone(records, run, shown) or len(records.runs) < _SOME
    mended = _worst(shown.optimum) / _STANDS_OUT * alone.records.weighed_size
    every = [
        one
        for one in _mistakes(alone, shared, context, run)
        if one[3].cost <= mended and (one[0] not in _LABELS or _is_label(one, shared))
    ]
    found = min(every, key=lambda one: one[2], default=None)
    name = records.runs[run].name
    if found is not None and found[2] <= (_NEARLY_ALL if unsure else _STANDS_OUT) * before:
        kind, size, _, optimum = found
        change = told(optimum, 0, kind, size)
        if kind == "added_mass" and may_be_weights(records, change, sure):
            return None
        words = fault_words(optimum, 0, kind, size, (), agree=quiet)
        return RecordFault(run=name, kind=kind, size=change, unit=UNITS[kind], words=words)
    if unsure or not quiet:
        return None
    words = (
        f"Run {name!r} disagrees by {length(plain.rms)} RMS with a model that leaves only noise in all others. "
        "Was the cart touched, or is a label or the input wrong? Record it again."
    )
    return RecordFault(run=name, kind="disagreement", size=plain.rms, unit="m", words=words)


def stands_out(context: FitContext, run: int, shown: Candidate) -> bool:
    """Tell whether a run is by far worse described than the worst of the others, by a candidate fitted to these."""
    plain = _alone(context, run, shown)
    return plain is not None and _is_odd(plain, shown)


def _alone(context: FitContext, run: int, shown: Candidate) -> Optimum | None:
    """A run with a plant of the others: what is its own is fitted to it."""
    alone = build(context.records.subset([run], under=shown.optimum.problem.records), shown.effects)
    return _fitted(replace(alone, free=np.zeros_like(alone.free)), shown.optimum.shared)


def _is_odd(plain: Optimum, shown: Candidate) -> bool:
    return _worst(shown.optimum) <= _STANDS_OUT * _mean_square(plain) and plain.cost > 0


def _mean_square(fitted: Optimum) -> float:
    """Mean square misfit [m²]."""
    return fitted.cost / fitted.problem.records.weighed_size


def _worst(fitted: Optimum) -> float:
    """The same of the run that a fit describes worst."""
    records = fitted.problem.records
    squares, weights = (records.weight * fitted.residual) ** 2, records.weight**2
    return max(float(squares[own].sum() / weights[own].sum()) for own in records.pieces())


def _mistakes(alone: Problem, shared: Array, context: FitContext, run: int) -> Iterator[_Mistake]:
    """Mistakes of one run, each with its size as a deviation, and the cost [m²] left of it."""
    records, of = context.records, alone.layout
    mass, others = float(of.mass(shared)[0]), np.delete(np.arange(len(records.runs)), run)
    stiffness, damping = shared[of.stiffness], shared[of.damping]
    begins = {
        "added_mass": [*np.unique(records.added_mass[others] - records.added_mass[run]), *mass * _PARTS],
        "stiffness": [0.0, *(stiffness / stiffness[alone.records.spring[0]] - 1.0)],
        "damping": [0.0, *(damping / max(damping[alone.records.damper[0]], np.finfo(float).tiny) - 1.0)],
        "start_time": [0.0],
    }
    for kind, sizes in begins.items():
        problem, row = with_fault(alone, 0, kind), of.deviation(kind)
        for size in sizes:
            fitted = _fitted(problem, shared, row, float(size))
            own = float(fitted.local[row, 0]) if fitted is not None else 0.0
            if fitted is not None and not (kind == "added_mass" and less_than_none(fitted, 0, own)):
                yield kind, own, fitted.cost, fitted
    for factor in ROUND:
        scaled = replace(alone.records, position=alone.records.position / factor)
        sim = alone.simulator
        fitted = _fitted(replace(alone, simulator=Simulator(scaled, sim.effects, sim.tolerance)), shared)
        if fitted is not None:
            yield "gain", factor - 1.0, fitted.cost * factor**2, fitted


def _is_label(found: _Mistake, shared: Array) -> bool:
    """Tell whether a stiffness or damping is another label's: what no label says is no mistake in one."""
    kind, size, _, optimum = found
    of, records = optimum.problem.layout, optimum.problem.records
    own, values = (
        (records.spring[0], shared[of.stiffness]) if kind == "stiffness" else (records.damper[0], shared[of.damping])
    )
    others = np.delete(values, own) / values[own] - 1.0
    return bool(np.any(np.abs(others - size) < _ALIKE * (1.0 + size)))


def _fitted(problem: Problem, shared: Array, row: int | None = None, size: float = 0.0) -> Optimum | None:
    """What is the run's own, fitted to it from a deviation of some size."""
    local = start_local(problem)
    if row is not None:
        local[row] = size
    return minimize(problem, shared, local, iterations=_LAPS)


def _stands_alone(records: Records, run: int, shown: Candidate) -> bool:
    """Tell whether a law may do what it likes in a run: its mass, input or travel is beyond the others', or its way."""
    way, others = np.sign([_push(records, i) for i in range(len(records.runs))]), np.delete(records.added_mass, run)
    travel = np.array([np.ptp(records.position[piece]) for piece in records.pieces()])
    beyond = not others.min() <= records.added_mass[run] <= others.max()
    beyond |= bool(travel[run] > _FARTHER * np.delete(travel, run).max())
    return beyond or not np.any(np.delete(way, run) == way[run]) or is_witness(records, run, beside=shown.effects)


def _push(records: Records, run: int) -> float:
    """What sets a run in motion, with its sign: the input's largest change, or how far from its end it is let go."""
    one, y = records.runs[run], records.position[records.pieces()[run]]
    return float(y[0] - y[-1]) if one.is_release else push(one)
