"""The stacked system of Eqs. 6, 9 and 10, corrected: built here, solved in `stepid.identification.solvers`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import MassOffset
from stepid.core.quantities import in_own_quantities
from stepid.core.recorded import recorded
from stepid.core.takes import a, each, takes
from stepid.core.words import counted
from stepid.errors import InputError, UndeterminedError
from stepid.identification.characteristics_model import Characteristics
from stepid.identification.parameters import StackedSystem


def frequency_row(damped_frequency: float, damping_ratio: float) -> tuple[float, float]:
    """Coefficients of mass and stiffness in one run's frequency row (Eq. 6): m ω_d² − k (1 − ζ²) = 0.

    Parameters
    ----------
    damped_frequency : float
        rad/s.
    damping_ratio : float

    Returns
    -------
    tuple of float
        (ω_d², ζ² − 1). Eq. 10 prints ω² − 1 in the second place, which is a misprint.
    """
    return damped_frequency**2, damping_ratio**2 - 1.0


@in_own_quantities
@takes(
    characteristics=each(a(Characteristics, ""), "characteristics, one a run, as stepid.characterize returns them"),
    mass_offsets=each(a(MassOffset, ""), "mass differences, as campaign.mass_offsets"),
)
@recorded()
def assemble(characteristics: Sequence[Characteristics], mass_offsets: Sequence[MassOffset]) -> StackedSystem:
    """Stack the frequency rows (Eq. 6) and the mass rows (Eq. 9) of several runs into one system (Eq. 10).

    Parameters
    ----------
    characteristics : sequence of Characteristics, length n
        One a run; their order is the order of the mass columns. Stiffness columns follow, one a spring label.
    mass_offsets : sequence of MassOffset
        Known mass differences; for b bases usually n − b of them. Each row follows the frequency row of its
        `from_run`, so that runs joined in order give the alternating rows of Eq. 10.

    Returns
    -------
    StackedSystem
        `matrix` has shape (n + number of offsets, n + s).

    Raises
    ------
    stepid.errors.UndeterminedError
        If there are fewer than two runs.
    stepid.errors.InputError
        If a name occurs twice or an offset names a run that is not there, or one run twice.
    """
    runs = tuple(characteristics)
    offsets = tuple(mass_offsets)
    _check(runs, offsets)
    springs = tuple(dict.fromkeys(run.spring for run in runs))
    column = {run.name: i for i, run in enumerate(runs)}
    stiffness = {label: len(runs) + i for i, label in enumerate(springs)}
    rows: list[Array] = []
    right: list[float] = []
    labels: list[str] = []
    placed: list[MassOffset] = []
    width = len(runs) + len(springs)
    for run in runs:
        row = np.zeros(width)
        row[column[run.name]], row[stiffness[run.spring]] = frequency_row(run.damped_frequency, run.damping_ratio)
        rows.append(row)
        right.append(0.0)
        labels.append(f"frequency, {run.name}")
        for offset in (o for o in offsets if o.from_run == run.name):
            row = np.zeros(width)
            row[column[offset.from_run]], row[column[offset.to_run]] = -1.0, 1.0
            rows.append(row)
            right.append(offset.difference)
            labels.append(f"mass, {offset.from_run} → {offset.to_run}")
            placed.append(offset)
    return StackedSystem(
        matrix=np.array(rows),
        rhs=np.array(right),
        row_labels=tuple(labels),
        column_labels=(*(f"m[{run.name}]" for run in runs), *(f"k[{label}]" for label in springs)),
        characteristics=runs,
        mass_offsets=tuple(placed),
    )


def _check(runs: Sequence[Characteristics], offsets: Sequence[MassOffset]) -> None:
    twice = [name for name, count in Counter(run.name for run in runs).items() if count > 1]
    if twice:
        raise InputError(f"the name {twice[0]!r} is used by more than one run", "Give each run its own name.")
    if len(runs) < 2:
        raise UndeterminedError(
            f"{counted(len(runs), 'run')} cannot fix masses and stiffness: only their ratio shows in the response",
            "Add a run with the same spring and another known added mass.",
        )
    names = {run.name for run in runs}
    for offset in offsets:
        for name in (offset.from_run, offset.to_run):
            if name not in names:
                raise InputError(
                    f"the mass offset {offset.from_run!r} → {offset.to_run!r} names the unknown run {name!r}",
                    f"The runs are {', '.join(map(repr, sorted(names)))}.",
                )
        if offset.from_run == offset.to_run:
            raise InputError(f"a mass offset joins run {offset.from_run!r} to itself", "Join two different runs.")


def undetermined_springs(system: StackedSystem) -> tuple[str, ...]:
    """Spring labels whose stiffness the known mass differences do not fix.

    Parameters
    ----------
    system : StackedSystem

    Returns
    -------
    tuple of str
        Empty where all are fixed; all labels where no two runs differ in mass.

    Notes
    -----
    Measured frequencies of runs that must be equal (same spring, masses joined by a zero difference) differ by noise
    alone, so they are replaced by their mean before the rank is judged.
    """
    runs, offsets = system.characteristics, system.mass_offsets
    springs = list(dict.fromkeys(run.spring for run in runs))
    if not any(offset.difference for offset in offsets):
        return tuple(springs)
    ratio = _ideal_ratios(system)  # m/k of each run, so that each offset is a row in the stiffnesses alone
    spring = {run.name: springs.index(run.spring) for run in runs}
    reduced = np.zeros((len(offsets) + len(springs), len(springs)))
    for row, offset in zip(reduced, offsets, strict=False):
        row[spring[offset.to_run]] += ratio[offset.to_run]
        row[spring[offset.from_run]] -= ratio[offset.from_run]
    _, singular, right = np.linalg.svd(reduced / max(ratio.values()))
    free = right[singular < 1e-9]
    return tuple(label for i, label in enumerate(springs) if free.size and np.abs(free[:, i]).max() > 1e-6)


def require_determined(system: StackedSystem) -> None:
    """Raise unless the known mass differences fix every unknown of the system.

    Raises
    ------
    stepid.errors.UndeterminedError
        Naming the unknowns that are not fixed and the run to add.
    """
    loose = undetermined_springs(system)
    if not loose:
        return
    masses = [run.name for run in system.characteristics if run.spring in loose]
    if len(masses) == len(system.characteristics):
        raise UndeterminedError(
            "no known difference in mass fixes the scale: masses and stiffness are known up to a common factor only",
            f"Add a run with spring {loose[0]!r}, on a base already used, with another known added mass.",
        )
    raise UndeterminedError(
        f"the stiffness of spring {', '.join(map(repr, loose))} is not fixed, nor the mass of "
        f"{', '.join(map(repr, masses))}: no known mass difference reaches them",
        f"Add a run with spring {loose[0]!r} on the base of {masses[0]!r} with another known added mass.",
    )


def _ideal_ratios(system: StackedSystem) -> dict[str, float]:
    group = {run.name: run.name for run in system.characteristics}

    def root(name: str) -> str:
        while group[name] != name:
            name = group[name]
        return name

    for offset in system.mass_offsets:
        if offset.difference == 0:
            group[root(offset.to_run)] = root(offset.from_run)
    sums: dict[tuple[str, str], list[float]] = {}
    for run in system.characteristics:
        sums.setdefault((root(run.name), run.spring), []).append(run.natural_frequency**-2)
    return {run.name: float(np.mean(sums[root(run.name), run.spring])) for run in system.characteristics}
