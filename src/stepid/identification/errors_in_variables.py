"""The stacked system solved for what was read, too: errors in the variables of its matrix."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stepid.core.base import Array, Model
from stepid.errors import ConvergenceError
from stepid.identification.characteristics_model import Characteristics
from stepid.identification.parameters import StackedSystem
from stepid.identification.second_order import damping_ratio
from stepid.identification.solvers import WeightedLeastSquares, run_covariances, scaled_rows

_SETTLED, _NEAR = 1e-12, 1e-8  # relative change of the unknowns


class ErrorsInVariables(Model):
    """Maximum likelihood of the readings: damped frequencies and damping ratios are fitted with masses and stiffnesses.

    `WeightedLeastSquares` takes each run's uncertainty at the values that were read; this solver takes it at the values
    that the fit finds, nearest to those read in the metric of their covariance. The two agree to first order in the
    noise. A known bias of the readings, as that of `SampledPeak`, which takes the largest of noisy samples, is taken
    off first.

    Parameters
    ----------
    iterations : int
        At most this many passes.
    """

    iterations: int = 100

    def readings(self, runs: Sequence[Characteristics]) -> Array:
        """Damped frequency [rad/s] and damping ratio of each run without their expected errors, shape (n, 2)."""
        return np.array([_unbiased(run) for run in runs])

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
        unknowns = WeightedLeastSquares().unknowns(system, measured, differences) if start is None else start
        covariance = run_covariances(system.characteristics)
        count, exact = len(covariance), np.array([offset.uncertainty == 0 for offset in system.mass_offsets])
        if exact.any():  # constraints: the weighted solve keeps them, and differs in second order only
            return WeightedLeastSquares().unknowns(system, measured, differences, start=unknowns)
        nearest, change = measured, np.inf
        for _ in range(self.iterations):
            nearest = _nearest(system, unknowns, nearest, measured, covariance)
            residual, rows = scaled_rows(system, unknowns, nearest, differences)
            slope = _slope(nearest)
            spread = np.sqrt(np.einsum("ij,ijk,ik->i", slope, covariance, slope))
            residual[:count] += np.einsum("ij,ij->i", slope, measured - nearest) / spread
            step = -np.linalg.lstsq(rows / _size(rows), residual, rcond=None)[0] / _size(rows)
            unknowns = np.maximum(unknowns + step, 0.1 * unknowns)
            before, change = change, float(np.max(np.abs(step / unknowns)))
            if change < _SETTLED or (change < _NEAR and change >= 0.5 * before):  # converged, or down to rounding
                return unknowns
        raise ConvergenceError(
            "the solve with errors in variables does not settle: the peaks contradict the known mass differences",
            "More mass must give a later peak with the same spring: check added_mass, spring labels and peak times.",
        )


def _unbiased(run: Characteristics) -> tuple[float, float]:
    """Damped frequency and damping ratio as they would be read without a bias."""
    frequency, ratio = run.damped_frequency, run.damping_ratio
    if run.peak_time is not None and run.peak_time_bias:
        frequency *= run.peak_time / (run.peak_time - run.peak_time_bias)
    if run.overshoot is not None and 0 < run.overshoot - run.overshoot_bias < 1:
        ratio += damping_ratio(run.overshoot - run.overshoot_bias) - damping_ratio(run.overshoot)
    return frequency, max(ratio, 0.0)


def _size(rows: Array) -> Array:
    out: Array = np.linalg.norm(rows, axis=0)
    return out


def _slope(values: Array) -> Array:
    """Derivative of ln ω_n² by damped frequency and damping ratio, shape (n, 2)."""
    frequency, ratio = values.T
    return np.column_stack([2 / frequency, 2 * ratio / (1 - ratio**2)])


def _nearest(system: StackedSystem, unknowns: Array, at: Array, measured: Array, covariance: Array) -> Array:
    """The readings nearest to the measured ones that have the natural frequencies of the unknowns, one Newton step."""
    runs = system.characteristics
    springs = list(dict.fromkeys(run.spring for run in runs))
    stiffness = unknowns[[len(runs) + springs.index(run.spring) for run in runs]]
    wanted = np.log(stiffness / unknowns[: len(runs)])
    slope = _slope(at)
    pull = np.einsum("ijk,ik->ij", covariance, slope)
    here = np.log(at[:, 0] ** 2 / (1 - at[:, 1] ** 2)) + np.einsum("ij,ij->i", slope, measured - at)
    out: Array = measured - pull * ((here - wanted) / np.einsum("ij,ij->i", slope, pull))[:, None]
    out[:, 1] = np.clip(out[:, 1], 0.0, 0.99)
    return out
