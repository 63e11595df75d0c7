"""Two runs whose added masses are noted for each other: with these exchanged, all runs agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

from stepid.core.experiment import Experiment
from stepid.fitting.deviations import with_fault
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.problem import build, fixes_mass
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.run_fault_size import DECIDES, noise_cost
from stepid.simulation.records import Records

_FEWEST = 4  # runs: any two of three agree with some plant
_APART = 7.0  # times the uncertainty of one weight, by which two masses differ at least: five of their difference
_TRIED = 2  # exchanges beside an effect, the best ones of the linear plant
_FROM = (0.0, 1.0, 3.0)  # times what an exchange changes, from where one wrong mass is looked for
_LAPS = 8  # steps of a fit: a linear plant is there after five

Pair = tuple[int, int]


class Swap(NamedTuple):
    """Two runs, by index, and the fit with their masses exchanged; `doubtful` where one wrong mass does as well."""

    runs: Pair
    optimum: Optimum
    doubtful: bool = False

    @property
    def masses(self) -> dict[str, float]:
        """Of the two runs, by name, as exchanged, kg."""
        records = self.optimum.problem.records
        return {records.runs[i].name: float(records.added_mass[i]) for i in self.runs}


def find_swap(linear: Optimum, beside: Optimum | None, floor: float) -> Swap | None:
    """Find two runs whose added masses, exchanged, leave nothing but noise, where as they are noted they leave more.

    An exchange has no size that could be fitted: it explains the misfit as a whole or not.

    Parameters
    ----------
    linear : Optimum
        The linear plant, fitted to all runs.
    beside : Optimum or None
        A fit with an effect, which is asked where no exchange is found beside the linear plant.
    floor : float
        m, noise floor.

    Returns
    -------
    Swap or None
        None where no exchange, or more than one, does so.
    """
    records = linear.problem.records
    noise = noise_cost(records, floor)
    if len(records.runs) < _FEWEST or fixes_mass(records) is not None or linear.cost <= noise:
        return None
    order = _exchanged(linear, _pairs(records), floor)
    found, asked = _only(order, floor), linear
    if found is None and beside is not None and beside.cost > noise:
        found, asked = _only(_exchanged(beside, [swap.runs for swap in order[:_TRIED]], floor), floor), beside
    return None if found is None else found._replace(doubtful=_one_wrong(asked, found, floor))


def _pairs(records: Records) -> list[Pair]:
    """Runs of one base whose masses differ by more than the weights are unsure."""
    mass, base, least = records.added_mass, records.base, _APART * records.weight_uncertainty
    every = combinations(range(len(mass)), 2)
    return [(i, j) for i, j in every if base[i] == base[j] and abs(mass[i] - mass[j]) > least]


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
    near = [swap for swap in order[1:] if swap.optimum.cost < order[0].optimum.cost + DECIDES * floor**2]
    return None if near else order[0]


def _one_wrong(optimum: Optimum, swap: Swap, floor: float) -> bool:
    """Tell whether one wrong mass explains as much: too few others are left then that would tell which it is."""
    records, most = optimum.problem.records, swap.optimum.cost + DECIDES * floor**2
    off = swap.optimum.problem.records.added_mass - records.added_mass  # of the two, kg
    for run in range(len(records.runs)):
        problem = with_fault(optimum.problem, run, "added_mass")
        row = problem.layout.deviation("added_mass")
        for size in dict.fromkeys(share * float(off[run]) for share in _FROM):
            local = optimum.local.copy()
            local[row, run] = size
            fitted = minimize(problem, optimum.shared, local, tolerance=floor**2, iterations=4 * _LAPS, aim=most)
            if fitted is not None and fitted.cost < most:
                return True
    return False


def swap_faults(swap: Swap) -> tuple[RecordFault, ...]:
    """What is wrong with either run: the mass that it has beyond the one noted."""
    noted = {run.name: run.added_mass for run in swap.optimum.problem.records.runs}
    (one, its), (other, that) = swap.masses.items()
    words = (
        f"The added masses of runs {one!r} and {other!r} are noted for each other: with {its:g} kg and {that:g} kg all "
        "runs agree. Weigh them again. They are exchanged in this diagnosis."
    )
    return tuple(
        RecordFault(run=name, kind="added_mass", size=mass - noted[name], unit="kg", words=words)
        for name, mass in swap.masses.items()
    )


def doubt(swap: Swap) -> str:
    """What is said beside an accused run where an exchange does as well."""
    (one, its), (other, that) = swap.masses.items()
    return (
        f"All runs agree as well, on another plant, if the added masses of {one!r} and {other!r} are noted for each "
        f"other: {its:g} kg and {that:g} kg. Weigh them again: all parameters depend on it."
    )


def without_swap(runs: Sequence[Experiment], swap: Swap) -> tuple[Experiment, ...]:
    """The runs of a campaign with the two masses exchanged."""
    has = swap.masses
    return tuple(run.model_copy(update={"added_mass": has.get(run.name, run.added_mass)}) for run in runs)
