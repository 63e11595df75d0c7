"""A short length or time reads in mm or ms, the same wherever it is printed."""

from __future__ import annotations

import pytest

from stepid.core.estimate import Estimate, outward, prefixed


@pytest.mark.parametrize(
    ("value", "uncertainty", "unit", "said"),
    [
        (0.000500040, 1.2e-6, "m", "0.5000 ± 0.0012 mm"),
        (-0.03, 0.001, "m", "-30.0 ± 1.0 mm"),
        (0.3, 0.01, "m", "0.300 ± 0.010 m"),
        (0.012, 0.0005, "s", "12.00 ± 0.50 ms"),
        (0.0005, None, "m", "0.5 mm (undetermined)"),
        (0.0005, 1e-6, "m/s", "0.0005000 ± 0.0000010 m/s"),
        (0.0, 0.0, "m", "0 m"),
    ],
)
def test_short_ones_have_a_prefix(value: float, uncertainty: float | None, unit: str, said: str) -> None:
    estimate = Estimate(value=value, uncertainty=uncertainty, unit=unit)
    assert str(estimate) == said
    shown, own = estimate.shown
    assert said == (f"{shown.removesuffix(' (undetermined)')} {own}" + " (undetermined)" * (uncertainty is None))


def test_others_are_left_alone() -> None:
    assert prefixed(0.01, 0.001, "kg") == (0.01, 0.001, "kg")


@pytest.mark.parametrize(
    ("value", "least", "most"), [(0.29, "0.29", "0.29"), (0.2951, "0.29", "0.3"), (57.0, "57", "57")]
)
def test_the_end_of_an_interval_holds_no_less_and_no_more_than_it_has_to(value: float, least: str, most: str) -> None:
    """0.29 times 100 is a little less than 29."""
    assert (outward("at least", value), outward("at most", value)) == (least, most)
