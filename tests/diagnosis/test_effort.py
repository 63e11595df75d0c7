"""How hard the search tries: presets, and what scaling changes."""

from __future__ import annotations

import pytest

from stepid import Effort

COUNTS = {"fits", "first", "width", "share", "beam", "rounds", "starts", "keep", "promoted", "polish"}


def test_scaling_changes_counts_and_nothing_else() -> None:
    plain, more = Effort(), Effort().scaled(3)
    for name in Effort.model_fields:
        factor = 3 if name in COUNTS else 1
        assert getattr(more, name) == factor * getattr(plain, name)
    assert plain.scaled(1) == plain


def test_nothing_is_scaled_to_none() -> None:
    least = Effort().scaled(1e-3)
    assert {getattr(least, name) for name in COUNTS} == {1}


def test_presets() -> None:
    quick, plain, thorough = Effort.quick(), Effort(), Effort.thorough()
    assert quick.fits < plain.fits < thorough.fits
    assert quick.effects == plain.effects < thorough.effects
    assert (quick.fits, quick.first, quick.rounds, quick.starts, quick.keep) == (30, 6, 4, 2, 1)
    assert (quick.width, quick.share, quick.beam) == (plain.width, plain.share, plain.beam)


def test_wrong_efforts_are_refused() -> None:
    for wrong in ({"fits": 0}, {"effects": 5}, {"worth": 2.0}, {"no_such": 1}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            Effort(**wrong)


def test_an_effort_goes_to_json_and_back() -> None:
    effort = Effort.thorough()
    assert Effort.model_validate_json(effort.model_dump_json()) == effort
