"""Fifth question: which run would tell the models apart that the data cannot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stepid.core.experiment import Experiment
from stepid.core.noise import rms
from stepid.core.words import digits, length
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.exchangeable import push
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.problem import build
from stepid.simulation.records import Records
from stepid.simulation.simulator import Simulator

_HALF, _LARGER = 0.5, 1.6  # times the largest step or displacement so far
_FASTER = 4  # times as many readings a second
_WAIT = 4  # samples before a step
_SEEN = 0.5  # of the noise, or of what the models leave, by which they must differ
_STEPS = 8  # of a fit of what is free in every run


class Proposal(NamedTuple):
    """A run that one could add, in words, and as an experiment without measured positions that begins displaced."""

    words: str
    run: Experiment
    displacement: float = 0.0


def _proposals(records: Records, displacement: float, mass: float) -> list[Proposal]:
    """Runs like the one of the largest step, as long as it; like the widest release, `displacement`, without any.

    `mass` is the moving mass of the first run [kg].
    """
    first = max(records.runs, key=lambda run: abs(push(run)))
    level, begin = push(first), first.input_before
    h, n = first.sample_time, first.time.size

    def run(levels: tuple[float, float] = (0.0, 0.0), added: float = first.added_mass, step: float = h) -> Experiment:
        volts = begin + np.where(np.arange(n) < n // 2, *levels)
        volts[:_WAIT] = begin
        return Experiment(
            name="proposed",
            time=np.arange(n, dtype=np.float64) * step,
            position=np.zeros(n),
            input=volts,
            input_before=begin,
            added_mass=added,
            spring=first.spring,
            damper=first.damper,
            base=first.base,
        )

    masses = np.unique(records.added_mass)
    heavier = float(masses[-1] + (np.diff(masses).min() if masses.size > 1 else _HALF * mass))
    weighs = f"with {heavier:g} kg added" if masses.size > 1 else "with half of the moving mass added"
    if level == 0:
        return [
            Proposal("a release from the other side", run(), -displacement),
            Proposal("a release from half as far", run(), _HALF * displacement),
            Proposal("a release from farther away, if the travel allows", run(), _LARGER * displacement),
            Proposal(f"a release {weighs}", run(added=heavier), displacement),
        ]
    steps = [
        (f"a step of {-level:g} V, the other way, and back", run((-level, 0.0))),
        (f"a step of {level:g} V with the step back to {begin:g} V in the record", run((level, 0.0))),
        (f"a step of {_HALF * level:g} V, half the size, and back", run((_HALF * level, 0.0))),
        (f"a step of {_LARGER * level:.3g} V, a larger one, if the travel allows", run((_LARGER * level, 0.0))),
        (f"a step of {level:g} V {weighs}", run((level, 0.0), heavier)),
        (
            f"a step of {level:g} V sampled every {h / _FASTER * 1e3:.3g} ms",
            run((level, level), first.added_mass, h / _FASTER),
        ),
    ]
    return [Proposal(*one) for one in steps]


def _answered(fitted: Records, chosen: Optimum, proposals: Sequence[Proposal]) -> list[Proposal]:
    """Proposed runs with what a fitted model reads in them; one in which it runs away is left out."""
    records = fitted.like([one.run for one in proposals])
    sim = Simulator(records, chosen.problem.simulator.effects)
    begin = np.zeros((1, sim.layout.n_run, len(proposals)))
    begin[0, 0] = [one.displacement for one in proposals]
    answers = sim.readings(chosen.shared[None], begin)[0]
    read = [
        one._replace(run=one.run.model_copy(update={"position": answers[piece]}))
        for one, piece in zip(proposals, records.pieces(), strict=True)
    ]
    return [one for one in read if np.isfinite(one.run.position).all()]


def _gap(fitted: Records, rival: Optimum, answered: Proposal) -> float:
    """RMS [m] by which an answered run differs from what a rival reads; 0, which tells nothing, where that runs away.

    Where the run begins, its rest position and its phase are free, as they are in fits: what they can do tells no
    models apart.
    """
    records = fitted.like([answered.run])
    records = replace(records, moving=~records.driven)
    problem = build(records, rival.problem.simulator.effects)
    local = np.zeros((problem.layout.n_run, 1))
    local[0] = answered.displacement
    alone = replace(problem, free=np.zeros_like(problem.free))
    found = minimize(alone, rival.shared, local, iterations=_STEPS)
    return 0.0 if found is None else rms(records.centered(records.position - found.solved.reading))


def next_experiment(
    chosen: Optimum,
    rivals: list[Optimum],
    *,
    floor: float,
    tell: Callable[[Optimum], str],
    criteria: Criteria | None = None,
) -> str:
    """Name the run on which the rival models differ most, both simulated with the parameters they were fitted with.

    Where they leave more than noise, what is missing in both will be missing in that run, too: it tells them apart only
    if they differ by as much.

    Parameters
    ----------
    chosen, rivals : Optimum
        Fits to the same records that the data cannot tell apart.
    floor : float
        m, noise.
    tell : callable
        Names an optimum in words.
    criteria : Criteria, optional
        Up to `near` times the noise only that is left.
    """
    fitted, start = chosen.problem.records, chosen.local[0]
    mass = float(chosen.problem.layout.mass(chosen.shared)[0])
    able = _answered(fitted, chosen, _proposals(fitted, float(start[np.argmax(np.abs(start))]), mass))
    gaps = np.array([[_gap(fitted, rival, one) for one in able] for rival in rivals if able])
    rests = chosen.rms > (criteria or Criteria()).near * floor
    left, what = (chosen.rms, "what they leave so far") if rests else (floor, "the noise")
    told = [i for i, own in enumerate(gaps) if own.max() >= _SEEN * left]
    if not told:
        return (
            f"None of the usual extra runs would tell {tell(chosen)} from {_names(rivals, tell)}: in all of them "
            f"the models differ by less than half {'of ' if rests else ''}{what}. "
            + ("Find out first what is missing in both." if rests else "Lower the noise, or sample faster.")
        )
    if gaps[told].min(axis=0).max() < _SEEN * left:  # no run tells all of them
        told = told[:1]
    apart = gaps[told].min(axis=0)
    run, best = int(np.argmax(apart)), float(apart.max())
    others = [rival for i, rival in enumerate(rivals) if i not in told]
    said = (
        f"To tell {tell(chosen)} from {_names([rivals[i] for i in told], tell)}, record {able[run].words}. There the "
        f"models differ by {length(best)} RMS, {digits(best / left)} times {what}."
    )
    return f"{said} That run does not tell it from {_names(others, tell)}." if others else said


def _names(rivals: Sequence[Optimum], tell: Callable[[Optimum], str]) -> str:
    return " or ".join(map(tell, rivals))
