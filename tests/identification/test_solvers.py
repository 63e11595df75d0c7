"""Both solves: exact on exact data, invariant where they should be, with the right covariance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stepid
from made_up_runs import offset, run
from stepid.errors import IdentificationError, InputError

SOLVERS = [stepid.OrdinaryLeastSquares(), stepid.WeightedLeastSquares()]
Solver = stepid.OrdinaryLeastSquares | stepid.WeightedLeastSquares


def noisy(rng: np.random.Generator, scale: float = 1.0) -> tuple[stepid.Characteristics, ...]:
    """Cases 4 to 7 of a known plant, read with errors of the stated uncertainty."""
    out = []
    for number, mass in enumerate((1.0, 1.5, 2.5, 3.0)):
        clean = run(f"case {4 + number}", mass)
        covariance = [[0.05**2, 0.3 * 0.05 * 0.002], [0.3 * 0.05 * 0.002, 0.002**2]]
        frequency, ratio = rng.multivariate_normal([clean.damped_frequency, clean.damping_ratio], covariance)
        out.append(
            stepid.Characteristics(
                name=clean.name,
                damped_frequency=frequency * scale,
                damping_ratio=ratio,
                uncertainty=stepid.CharacteristicsUncertainty(damped_frequency=0.05 * scale, damping_ratio=0.002),
                correlation=0.3,
                spring="medium",
                damper="1/2 turn",
                added_mass=mass - 1.0,
            )
        )
    return tuple(out)


OFFSETS = (offset("case 4", "case 5", 0.5), offset("case 5", "case 6", 1.0), offset("case 6", "case 7", 0.5))


@pytest.mark.parametrize("solver", SOLVERS)
def test_exact_data_give_the_exact_plant(solver: Solver) -> None:
    clean = [run(f"case {4 + i}", mass) for i, mass in enumerate((1.0, 1.5, 2.5, 3.0))]
    found = stepid.solve(stepid.assemble(clean, OFFSETS), solver=solver)
    np.testing.assert_allclose(list(found.masses.values()), [1.0, 1.5, 2.5, 3.0], rtol=1e-10)
    assert found.stiffness["medium"] == pytest.approx(200.0, rel=1e-10)
    for by_run in (found.damping, found.damping_from_stiffness, found.pooled_damping):
        np.testing.assert_allclose(list(by_run.values()), 14.0, rtol=1e-10)
    assert found.solver == f"{type(solver).__name__}()"


@pytest.mark.parametrize("solver", SOLVERS)
def test_ordinary_solve_is_plain_least_squares(solver: Solver) -> None:
    system = stepid.assemble(noisy(np.random.default_rng(0)), OFFSETS)
    plain = np.linalg.lstsq(system.matrix, system.rhs, rcond=None)[0]
    found = stepid.solve(system, solver=solver)
    values = [*found.masses.values(), *found.stiffness.values()]
    same = np.allclose(values, plain, rtol=1e-10)
    assert same == isinstance(solver, stepid.OrdinaryLeastSquares)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000), st.permutations(range(4)), st.sampled_from([1e-3, 1.0, 60.0]))
def test_weighted_solve_ignores_unit_of_time_and_order(seed: int, order: Sequence[int], unit: float) -> None:
    one = stepid.solve(stepid.assemble(noisy(np.random.default_rng(seed)), OFFSETS))
    runs = noisy(np.random.default_rng(seed), scale=unit)
    two = stepid.solve(stepid.assemble([runs[i] for i in order], tuple(OFFSETS[i] for i in order if i < 3)))
    for name, mass in one.masses.items():
        assert two.masses[name] == pytest.approx(mass, rel=1e-9)
        assert two.uncertainty.masses[name] == pytest.approx(one.uncertainty.masses[name], rel=1e-6)
        assert two.damping[name] == pytest.approx(one.damping[name] * unit, rel=1e-9)
    assert two.stiffness["medium"] == pytest.approx(one.stiffness["medium"] * unit**2, rel=1e-9)
    assert two.misfit == pytest.approx(one.misfit, rel=1e-6)


def test_the_papers_solve_depends_on_the_unit_of_time() -> None:
    solver = stepid.OrdinaryLeastSquares()
    one = stepid.solve(stepid.assemble(noisy(np.random.default_rng(3)), OFFSETS), solver=solver)
    two = stepid.solve(stepid.assemble(noisy(np.random.default_rng(3), scale=1e-3), OFFSETS), solver=solver)
    assert abs(two.masses["case 5"] / one.masses["case 5"] - 1) > 1e-4


def test_weighted_answer_does_not_depend_on_which_differences_are_taken() -> None:
    runs = noisy(np.random.default_rng(1))
    exact = [
        stepid.MassOffset(from_run="case 4", to_run=f"case {5 + i}", difference=d, uncertainty=0.0)
        for i, d in enumerate((0.5, 1.5, 2.0))
    ]
    chain = [o.model_copy(update={"uncertainty": 0.0}) for o in OFFSETS]
    one, two = (stepid.solve(stepid.assemble(runs, offsets)) for offsets in (exact, chain))
    for name, mass in one.masses.items():
        assert two.masses[name] == pytest.approx(mass, rel=1e-9)


@pytest.mark.parametrize("solver", SOLVERS)
def test_exact_differences_hold_exactly(solver: Solver) -> None:
    runs = [*noisy(np.random.default_rng(2)), run("case 1", 1.03)]
    found = stepid.solve(stepid.assemble(runs, [*OFFSETS, offset("case 4", "case 1", 0.0)]), solver=solver)
    assert found.masses["case 1"] == pytest.approx(found.masses["case 4"], rel=1e-12)
    assert found.uncertainty.masses["case 1"] == pytest.approx(found.uncertainty.masses["case 4"], rel=1e-6)


def test_tiny_uncertainty_is_the_limit_of_an_exact_difference() -> None:
    runs = noisy(np.random.default_rng(4))
    exact, tiny = (
        stepid.solve(stepid.assemble(runs, [o.model_copy(update={"uncertainty": u}) for o in OFFSETS]))
        for u in (0.0, 1e-7)
    )
    assert tiny.stiffness["medium"] == pytest.approx(exact.stiffness["medium"], rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("solver", SOLVERS)
def test_covariance_is_that_of_repeats(solver: Solver) -> None:
    rng = np.random.default_rng(7)
    found = []
    for _ in range(150):
        offsets = [o.model_copy(update={"difference": o.difference + 0.005 * rng.standard_normal()}) for o in OFFSETS]
        found.append(stepid.solve(stepid.assemble(noisy(rng), offsets), solver=solver))
    for field in ("masses", "stiffness", "damping", "damping_from_stiffness", "pooled_damping", "base_mass"):
        for key in getattr(found[0], field):
            spread = np.std([getattr(p, field)[key] for p in found])
            told = np.median([getattr(p.uncertainty, field)[key] for p in found])
            assert told == pytest.approx(spread, rel=0.2), (field, key)
    values = np.array([[p.masses["case 4"], p.stiffness["medium"]] for p in found])
    told = np.median([p.correlation("masses[case 4]", "stiffness[medium]") for p in found])
    assert told == pytest.approx(np.corrcoef(values.T)[0, 1], abs=0.05)
    if isinstance(solver, stepid.WeightedLeastSquares):
        assert np.sqrt(np.mean([p.misfit**2 for p in found])) == pytest.approx(1.0, abs=0.12)
    # errors in variables: the weighted solve is unbiased where the ordinary one need not be
    bias = np.mean(values[:, 1] - 200.0) / (np.std(values[:, 1]) / np.sqrt(len(values)))
    assert abs(bias) < 4 or isinstance(solver, stepid.OrdinaryLeastSquares)


def test_weighted_solve_needs_uncertainties() -> None:
    bare = [
        r.model_copy(update={"uncertainty": stepid.CharacteristicsUncertainty()})
        for r in noisy(np.random.default_rng(0))
    ]
    system = stepid.assemble(bare, OFFSETS)
    with pytest.raises(InputError, match=r"'case 4' carry no uncertainty.*OrdinaryLeastSquares"):
        stepid.solve(system)
    assert stepid.solve(system, solver=stepid.OrdinaryLeastSquares()).masses["case 4"] == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize("solver", SOLVERS)
def test_peaks_that_contradict_the_masses(solver: Solver) -> None:
    wrong = [o.model_copy(update={"difference": -o.difference}) for o in OFFSETS]
    with pytest.raises(IdentificationError, match=r"contradict the known mass differences.*check added_mass"):
        stepid.solve(stepid.assemble(noisy(np.random.default_rng(0)), wrong), solver=solver)


def test_a_wrong_weight_shows_in_the_misfit() -> None:
    good = stepid.solve(stepid.assemble(noisy(np.random.default_rng(5)), OFFSETS))
    wrong = (OFFSETS[0].model_copy(update={"difference": 0.8}), *OFFSETS[1:])
    bad = stepid.solve(stepid.assemble(noisy(np.random.default_rng(5)), wrong))
    assert good.misfit < 2 < bad.misfit
    assert "contradict" in bad.summary()
    assert "contradict" not in good.summary()
