"""The two solves of the stacked system: the paper's, and one weighted by standard uncertainties."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stepid._base import Array, Model
from stepid.errors import ConvergenceError, IdentificationError, InputError
from stepid.parameters import StackedSystem
from stepid.response import Characteristics
from stepid.stacked import frequency_row


class OrdinaryLeastSquares(Model):
    """The paper's solve of Eq. 10: plain least squares in the units at hand.

    Force rows [N/m] and mass rows [kg] count alike as they stand, so the answer depends on the unit of time and on
    which mass differences are taken; it is here to reproduce Table 2. Differences known exactly (uncertainty 0)
    are constraints.
    """

    def unknowns(self, system: StackedSystem, measured: Array, differences: Array) -> Array:
        """Solve for the unknowns of `system` at given measured values.

        Parameters
        ----------
        system : StackedSystem
            Gives the structure.
        measured : array, shape (n, 2)
            Damped frequency [rad/s] and damping ratio of each run.
        differences : array, shape (d,)
            kg, the mass differences.

        Returns
        -------
        array, shape (n + s,)
            Masses [kg], then stiffnesses [N/m].
        """
        matrix, right = _fill(system, measured, differences)
        exact = _exact(system)
        return _constrained(matrix[~exact], right[~exact], matrix[exact], right[exact])


class WeightedLeastSquares(Model):
    """Least squares with each row scaled by its standard uncertainty, measured values adjusted along.

    Damped frequency and damping ratio stand in the matrix of Eq. 10, so scaling alone would leave a bias
    (errors in variables). Each pass therefore moves the measured values onto the model by their own covariance and
    linearizes there; at the end the scaled squares of all corrections are least (Gauss-Helmert adjustment). The
    answer does not depend on the unit of time, the order of the runs, or the choice among equivalent differences.
    Differences known exactly (uncertainty 0) are constraints.

    Parameters
    ----------
    iterations : int
        At most this many passes.
    """

    iterations: int = 100

    def unknowns(self, system: StackedSystem, measured: Array, differences: Array) -> Array:
        """Solve for the unknowns; see `OrdinaryLeastSquares.unknowns`.

        Raises
        ------
        stepid.errors.InputError
            If a run carries no uncertainty.
        stepid.errors.ConvergenceError
            If the passes do not settle.
        """
        covariance = run_covariances(system.characteristics)
        _require_uncertainty(system.characteristics, covariance)
        exact, count = _exact(system), len(system.characteristics)
        offset_spread = np.array([offset.uncertainty for offset in system.mass_offsets])
        run_row, offset_row = _row_numbers(system)
        unknowns = OrdinaryLeastSquares().unknowns(system, measured, differences)
        if np.any(unknowns <= 0):  # a start on the right side of zero: equal relative weights
            unknowns = _start(system, measured, differences)
        adjusted, change = measured.copy(), np.inf
        for _ in range(self.iterations):
            mass, stiffness = unknowns[:count], unknowns[_springs(system)]
            # f = m ω² − k (1 − ζ²); its gradient by (ω, ζ) at the adjusted values
            slope = np.column_stack([2 * mass * adjusted[:, 0], 2 * stiffness * adjusted[:, 1]])
            carried = np.einsum("ij,ijk->ik", slope, covariance)
            spread = np.sqrt(np.einsum("ij,ij->i", carried, slope))
            matrix, right = _fill(system, adjusted, differences)
            right[run_row] = -np.einsum("ij,ij->i", slope, measured - adjusted)
            scale = np.ones(right.size)
            scale[run_row], scale[offset_row] = spread, np.where(offset_spread > 0, offset_spread, 1.0)
            matrix, right = matrix / scale[:, None], right / scale
            new = _constrained(matrix[~exact], right[~exact], matrix[exact], right[exact])
            misfit = (matrix @ new - right)[run_row] / spread
            adjusted, old = measured - carried * misfit[:, None], adjusted
            before = change
            change = max(np.max(np.abs(new / unknowns - 1)), np.max(np.abs(adjusted - old) / np.abs(measured)))
            unknowns = new
            if np.any(unknowns <= 0) or np.any(adjusted <= 0):
                raise _negative(system, unknowns)
            if change < 1e-13 or (change < 1e-10 and change >= before):  # converged, or down to rounding
                return unknowns
        best = ", ".join(f"{label} = {v:.4g}" for label, v in zip(system.column_labels, unknowns, strict=True))
        raise ConvergenceError(
            f"the weighted solve still changes by {change:.1g} after {self.iterations} passes (best so far: {best})",
            "Check the known mass differences against the peak times, or use OrdinaryLeastSquares().",
        )


Solver = OrdinaryLeastSquares | WeightedLeastSquares


def run_covariances(runs: Sequence[Characteristics]) -> Array:
    """Covariance of damped frequency [rad/s] and damping ratio of each run, shape (n, 2, 2)."""
    out = np.empty((len(runs), 2, 2))
    for block, run in zip(out, runs, strict=True):
        frequency, ratio = run.uncertainty.damped_frequency, run.uncertainty.damping_ratio
        cross = run.correlation * frequency * ratio
        block[:] = [[frequency**2, cross], [cross, ratio**2]]
    return out


def check_positive(system: StackedSystem, unknowns: Array) -> None:
    """Raise IdentificationError where a mass or stiffness is not positive."""
    if np.any(unknowns <= 0):
        raise _negative(system, unknowns)


def _negative(system: StackedSystem, unknowns: Array) -> IdentificationError:
    worst = int(np.argmin(unknowns))
    return IdentificationError(
        f"{system.column_labels[worst]} comes out at {unknowns[worst]:.3g}: "
        "the peaks contradict the known mass differences",
        "More mass must give a later peak with the same spring: check added_mass, spring labels and peak times.",
    )


def _require_uncertainty(runs: Sequence[Characteristics], covariance: Array) -> None:
    for run, block in zip(runs, covariance, strict=True):
        if not block[0, 0] > 0:
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


def _start(system: StackedSystem, measured: Array, differences: Array) -> Array:
    """Solve with frequency rows divided by k-like numbers, mass differences near exact: the limit of exact weights."""
    matrix, right = _fill(system, measured, differences)
    run_row, offset_row = _row_numbers(system)
    matrix[run_row] /= measured[:, :1] ** 2
    return _constrained(matrix[run_row], right[run_row], matrix[offset_row], right[offset_row])


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
