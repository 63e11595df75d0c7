"""The two solves of the stacked system: the paper's, and one weighted by standard uncertainties."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array, Model
from stepid.errors import ConvergenceError, IdentificationError, InputError
from stepid.identification.characteristics_model import Characteristics
from stepid.identification.parameters import StackedSystem
from stepid.identification.stacked import frequency_row

_NOTHING = 1e-9  # of χ², that is worth no further pass


class OrdinaryLeastSquares(Model):
    """The paper's solve of Eq. 10: plain least squares in the units at hand.

    Force rows [N/m] and mass rows [kg] count alike as they stand, so the answer depends on the unit of time and on
    which mass differences are taken; it is here to reproduce Table 2. Because the readings stand in the matrix and the
    right-hand side of the force rows is zero, disagreement between runs shrinks masses and stiffness together: with
    many runs, stiff springs or dry friction towards nothing. Differences known exactly (uncertainty 0)
    are constraints.
    """

    def unknowns(
        self, system: StackedSystem, measured: Array, differences: Array, *, start: Array | None = None
    ) -> Array:
        """Solve for the unknowns of `system` at given measured values.

        Parameters
        ----------
        system : StackedSystem
            Gives the structure.
        measured : array, shape (n, 2)
            Damped frequency [rad/s] and damping ratio of each run.
        differences : array, shape (d,)
            kg, the mass differences.
        start : array, shape (n + s,), optional
            Where an iterating solver begins; this one needs none.

        Returns
        -------
        array, shape (n + s,)
            Masses [kg], then stiffnesses [N/m].
        """
        matrix, right = _fill(system, measured, differences)
        exact = _exact(system)
        return _constrained(matrix[~exact], right[~exact], matrix[exact], right[exact])


class WeightedLeastSquares(Model):
    """Least squares with each row scaled by its standard uncertainty.

    Damped frequency and damping ratio stand in the matrix of Eq. 10, so scaling it once would leave a bias (errors in
    variables). Each pass therefore linearizes at the model: the frequency row of a run becomes
    ln(ω_d²/(1 − ζ²)) − ln k + ln m over its standard uncertainty, the mass row its misfit over its own. The answer
    does not depend on the unit of time, the order of the runs, or the choice among equivalent differences.
    Differences known exactly (uncertainty 0) are constraints.

    Parameters
    ----------
    iterations : int
        At most this many passes.
    """

    iterations: int = 200

    def unknowns(
        self, system: StackedSystem, measured: Array, differences: Array, *, start: Array | None = None
    ) -> Array:
        """Solve for the unknowns; see `OrdinaryLeastSquares.unknowns`.

        Raises
        ------
        stepid.errors.InputError
            If a run carries no uncertainty.
        stepid.errors.ConvergenceError
            If the passes do not settle: the peaks contradict the known mass differences.
        """
        unknowns = starting_point(system, measured, differences) if start is None else start
        promised = np.inf
        exact = np.array([offset.uncertainty == 0 for offset in system.mass_offsets])
        count = len(system.characteristics)
        for _ in range(self.iterations):
            residual, slope = scaled_rows(system, unknowns, measured, differences)
            hard = np.concatenate([np.zeros(count, dtype=bool), exact])
            step = _constrained(slope[~hard], -residual[~hard], slope[hard], -residual[hard])
            cost, length = float(residual[~hard] @ residual[~hard]), 1.0
            before, promised = promised, float(np.sum((slope[~hard] @ step) ** 2))  # decrease of χ²
            while length > 1e-6:  # a trial step that leaves the positive side or climbs is halved
                trial = unknowns + length * step
                if np.all(trial > 0):
                    ahead = scaled_rows(system, trial, measured, differences)[0][~hard]
                    if float(ahead @ ahead) <= cost * (1 + 1e-9) + 1e-18:
                        break
                length /= 2
            else:
                trial = unknowns
            change = float(np.max(np.abs(step / unknowns)))
            unknowns = trial
            if change < 1e-13 or (promised < _NOTHING and promised >= 0.25 * before):  # rounding of a step
                return unknowns
        best = ", ".join(f"{label} = {v:.4g}" for label, v in zip(system.column_labels, unknowns, strict=True))
        raise ConvergenceError(
            f"the weighted solve does not settle: the peaks contradict the known mass differences "
            f"(best so far: {best})",
            "More mass must give a later peak with the same spring: check added_mass, spring labels and peak times.",
        )


def scaled_rows(system: StackedSystem, unknowns: Array, measured: Array, differences: Array) -> tuple[Array, Array]:
    """Residuals of all rows over their standard uncertainties, and their derivative by the unknowns.

    Parameters
    ----------
    system : StackedSystem
    unknowns : array, shape (n + s,)
        kg, N/m; all positive.
    measured : array, shape (n, 2)
        Damped frequency [rad/s] and damping ratio.
    differences : array, shape (d,)
        kg.

    Returns
    -------
    tuple of array, shapes (n + d,) and (n + d, n + s)
        Frequency rows first, then mass rows. Exact differences are scaled by the largest difference.
    """
    runs, offsets = system.characteristics, system.mass_offsets
    count, springs = len(runs), _springs(system)
    frequency, ratio = measured.T
    # ln ω_n² = ln ω_d² − ln(1 − ζ²)
    slope = np.column_stack([2 / frequency, 2 * ratio / (1 - ratio**2)])
    spread = np.sqrt(np.einsum("ij,ijk,ik->i", slope, run_covariances(runs), slope))
    _require_uncertainty(runs, spread)
    mass, stiffness = unknowns[:count], unknowns[springs]
    residual = np.empty(count + len(offsets))
    rows = np.zeros((residual.size, unknowns.size))
    residual[:count] = (np.log(frequency**2 / (1 - ratio**2)) - np.log(stiffness / mass)) / spread
    rows[np.arange(count), np.arange(count)] = 1 / (mass * spread)
    rows[np.arange(count), springs] = -1 / (stiffness * spread)
    column = {run.name: i for i, run in enumerate(runs)}
    largest = max((abs(offset.difference) for offset in offsets), default=0.0) or 1.0
    for i, (offset, difference) in enumerate(zip(offsets, differences, strict=True), start=count):
        one, two = column[offset.from_run], column[offset.to_run]
        scale = offset.uncertainty or largest
        residual[i] = (unknowns[two] - unknowns[one] - difference) / scale
        rows[i, two], rows[i, one] = 1 / scale, -1 / scale
    return residual, rows


def starting_point(system: StackedSystem, measured: Array, differences: Array) -> Array:
    """Masses that keep all known differences over the best of many base masses, with the stiffnesses that they mean."""
    runs = system.characteristics
    offset_mass = _relative_masses(system, differences)
    squared = measured[:, 0] ** 2 / (1 - measured[:, 1] ** 2)
    springs = np.array(_springs(system)) - len(runs)
    best, least = np.empty(0), np.inf
    for base in np.geomspace(1e-3, 1e3, 121) * float(np.max(np.abs(differences))):
        mass = offset_mass + base
        stiffness = [np.exp(np.mean(np.log(squared * mass)[springs == i])) for i in range(springs.max() + 1)]
        trial = np.concatenate([mass, stiffness])
        residual = scaled_rows(system, trial, measured, differences)[0][: len(runs)]
        cost = float(residual @ residual)
        if cost < least:
            best, least = trial, cost
    return best


def _relative_masses(system: StackedSystem, differences: Array) -> Array:
    """Mass of each run above the lightest of those that offsets join it to, kg."""
    names = [run.name for run in system.characteristics]
    mass = np.full(len(names), np.nan)
    links = [
        (names.index(o.from_run), names.index(o.to_run), float(d))
        for o, d in zip(system.mass_offsets, differences, strict=True)
    ]
    for first in range(len(names)):
        if not np.isnan(mass[first]):
            continue
        mass[first], group, todo = 0.0, [first], [first]
        while todo:
            here = todo.pop()
            for one, two, difference in links:
                for a, b, step in ((one, two, difference), (two, one, -difference)):
                    if a == here and np.isnan(mass[b]):
                        mass[b] = mass[a] + step
                        group.append(b)
                        todo.append(b)
        mass[group] -= np.min(mass[group])
    return mass


class Solver(Protocol):
    """How the stacked system is solved: `OrdinaryLeastSquares`, `WeightedLeastSquares`, or one of your own."""

    def unknowns(
        self, system: StackedSystem, measured: Array, differences: Array, *, start: Array | None = None
    ) -> Array:
        """Solve for the unknowns of `system` at given measured values; see `OrdinaryLeastSquares.unknowns`.

        Uncertainties come from derivatives of this function, so that it must be smooth.
        """


def run_covariances(runs: Sequence[Characteristics]) -> Array:
    """Covariance of damped frequency [rad/s] and damping ratio of each run, shape (n, 2, 2)."""
    out = np.empty((len(runs), 2, 2))
    for block, run in zip(out, runs, strict=True):
        frequency, ratio = run.uncertainty.damped_frequency, run.uncertainty.damping_ratio
        cross = run.correlation * frequency * ratio
        block[:] = [[frequency**2, cross], [cross, ratio**2]]
    return out


def require_sense(system: StackedSystem, unknowns: Array) -> None:
    """Raise IdentificationError where a mass or stiffness is not positive, or more mass quickens every run."""
    by_name = {run.name: run for run in system.characteristics}
    signs = []
    for offset in system.mass_offsets:
        one, two = by_name[offset.from_run], by_name[offset.to_run]
        if one.spring == two.spring and offset.difference:
            signs.append((two.natural_frequency**-2 - one.natural_frequency**-2) * offset.difference)
    if signs and max(signs) <= 0:
        raise IdentificationError(
            "every run with more mass has the higher natural frequency: "
            "the peaks contradict the known mass differences",
            "More mass must slow the same spring down: check added_mass, spring labels and peak times.",
        )
    if np.any(unknowns <= 0):
        worst = int(np.argmin(unknowns))
        raise IdentificationError(
            f"{system.column_labels[worst]} comes out at {unknowns[worst]:.3g}: "
            "the peaks contradict the known mass differences",
            "More mass must give a later peak with the same spring: check added_mass, spring labels and peak times.",
        )


def _require_uncertainty(runs: Sequence[Characteristics], spread: Array) -> None:
    for run, value in zip(runs, spread, strict=True):
        if not value > 0:
            raise InputError(
                f"the characteristics of {run.name!r} carry no uncertainty of the peak time or damped frequency",
                "Give uncertainty=CharacteristicsUncertainty(peak_time=…, overshoot=…), or use OrdinaryLeastSquares().",
            )


def _springs(system: StackedSystem) -> list[int]:
    count = len(system.characteristics)
    labels = list(dict.fromkeys(run.spring for run in system.characteristics))
    return [count + labels.index(run.spring) for run in system.characteristics]


def _row_numbers(system: StackedSystem) -> tuple[list[int], list[int]]:
    """Rows of the runs and of the offsets; assemble puts a run's offsets behind its frequency row."""
    runs: list[int] = []
    offsets: list[int] = []
    row = 0
    for run in system.characteristics:
        runs.append(row)
        follow = sum(offset.from_run == run.name for offset in system.mass_offsets)
        offsets += range(row + 1, row + 1 + follow)
        row += 1 + follow
    return runs, offsets


