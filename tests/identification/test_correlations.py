"""Covariances of what was identified: asked for by name, and consistent with what they are of."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from made_up_runs import offset, run
from stepid.errors import InputError

MADE = (run("case 1", 1.0), run("case 2", 1.5), run("case 3", 2.1, base="cart and damper"))
RUNS = tuple(
    made.model_copy(update={"added_mass": kg, "damper": "plug"}) for made, kg in zip(MADE, (0.0, 0.5, 1.0), strict=True)
)
OFFSETS = (offset("case 1", "case 2", 0.5), offset("case 2", "case 3", 0.6))


@pytest.fixture(scope="module")
def found() -> stepid.IdentifiedParameters:
    return stepid.solve(stepid.assemble(RUNS, OFFSETS))


def test_correlation_is_that_of_the_covariance(found: stepid.IdentifiedParameters) -> None:
    labels = list(found.covariance_labels)
    i, j = labels.index("masses[case 1]"), labels.index("stiffness[medium]")
    c = found.covariance
    told = found.correlation("masses[case 1]", "stiffness[medium]")
    assert told == pytest.approx(c[i, j] / np.sqrt(c[i, i] * c[j, j]))
    assert 0.5 < told < 1  # a stiffer spring needs more mass for the same frequency
    assert found.correlation("masses[case 1]", "masses[case 1]") == 1.0
    assert found.correlation("stiffness[medium]", "masses[case 1]") == told


def test_a_value_that_is_certain_correlates_with_nothing(found: stepid.IdentifiedParameters) -> None:
    certain = found.covariance.copy()
    i = found.covariance_labels.index("stiffness[medium]")
    certain[i] = certain[:, i] = 0.0
    other = found.model_copy(update={"covariance": certain})
    assert other.correlation("masses[case 1]", "stiffness[medium]") == 0.0


@pytest.mark.parametrize("names", [("masses[case 9]", "stiffness[medium]"), ("stiffness[medium]", 3)])
def test_unknown_names_are_told(found: stepid.IdentifiedParameters, names: tuple[str, str]) -> None:
    with pytest.raises(InputError, match=r"no covariance of .*There are: masses\[case 1\], "):
        found.correlation(*names)
    bare = found.model_copy(update={"covariance": None})
    with pytest.raises(InputError, match="no covariance"):
        bare.correlation("masses[case 1]", "stiffness[medium]")


def test_differences_of_bases_without_covariance_have_no_uncertainty(found: stepid.IdentifiedParameters) -> None:
    bases = ("cart", "cart and damper")
    bare = found.model_copy(update={"covariance": None})
    assert bare.base_difference(*bases).uncertainty is None
    more = found.base_difference(*bases)
    assert more.value == pytest.approx(bare.base_difference(*bases).value)
    assert more.value == pytest.approx(0.1, abs=1e-6)
    assert more.uncertainty > 0
    with pytest.raises(InputError, match="no base mass for base 'boat'"):
        found.base_difference("cart", "boat")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"springs": {}}, "which is not among the stiffnesses"),
        ({"damping": {}}, "has a mass but no damping"),
        ({"covariance": np.eye(2)}, "covariance and covariance_labels differ in size"),
    ],
)
def test_what_does_not_belong_together_is_refused(
    found: stepid.IdentifiedParameters, change: dict[str, object], said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        stepid.IdentifiedParameters(**found.model_dump() | {"uncertainty": found.uncertainty} | change)


def test_runs_and_trends_are_told_in_a_line() -> None:
    seen = [one.model_copy(update={"peak_time": np.pi / one.damped_frequency}) for one in RUNS[:2]]
    (trend,) = stepid.find_trends(seen).trends
    assert repr(trend) == "Trend('mass', 2 runs)"
    assert repr(stepid.find_trends(seen)) == "Trends(mass)"
    assert trend.change("overshoot") == "unknown"  # of runs without
    assert trend._repr_html_() in stepid.find_trends(seen)._repr_html_()
    assert repr(RUNS[0]).startswith("Characteristics('case 1', damped_frequency=12.")
    assert "damping_ratio=0.49" in repr(RUNS[0])
