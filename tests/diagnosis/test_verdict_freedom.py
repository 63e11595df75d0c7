"""Rules on freedoms that the runs of a plant have: of effects in every run, of conditions, of what noise is."""

from __future__ import annotations

from typing import Any

import pytest

from made_up_evidence import LINEAR, Told, ask, candidate
from stepid.diagnosis.exchangeable import Condition
from stepid.diagnosis.selection.candidate import Candidate

FITTED = candidate(["free_play"], times=1.4)


def test_a_freedom_beside_effects_that_predict_has_to_take_half_of_what_they_leave() -> None:
    both = candidate(["coulomb_friction", "periodic_disturbance"])
    told: dict[str, Any] = {"best": both, "floored": both.names, "lead": both}
    assert ask("freedom_is_untested", **told, taken_by_free=0.6) is None
    found = ask("freedom_is_untested", **told, taken_by_free=0.4)
    assert found is not None
    assert (found.verdict, found.shown) == ("unexplained", both)
    assert "takes 40 % of what its other effects leave" in found.reasons[0]


@pytest.mark.parametrize(
    ("names", "verdict", "rule"),
    [([], "adequate", "runs_differ"), (["coulomb_friction"], "named", "complete"), (["free_play"], "unexplained", "")],
)
def test_what_is_as_good_without_a_freedom_is_the_answer_if_it_is_a_part(
    names: list[str], verdict: str, rule: str
) -> None:
    """Starts that the effect had freed do it alone, or beside the other effect."""
    both = candidate(["coulomb_friction", "periodic_disturbance"])
    rest = candidate(names, deviations=["start_offset"])
    without = Told(best=rest, floored=("coulomb_friction", "free_play"))
    found = ask("freedom_is_untested", best=both, floored=both.names, lead=both, taken_by_free=0.1, without=without)
    assert found is not None
    assert (found.verdict, found.rule) == (verdict, rule)
    assert found.shown is (rest if rule else both)


@pytest.mark.parametrize(
    ("found", "told", "enough"),
    [
        (candidate(deviations=["gain"], times=1.5), {}, True),
        (candidate(times=1.5), {}, True),
        (candidate(deviations=["gain"], times=2.1), {}, False),  # too much for noise
        (candidate(deviations=["gain"], times=1.5), {"noisy": False}, False),
        (candidate(deviations=["gain"], times=1.5), {"goes_with": Condition("gain", "the size", 9.0)}, False),
        (candidate(deviations=["gain"], times=1.5), {"best": FITTED, "share_taken": (0.4, 0.9)}, True),
        (candidate(deviations=["gain"], times=1.5), {"best": FITTED, "share_taken": (0.5, 0.9)}, False),  # predicted
        (
            candidate(deviations=["gain"], times=1.5),
            {"best": FITTED, "share_taken": (0, 0), "judged": False},
            False,
        ),
    ],
)
def test_a_rest_that_follows_nothing_is_noise(found: Candidate, told: dict[str, Any], enough: bool) -> None:
    linear = LINEAR if found.deviations else found
    answer = ask("rest_follows_nothing", **({"best": found, "lead": LINEAR, "plain": found, "linear": linear} | told))
    assert (answer is not None) is enough
    if answer is not None:
        assert (answer.verdict, answer.shown) == ("adequate", found)
        assert ("The runs differ in gain" in answer.reasons[0]) == bool(found.deviations)
        assert "1.5 times the noise floor" in answer.reasons[-1]
