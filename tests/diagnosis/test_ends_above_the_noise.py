"""Searches that had stopped at what is no answer, or at an end above the noise where the same set leaves only noise."""

from __future__ import annotations

import pytest

import stepid
from hidden.sets import one

DAFDAF = "dafdaf5de4c496bf36b76916c82e7bdd359c1e45"


@pytest.mark.slow
@pytest.mark.parametrize("times", [1, 2])
def test_an_end_stop_whose_best_start_leads_astray_is_found_from_the_next(times: int) -> None:
    """With twice the effort a start that lay ahead after three steps had ended at three floors, and no other run on.

    A second mass of any size had left only noise there, and had been the end of the search.
    """
    campaign, _ = one("single-all", 125, DAFDAF)
    found = stepid.diagnose(campaign, effort=stepid.Effort().scaled(times))
    assert (found.verdict, found.effects) == ("named", ("end_stop",))


@pytest.mark.slow
def test_a_pair_that_a_third_effect_of_no_strength_hides_is_run_to_its_end() -> None:
    campaign, truth = one("pairs-all", 27, "s23")
    found = stepid.diagnose(campaign)
    assert (found.verdict, set(found.effects)) == ("named", set(truth["effects"]))


@pytest.mark.slow
def test_a_general_law_that_is_open_is_told_beside_the_simpler_one_that_leads() -> None:
    """Friction with a breakaway that no rest shows: alone it takes 99.99 % of the misfit, and leaves five floors."""
    campaign, _ = one("single-all", 117, DAFDAF)
    found = stepid.diagnose(campaign)
    assert (found.verdict, found.effects) == ("ambiguous", ("coulomb_friction",))
    assert found.alternatives == (("stribeck_friction",),)
