"""Fifth question: which run would tell the models apart that the data cannot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.words import digits, length
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.simulation.records import Records
from stepid.simulation.simulator import Simulator

_HALF, _LARGER = 0.5, 1.6  # times the largest step or displacement so far
_FASTER = 4  # times as many readings a second
_WAIT = 4  # samples before a step


class Proposal(NamedTuple):
    """A run that one could add, in words, and as an experiment without measured positions that begins displaced."""

    words: str
    run: Experiment
    displacement: float = 0.0


def _proposals(records: Records, displacement: float, mass: float) -> list[Proposal]:
    """Runs like the one of the largest input, as long as it; like the widest release, `displacement`, without any.

    `mass` is the moving mass of the first run [kg].
    """
    most = [float(np.abs(run.input).max()) for run in records.runs]
    first = records.runs[int(np.argmax(most))]
    level = float(first.input[np.argmax(np.abs(first.input))])
    h, n = first.sample_time, first.time.size

    def run(levels: tuple[float, float] = (0.0, 0.0), added: float = first.added_mass, step: float = h) -> Experiment:
        volts = np.where(np.arange(n) < n // 2, *levels)
        volts[:_WAIT] = 0.0
        return Experiment(
            name="proposed",
            time=np.arange(n, dtype=np.float64) * step,
            position=np.zeros(n),
            input=volts,
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
        (f"a step of {level:g} V with the step back to 0 V in the record", run((level, 0.0))),
        (f"a step of {_HALF * level:g} V, half the size, and back", run((_HALF * level, 0.0))),
        (f"a step of {_LARGER * level:.3g} V, a larger one, if the travel allows", run((_LARGER * level, 0.0))),
        (f"a step of {level:g} V {weighs}", run((level, 0.0), heavier)),
        (
            f"a step of {level:g} V sampled every {h / _FASTER * 1e3:.3g} ms",
            run((level, level), first.added_mass, h / _FASTER),
        ),
    ]
    return [Proposal(*one) for one in steps]


def _answers(records: Records, optimum: Optimum, displacements: Sequence[float]) -> Array:
    """What a fitted model reads in runs that begin still and displaced [m]; not finite where it runs away; (S,) [m]."""
    sim = Simulator(records, optimum.problem.simulator.effects)
    begin = np.zeros((1, sim.layout.n_run, len(records.runs)))
    begin[0, 0] = displacements
    out: Array = sim.readings(optimum.shared[None], begin)[0]
    return out


def next_experiment(chosen: Optimum, rivals: list[Optimum], *, floor: float, tell: Callable[[Optimum], str]) -> str:
    """Name the run on which the rival models differ most, both simulated with the parameters they were fitted with.

    Parameters
    ----------
    chosen, rivals : Optimum
        Fits to the same records that the data cannot tell apart.
    floor : float
        m, noise.
    tell : callable
        Names an optimum in words.
    """
    best: tuple[float, str] = (0.0, "")
    fitted, start = chosen.problem.records, chosen.local[0]
    mass = float(chosen.problem.layout.mass(chosen.shared)[0])
    proposals = _proposals(fitted, float(start[np.argmax(np.abs(start))]), mass)
    records = fitted.like([one.run for one in proposals])
    begin = [one.displacement for one in proposals]
    base = _answers(records, chosen, begin)
    apart = [records.centered(base - _answers(records, rival, begin)) for rival in rivals]
    for one, piece in zip(proposals, records.pieces(), strict=True):
        gaps = [float(np.sqrt(np.mean(a[piece] ** 2))) for a in apart if np.isfinite(a[piece]).all()]
        if gaps and min(gaps) > best[0]:
            best = (min(gaps), one.words)
    names = " or ".join(tell(r) for r in rivals)
    if best[0] < 0.5 * floor:
        return (
            f"None of the usual extra runs would tell {tell(chosen)} from {names}: in all of them the models differ by "
            "less than half the noise. Lower the noise, or sample faster."
        )
    return (
        f"To tell {tell(chosen)} from {names}, record {best[1]}. There the models differ by {length(best[0])} RMS, "
        f"{digits(best[0] / floor)} times the noise."
    )
