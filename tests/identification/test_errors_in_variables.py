"""The solver with errors in variables: exact on exact readings, most likely on noisy ones, and as sure as it says."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

import stepid
from closed_form import draw_plant, make_campaign
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
