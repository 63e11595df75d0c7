"""From the stacked system to identified parameters with their full covariance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.core.mass_offset import WEIGHT, WEIGHT_UNCERTAINTY, MassOffset
from stepid.core.quantities import in_own_quantities
from stepid.core.recorded import recorded
from stepid.core.takes import a, able, optional, takes
from stepid.identification.characteristics_model import Characteristics
from stepid.identification.errors_in_variables import ErrorsInVariables
from stepid.identification.parameters import IdentifiedParameters, ParameterUncertainty, StackedSystem
from stepid.identification.solvers import Solver, WeightedLeastSquares, require_sense, run_covariances, scaled_rows
from stepid.identification.stacked import require_determined


def damping_from_mass(mass: Array, damped_frequency: Array, damping_ratio: Array) -> Array:
    """Damping constant c = 2ζmω_d/√(1 − ζ²), N·s/m; the paper prints it without the ζ in the numerator.

    Parameters
    ----------
    mass, damped_frequency, damping_ratio : array or float
        kg, rad/s, –.
    """
    return np.asarray(2 * damping_ratio * mass * damped_frequency / np.sqrt(1 - damping_ratio**2))


def damping_from_stiffness(stiffness: Array, damped_frequency: Array, damping_ratio: Array) -> Array:
    """Damping constant c = 2ζk√(1 − ζ²)/ω_d, N·s/m; the paper prints it without the ζ in the numerator.

    Parameters
    ----------
    stiffness, damped_frequency, damping_ratio : array or float
        N/m, rad/s, –.
    """
    return np.asarray(2 * damping_ratio * stiffness * np.sqrt(1 - damping_ratio**2) / damped_frequency)


a_solver = optional(able("unknowns", "a solver with its brackets, as WeightedLeastSquares()"))
"""Check of an argument `solver`."""


@in_own_quantities
@takes(system=a(StackedSystem, "a StackedSystem from stepid.assemble"), solver=a_solver)
@recorded(solver=WeightedLeastSquares)
def solve(system: StackedSystem, *, solver: Solver | None = None) -> IdentifiedParameters:
    """Solve the stacked system for masses and stiffnesses, then for the damping constants.

    Parameters
    ----------
    system : StackedSystem
        From `stepid.assemble`.
    solver : Solver, optional
        Default `WeightedLeastSquares()`; `OrdinaryLeastSquares()` is the paper's own solve; or any object with its
        method `unknowns`.

    Returns
    -------
    IdentifiedParameters
        With the covariance of all values: the uncertainties of damped frequencies, damping ratios and mass
        differences carried through the whole solve (delta method). The textbook s²(AᵀA)⁻¹ does not apply, because
        the noise stands in the matrix.

    Raises
    ------
    stepid.errors.UndeterminedError
        If the known mass differences do not fix every unknown; the message names the run to add.
    stepid.errors.IdentificationError
        If a mass or stiffness comes out negative, or every run with more mass swings faster: the peaks contradict the
        known mass differences.
    stepid.errors.InputError
        If the weighted solve meets a run without uncertainties.
    """
    method = WeightedLeastSquares() if solver is None else solver
    require_determined(system)
    runs = system.characteristics
    measured = method.readings(runs) if isinstance(method, ErrorsInVariables) else read(runs)
    differences = np.array([offset.difference for offset in system.mass_offsets])
    unknowns = method.unknowns(system, measured, differences)
    require_sense(system, unknowns)
    outputs = _Outputs(runs, _pooling_weights(runs))
    values = outputs(unknowns, measured)
    inputs = _input_covariance(system)
    known = np.diag(inputs) == 0  # exact inputs need no derivative; exact differences must not be moved
    jacobian = _jacobian(system, method, outputs, unknowns, measured, differences, known)
    covariance = jacobian @ inputs @ jacobian.T
    base_variance = outputs.added_weight_variance(system.mass_offsets)
    index = [outputs.labels.index(label) for label in base_variance]
    covariance[index, index] += list(base_variance.values())
    misfit = None
    spare = len(system.mass_offsets) - len(outputs.springs)  # rows less unknowns
    if isinstance(method, WeightedLeastSquares) and spare > 0:
        residual, _ = scaled_rows(system, unknowns, measured, differences)
        misfit = float(np.sqrt(residual @ residual / spare))
    return _result(outputs, values, covariance, misfit, f"{type(method).__name__}()")


def read(runs: Sequence[Characteristics]) -> Array:
    """Damped frequency [rad/s] and damping ratio of each run as they were read, shape (n, 2)."""
    return np.array([[run.damped_frequency, run.damping_ratio] for run in runs])


class _Outputs:
    """All values that follow from unknowns and measured values, as one labelled vector."""

    def __init__(self, runs: Sequence[Characteristics], weights: Mapping[str, Array]) -> None:
        self.runs = runs
        self.weights = weights
        self.springs = list(dict.fromkeys(run.spring for run in runs))
        self.bases: dict[str, int] = {}  # base label -> its lightest run
        for i, run in enumerate(runs):
            best = self.bases.get(run.base)
            if run.added_mass is not None and (best is None or run.added_mass < (runs[best].added_mass or 0.0)):
                self.bases[run.base] = i
        names = [run.name for run in runs]
        self.labels = (
            *(f"masses[{name}]" for name in names),
            *(f"stiffness[{label}]" for label in self.springs),
            *(f"damping[{name}]" for name in names),
            *(f"damping_from_stiffness[{name}]" for name in names),
            *(f"pooled_damping[{label}]" for label in weights),
            *(f"base_mass[{label}]" for label in self.bases),
        )

    def __call__(self, unknowns: Array, measured: Array) -> Array:
        count = len(self.runs)
        mass = unknowns[:count]
        stiffness = unknowns[[count + self.springs.index(run.spring) for run in self.runs]]
        frequency, ratio = measured.T
        damping = damping_from_mass(mass, frequency, ratio)
        return np.concatenate(
            [
                unknowns,
                damping,
                damping_from_stiffness(stiffness, frequency, ratio),
                [weight @ damping for weight in self.weights.values()],
                [mass[i] - (self.runs[i].added_mass or 0.0) for i in self.bases.values()],
            ]
        )

    def added_weight_variance(self, offsets: Sequence[MassOffset]) -> dict[str, float]:
        """Variance that the lightest run's own weights add to the base mass, kg²: known as the differences are."""
        known = [offset.uncertainty**2 / abs(offset.difference) for offset in offsets if offset.difference]
        per_mass = sum(known) / len(known) if known else WEIGHT_UNCERTAINTY**2 / WEIGHT
        return {f"base_mass[{base}]": per_mass * (self.runs[i].added_mass or 0.0) for base, i in self.bases.items()}


