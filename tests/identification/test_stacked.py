"""The stacked system: what stands where, and what it cannot decide."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from made_up_runs import offset, run
from stepid.errors import InputError, UndeterminedError
from stepid.identification.stacked import frequency_row, undetermined_springs


def test_equation_10_as_corrected() -> None:
    data = stepid.datasets.burchett()
    system = stepid.assemble(data.characteristics, data.mass_offsets)
    assert system.matrix.shape == (7, 5)
    assert system.row_labels[:3] == ("frequency, case 4", "mass, case 4 → case 5", "frequency, case 5")
    assert system.column_labels == ("m[case 4]", "m[case 5]", "m[case 6]", "m[case 7]", "k[medium]")
    np.testing.assert_array_equal(system.rhs, [0, 0.5, 0, 1.0, 0, 0.5, 0])
    np.testing.assert_array_equal(system.matrix[1], [-1, 1, 0, 0, 0])
    first = data.characteristics[0]
    assert system.matrix[0, 0] == (np.pi / 0.23903) ** 2
    assert system.matrix[0, 4] == first.damping_ratio**2 - 1  # the paper prints ω² − 1
    assert np.count_nonzero(system.matrix[0]) == 2


def test_true_masses_and_stiffness_satisfy_the_rows() -> None:
    runs = [run("a", 1.0), run("b", 1.5), run("c", 1.5, spring="stiff", stiffness=450.0)]
    system = stepid.assemble(runs, [offset("a", "b", 0.5), offset("b", "c", 0.0)])
    np.testing.assert_allclose(system.matrix @ [1.0, 1.5, 1.5, 200.0, 450.0], system.rhs, atol=1e-12)
    assert frequency_row(2.0, 0.5) == (4.0, -0.75)


def test_prints_like_the_paper() -> None:
    data = stepid.datasets.burchett()
    system = stepid.assemble(data.characteristics, data.mass_offsets)
    lines = str(system).splitlines()
    assert lines[1].split()[:2] == ["row", "m[case"]
    assert lines[1].endswith("k[medium]  = rhs  unit")
    assert lines[3].split()[:4] == ["frequency,", "case", "4", "172.74"]
    assert lines[3].split()[-1] == "N/m"
    assert lines[4].split()[-2:] == ["0.5", "kg"]
    assert system._repr_html_().count("<tr>") == 8
    assert "\n" not in repr(system)
    assert stepid.StackedSystem.model_validate_json(system.model_dump_json()) == system


def test_wrong_names() -> None:
    runs = [run("a", 1.0), run("b", 1.5)]
    with pytest.raises(InputError, match=r"unknown run 'x'.*The runs are 'a', 'b'"):
        stepid.assemble(runs, [offset("a", "x", 0.5)])
    with pytest.raises(InputError, match=r"'a'.*more than one run"):
        stepid.assemble([runs[0], runs[0]], [offset("a", "b", 0.5)])
    with pytest.raises(InputError, match="'a' to itself"):
        stepid.assemble(runs, [offset("a", "a", 0.5)])


def test_fewer_than_two_runs() -> None:
    for runs in ([], [run("a", 1.0)]):
        with pytest.raises(UndeterminedError, match=r"Add a run with the same spring"):
            stepid.assemble(runs, [])


@pytest.mark.parametrize("solver", [stepid.OrdinaryLeastSquares(), stepid.WeightedLeastSquares()])
def test_undetermined_systems_say_what_to_add(solver: stepid.WeightedLeastSquares) -> None:
    noisy = [run("a", 1.0), run("b", 1.01), run("c", 0.99)]  # equal by their labels, apart by noise
    equal = stepid.assemble(noisy, [offset("a", "b", 0.0), offset("b", "c", 0.0)])
    with pytest.raises(UndeterminedError, match=r"common factor.*Add a run with spring 'medium'"):
        stepid.solve(equal, solver=solver)
    with pytest.raises(UndeterminedError, match=r"common factor"):
        stepid.solve(stepid.assemble(noisy, []), solver=solver)
    alone = run("d", 1.2, spring="stiff", stiffness=450.0, base="other")
    loose = stepid.assemble([run("a", 1.0), run("b", 1.5), alone], [offset("a", "b", 0.5)])
    assert undetermined_springs(loose) == ("stiff",)
    with pytest.raises(UndeterminedError, match=r"spring 'stiff' is not fixed, nor the mass of 'd'.*'stiff'.*'d'"):
        stepid.solve(loose, solver=solver)


def test_two_springs_joined_by_one_difference_only_are_undetermined() -> None:
    runs = [run("a", 1.0), run("b", 1.5, spring="stiff", stiffness=450.0)]
    system = stepid.assemble(runs, [offset("a", "b", 0.5)])
    with pytest.raises(UndeterminedError):
        stepid.solve(system)
    more = [*runs, run("c", 2.0), run("d", 1.0, spring="stiff", stiffness=450.0)]
    found = stepid.solve(stepid.assemble(more, [offset("a", "b", 0.5), offset("b", "c", 0.5), offset("a", "d", 0.0)]))
    assert found.stiffness["stiff"] == pytest.approx(450.0, rel=1e-9)
    assert found.stiffness["medium"] == pytest.approx(200.0, rel=1e-9)