def _exact(system: StackedSystem) -> npt.NDArray[np.bool_]:
    mask = np.zeros(system.rhs.size, dtype=bool)
    mask[_row_numbers(system)[1]] = [offset.uncertainty == 0 for offset in system.mass_offsets]
    return mask


def _fill(system: StackedSystem, measured: Array, differences: Array) -> tuple[Array, Array]:
    matrix, right = system.matrix.copy(), system.rhs.copy()
    run_row, offset_row = _row_numbers(system)
    for i, (row, column) in enumerate(zip(run_row, _springs(system), strict=True)):
        matrix[row, i], matrix[row, column] = frequency_row(measured[i, 0], measured[i, 1])
    right[offset_row] = differences
    return matrix, right


def _constrained(matrix: Array, right: Array, exact: Array, value: Array) -> Array:
    """Least squares of matrix·x = right subject to exact·x = value, by QR and SVD: no normal equations."""
    scale = np.sqrt((matrix**2).sum(axis=0) + (exact**2).sum(axis=0))
    scale[scale == 0] = 1.0
    matrix, exact = matrix / scale, exact / scale
    if not exact.shape[0]:
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0] / scale)
    # the constraint fixes the part in its row space; the rest is free in its null space
    left, singular, basis = np.linalg.svd(exact)
    rank = int(np.sum(singular > 1e-12 * singular[0]))
    fixed = basis[:rank].T @ ((left.T @ value)[:rank] / singular[:rank])
    free = basis[rank:].T
    rest = np.linalg.lstsq(matrix @ free, right - matrix @ fixed, rcond=None)[0]
    return np.asarray((fixed + free @ rest) / scale)