def _pooling_weights(runs: Sequence[Characteristics]) -> dict[str, Array]:
    """Weights, by damper label, that pool the runs' damping: inverse variances, equal where not all are known."""
    weights = {}
    for damper in dict.fromkeys(run.damper for run in runs):
        member = np.array([run.damper == damper for run in runs])
        # what differs from run to run: relative variance of 2ζω_d (mass and stiffness errors are common)
        relative = np.array(
            [
                (run.uncertainty.damping_ratio / run.damping_ratio) ** 2
                + (run.uncertainty.damped_frequency / run.damped_frequency) ** 2
                if run.damping_ratio > 0
                else 0.0
                for run in runs
            ]
        )
        usable = np.all(relative[member] > 0)
        weight = np.where(member, 1.0 / np.where(member & usable, relative, 1.0), 0.0)
        weights[damper] = weight / weight.sum()
    return weights


def _jacobian(
    system: StackedSystem,
    method: Solver,
    outputs: _Outputs,
    unknowns: Array,
    measured: Array,
    differences: Array,
    known: npt.NDArray[np.bool_],
) -> Array:
    """Derivative of all outputs by (ω_d, ζ of each run; differences), by central differences."""
    flat, scale = measured.ravel(), np.abs(differences).max()
    inputs = np.concatenate([flat, differences])
    steps = 1e-5 * np.concatenate([np.maximum(np.abs(flat), 1e-3), np.full(differences.size, scale)])

    def evaluate(point: Array) -> Array:
        at = point[: flat.size].reshape(measured.shape)
        return outputs(method.unknowns(system, at, point[flat.size :], start=unknowns), at)

    columns = []
    for i, step in enumerate(steps):
        if known[i]:
            columns.append(np.zeros(len(outputs.labels)))
            continue
        shift = np.zeros(inputs.size)
        shift[i] = step
        columns.append((evaluate(inputs + shift) - evaluate(inputs - shift)) / (2 * step))
    return np.column_stack(columns)


def _input_covariance(system: StackedSystem) -> Array:
    blocks = run_covariances(system.characteristics)
    count = 2 * len(blocks)
    out = np.zeros((count + len(system.mass_offsets),) * 2)
    for i, block in enumerate(blocks):
        out[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = block
    for i, offset in enumerate(system.mass_offsets):
        out[count + i, count + i] = offset.uncertainty**2
    return out


def _result(
    outputs: _Outputs, values: Array, covariance: Array, misfit: float | None, solver: str
) -> IdentifiedParameters:
    runs = outputs.runs
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))

    def pick(numbers: Array, field: str) -> dict[str, float]:
        start = f"{field}["
        return {
            label[len(start) : -1]: float(number)
            for label, number in zip(outputs.labels, numbers, strict=True)
            if label.startswith(start)
        }

    found = {field: pick(values, field) for field in _FIELDS}
    return IdentifiedParameters(
        masses=found["masses"],
        stiffness=found["stiffness"],
        damping=found["damping"],
        damping_from_stiffness=found["damping_from_stiffness"],
        pooled_damping=found["pooled_damping"],
        base_mass=found["base_mass"],
        static_gain={run.name: run.static_gain for run in runs if run.static_gain is not None},
        springs={run.name: run.spring for run in runs},
        dampers={run.name: run.damper for run in runs},
        bases={run.name: run.base for run in runs},
        uncertainty=ParameterUncertainty(
            **{field: pick(spread, field) for field in _FIELDS},
            static_gain={run.name: run.uncertainty.static_gain or 0.0 for run in runs if run.static_gain is not None},
        ),
        covariance=covariance,
        covariance_labels=outputs.labels,
        solver=solver,
        misfit=misfit,
    )


_FIELDS = ("masses", "stiffness", "damping", "damping_from_stiffness", "pooled_damping", "base_mass")
