"""Table 2 is the unweighted least-squares solution of the corrected Eq. 10: the reading notes' checks, repeated."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

import stepid

MASSES = np.array([0.9538, 1.4940, 2.4357, 2.9951])
DAMPING = np.array([14.01, 13.85, 15.42, 16.19])
GAINS = np.array([3.618, 3.633, 3.698, 3.876])  # cm/V
CASES = ("case 4", "case 5", "case 6", "case 7")


@pytest.fixture(scope="module")
def system() -> stepid.StackedSystem:
    data = stepid.datasets.burchett()
    return stepid.assemble(data.characteristics, data.mass_offsets)


def test_table_2(system: stepid.StackedSystem) -> None:
    found = stepid.solve(system, solver=stepid.OrdinaryLeastSquares())
    np.testing.assert_allclose([found.masses[c] for c in CASES], MASSES, atol=2e-4)
    assert found.stiffness["medium"] == pytest.approx(216.2, abs=0.05)
    for damping in (found.damping, found.damping_from_stiffness):
        np.testing.assert_allclose([damping[c] for c in CASES], DAMPING, atol=0.01)
    np.testing.assert_allclose([100 * found.static_gain[c] for c in CASES], GAINS, rtol=1e-12)


def test_printed_formulas_for_damping_lack_the_damping_ratio(system: stepid.StackedSystem) -> None:
    first = system.characteristics[0]
    printed = 2 * MASSES[0] * first.damped_frequency / np.sqrt(1 - first.damping_ratio**2)
    assert printed == pytest.approx(28.7, abs=0.1)
    assert printed * first.damping_ratio == pytest.approx(14.01, abs=0.01)


def test_weighted_solve_restores_the_mass_steps(system: stepid.StackedSystem) -> None:
    found = stepid.solve(system)
    np.testing.assert_allclose(np.diff([found.masses[c] for c in CASES]), [0.5, 1.0, 0.5], atol=0.005)
    assert found.base_mass["cart"] == found.masses["case 4"]


def test_heavily_weighted_differences_give_the_limit_of_the_notes(system: stepid.StackedSystem) -> None:
    data = stepid.datasets.burchett()
    exact = [offset.model_copy(update={"uncertainty": 0.0}) for offset in data.mass_offsets]
    found = stepid.solve(stepid.assemble(data.characteristics, exact), solver=stepid.OrdinaryLeastSquares())
    np.testing.assert_allclose(list(found.masses.values()), [0.9536, 1.4536, 2.4536, 2.9536], atol=2e-4)
    assert found.stiffness["medium"] == pytest.approx(214.3, abs=0.05)


def test_uncertainty_of_the_peak_times(system: stepid.StackedSystem) -> None:
    for run in system.characteristics:
        assert run.uncertainty.peak_time == pytest.approx(0.0088542 / np.sqrt(12))
        samples = run.peak_time / 0.0088542
        assert abs(samples - round(samples)) < 0.06  # picked at a sample


def test_peak_times_and_damping_ratios_recovered_from_table_2() -> None:
    """Nine equations in eight unknowns: masses, both damping formulas (times k), and the stiffness."""

    def residual(unknowns: np.ndarray) -> np.ndarray:
        runs = [
            stepid.Characteristics(name=c, peak_time=t, damping_ratio=z, spring="medium")
            for c, t, z in zip(CASES, unknowns[:4], unknowns[4:], strict=True)
        ]
        offsets = stepid.datasets.burchett().mass_offsets
        found = stepid.solve(stepid.assemble(runs, offsets), solver=stepid.OrdinaryLeastSquares())
        return np.concatenate(
            [
                [found.masses[c] - m for c, m in zip(CASES, MASSES, strict=True)],
                [(found.damping[c] - d) / 10 for c, d in zip(CASES, DAMPING, strict=True)],
                [(found.stiffness["medium"] - 216.2) / 100],
            ]
        )

    runs = stepid.datasets.burchett().characteristics
    start = np.concatenate([[0.24, 0.28, 0.35, 0.39], [0.5, 0.4, 0.33, 0.3]])
    solution = least_squares(residual, start, xtol=1e-12, ftol=1e-12)
    assert np.abs(solution.fun).max() < 1e-3
    np.testing.assert_allclose(solution.x[:4], [r.peak_time for r in runs], atol=3e-4)
    np.testing.assert_allclose(solution.x[4:], [r.damping_ratio for r in runs], atol=2e-3)
    for run in runs:
        assert stepid.characteristics.overshoot_of(run.damping_ratio) == pytest.approx(run.overshoot, abs=2e-5)


def test_printed_masses_satisfy_the_normal_equation_of_the_stiffness_column() -> None:
    """For that column Σ (1 − ζ²)(m ω_d² − k (1 − ζ²)) = 0; with both formulas for c the sum needs Table 2 alone."""
    data = stepid.datasets.burchett()
    w = np.array([r.damped_frequency for r in data.characteristics])
    z = np.array([r.damping_ratio for r in data.characteristics])
    terms = (1 - z**2) * (MASSES * w**2 - 216.193 * (1 - z**2))
    assert abs(terms.sum()) < 2e-4 * np.abs((1 - z**2) ** 2 * 216.193).sum()
