"""The solver with errors in variables: exact on exact readings, most likely on noisy ones, and as sure as it says."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

import stepid
from closed_form import draw_plant, make_campaign
from stepid.identification.second_order import damping_ratio
from stepid.identification.solvers import run_covariances


def system(noise: float, seed: int) -> stepid.StackedSystem:
    rng = np.random.default_rng(seed)
    made = make_campaign(draw_plant(rng), rng, noise=noise, weight_spread=0.005)
    runs = [stepid.characterize(run) for run in made.experiments]
    return stepid.assemble(runs, made.mass_offsets)


def test_it_is_the_most_likely_answer() -> None:
    stacked = system(300e-6, 3)
    runs = stacked.characteristics
    read = np.array([[run.damped_frequency, run.damping_ratio] for run in runs])
    roots = [np.linalg.inv(np.linalg.cholesky(block)) for block in run_covariances(runs)]
    found = stepid.solve(stacked, solver=stepid.ErrorsInVariables())
    names = [run.name for run in runs]

    def rows(free: np.ndarray) -> np.ndarray:  # masses, stiffness, damping ratios: the frequencies follow
        mass, stiffness, ratio = free[: len(runs)], free[len(runs)], free[len(runs) + 1 :]
        frequency = np.sqrt(stiffness / mass) * np.sqrt(1 - ratio**2)
        off = [
            root @ (one - two) for root, one, two in zip(roots, np.column_stack([frequency, ratio]), read, strict=True)
        ]
        chain = [
            (mass[names.index(o.to_run)] - mass[names.index(o.from_run)] - o.difference) / o.uncertainty
            for o in stacked.mass_offsets
        ]
        return np.concatenate([*off, chain])

    start = np.concatenate([list(found.masses.values()), list(found.stiffness.values()), read[:, 1]])
    best = least_squares(rows, start, x_scale=np.abs(start), xtol=1e-14, ftol=1e-14, gtol=1e-14).x
    assert list(found.masses.values()) == pytest.approx(best[: len(runs)], rel=1e-5)
    assert list(found.stiffness.values()) == pytest.approx([best[len(runs)]], rel=1e-5)


def test_without_noise_all_solvers_agree() -> None:
    stacked = system(1e-9, 4)
    weighted = stepid.solve(stacked, solver=stepid.WeightedLeastSquares())
    found = stepid.solve(stacked, solver=stepid.ErrorsInVariables())
    assert found.stiffness["medium"] == pytest.approx(weighted.stiffness["medium"], rel=1e-6)
    assert found.solver == "ErrorsInVariables()"
    assert found.uncertainty.stiffness["medium"] == pytest.approx(weighted.uncertainty.stiffness["medium"], rel=1e-3)


def test_equal_masses_are_constraints_as_of_the_weighted_solve() -> None:
    stacked = system(200e-6, 5)
    runs = stacked.characteristics
    twin = runs[0].model_copy(update={"name": "twin", "damped_frequency": 1.002 * runs[0].damped_frequency})
    same = stepid.MassOffset(from_run=runs[0].name, to_run="twin", difference=0.0, uncertainty=0.0)
    joined = stepid.assemble([*runs, twin], [*stacked.mass_offsets, same])
    found = stepid.solve(joined, solver=stepid.ErrorsInVariables())
    weighted = stepid.solve(joined, solver=stepid.WeightedLeastSquares())
    assert found.masses["twin"] == pytest.approx(found.masses[runs[0].name], rel=1e-12)
    assert found.stiffness["medium"] == pytest.approx(weighted.stiffness["medium"], rel=1e-12)


def test_too_few_passes_are_told() -> None:
    with pytest.raises(stepid.errors.ConvergenceError, match=r"errors in variables does not settle.*check added_mass"):
        stepid.solve(system(300e-6, 3), solver=stepid.ErrorsInVariables(iterations=1))


def test_only_an_overshoot_that_is_left_is_corrected() -> None:
    solver = stepid.ErrorsInVariables()
    fields = {"name": "a", "peak_time": 0.2, "peak_time_bias": 0.01, "overshoot": 0.3}
    less, gone = (stepid.Characteristics(**fields, overshoot_bias=bias) for bias in (0.1, 0.4))
    read = damping_ratio(0.3)
    frequency, ratio = solver.readings([less])[0]
    assert frequency == pytest.approx(np.pi / 0.19)
    assert ratio == pytest.approx(damping_ratio(0.2))
    assert solver.readings([gone])[0] == pytest.approx([np.pi / 0.19, read])
