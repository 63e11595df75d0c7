"""Two runs whose added masses are noted for each other: with these exchanged, all runs agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

from stepid.core.experiment import Experiment
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.problem import build, fixes_mass
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.run_fault_size import noise_cost
from stepid.simulation.records import Records

_FEWEST = 4  # runs: any two of three agree with some plant
_DECIDES = 10.0  # χ² by which one exchange must be the better one
_TRIED = 2  # exchanges beside an effect, the best ones of the linear plant
_LAPS = 8  # steps of a fit: a linear plant is there after five

Pair = tuple[int, int]


class Swap(NamedTuple):
    """Two runs, by index, and the fit in which their added masses are exchanged."""

    runs: Pair
    optimum: Optimum


def find_swap(linear: Optimum, beside: Optimum | None, floor: float) -> Swap | None:
    """Find two runs whose added masses, exchanged, leave nothing but noise.

    An exchange has no size that could be fitted: it explains the misfit as a whole or not.

    Parameters
    ----------
    linear : Optimum
        The linear plant, fitted to all runs.
    beside : Optimum or None
        A fit with an effect, which is asked where the linear plant leaves more.
    floor : float
        m, noise floor.

    Returns
    -------
    Swap or None
        None where no exchange, or more than one, does so.
    """
    records = linear.problem.records
    if len(records.runs) < _FEWEST or fixes_mass(records) is not None:
        return None
    mass, base = records.added_mass, records.base
    every = [(i, j) for i, j in combinations(range(len(mass)), 2) if mass[i] != mass[j] and base[i] == base[j]]
    order = _exchanged(linear, every, floor)
    found = _only(order, floor)
    if found is None and beside is not None:
        found = _only(_exchanged(beside, [swap.runs for swap in order[:_TRIED]], floor), floor)
    return found


def _exchanged(optimum: Optimum, pairs: Sequence[Pair], floor: float) -> list[Swap]:
    """Fits with each pair's masses exchanged, the best first."""
    out, problem, aim = [], optimum.problem, noise_cost(optimum.problem.records, floor)
    for pair in pairs:
        other = build(_exchange(problem.records, pair), problem.simulator.effects, workers=problem.simulator.workers)
        fitted = minimize(other, optimum.shared, optimum.local, tolerance=floor**2, iterations=_LAPS, aim=aim)
        if fitted is not None:
            out.append(Swap(pair, fitted))
    return sorted(out, key=lambda swap: swap.optimum.cost)


def _exchange(records: Records, pair: Pair) -> Records:
    mass = records.added_mass.copy()
    mass[list(pair)] = mass[list(reversed(pair))]
    return replace(records, added_mass=mass)


def _only(order: Sequence[Swap], floor: float) -> Swap | None:
    """The first, where it leaves only noise and no other comes near."""
    if not order or order[0].optimum.cost > noise_cost(order[0].optimum.problem.records, floor):
        return None
    near = [swap for swap in order[1:] if swap.optimum.cost < order[0].optimum.cost + _DECIDES * floor**2]
    return None if near else order[0]


def swap_faults(swap: Swap) -> tuple[RecordFault, ...]:
    """What is wrong with either run: the mass that it has beyond the one noted."""
    records = swap.optimum.problem.records
    runs, has = [records.runs[i] for i in swap.runs], [float(records.added_mass[i]) for i in swap.runs]
    words = (
        f"The added masses of runs {runs[0].name!r} and {runs[1].name!r} are noted for each other: with {has[0]:g} kg "
        f"and {has[1]:g} kg all runs agree. Weigh them again. They are exchanged in this diagnosis."
    )
    return tuple(
        RecordFault(run=run.name, kind="added_mass", size=mass - run.added_mass, unit="kg", words=words)
        for run, mass in zip(runs, has, strict=True)
    )


def without_swap(runs: Sequence[Experiment], swap: Swap) -> list[Experiment]:
    """The runs of a campaign with the two masses exchanged."""
    records = swap.optimum.problem.records
    has = {records.runs[i].name: float(records.added_mass[i]) for i in swap.runs}
    return [run.model_copy(update={"added_mass": has.get(run.name, run.added_mass)}) for run in runs]
