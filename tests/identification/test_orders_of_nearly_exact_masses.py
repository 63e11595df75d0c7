"""Mass differences that are known to a billionth: rounding of a step is no contradiction of the peaks."""

from __future__ import annotations

import pytest

import stepid
from hidden.sets import one

SALT = "a" * 40


@pytest.mark.parametrize("number", [7, 9, 18, 24, 33])
def test_the_order_of_the_runs_does_not_matter(number: int) -> None:
    campaign, _ = one("single-all", number, SALT)
    assert campaign.weight_uncertainty < 1e-8
    found, again = stepid.identify(campaign), stepid.identify(campaign[::-1])
    for name in ("masses", "stiffness", "damping_from_stiffness"):
        assert getattr(again, name) == pytest.approx(getattr(found, name), rel=1e-6)
