"""Two effects at once: campaigns on which the search was stuck, stopped too early or never ended."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import stepid
from hidden.sets import one

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
from record import find_twins


@pytest.mark.slow
@pytest.mark.parametrize(
    "number",
    [
        pytest.param(41, id="a pair is at the floor, a better one not yet raced"),
        pytest.param(61, id="a pair is at the floor of decimated records, not of all samples"),
        pytest.param(
            63,
            id="a heavy second mass",
            marks=pytest.mark.xfail(
                reason="the pair is fitted to 1.46 floors only, by a second mass of 1 g: its states where a release "
                "begins lead astray; it had been named as the noise was taken for colored"
            ),
        ),
        pytest.param(205, id="a disturbance above the plant, found by its line, its phases by trying"),
        pytest.param(396, id="a lag far shorter than a sample beside a curved spring"),
        pytest.param(450, id="a sine in position in the place of a simple spring law"),
        pytest.param(90, id="Newton does not settle on the way to the other pattern of sticking"),
    ],
)
def test_both_effects_are_named(number: int) -> None:
    campaign, truth = one("pairs", number)
    found = stepid.diagnose(campaign)
    assert found.verdict in ("named", "ambiguous")
    assert set(truth["effects"]) in [set(found.effects), *map(set, found.alternatives)]


@pytest.mark.slow
def test_a_general_friction_law_leads_and_two_simple_ones_are_it() -> None:
    """Readings that rest within a step of the encoder: a power that fits them by 0.05 is as good as the square."""
    campaign, truth = one("pairs", 361)
    found = stepid.diagnose(campaign)
    assert found.verdict in ("named", "ambiguous")
    told = {"effects": list(found.effects), "alternatives": [list(a) for a in found.alternatives]}
    true, sets = set(truth["effects"]), [set(found.effects), *map(set, found.alternatives)]
    assert true in sets or find_twins(campaign, truth, told)


@pytest.mark.slow
def test_a_wrong_pair_as_small_as_the_noise_is_not_the_end() -> None:
    """An end stop beside a periodic disturbance leaves 1.11 floors of one beside a second mass."""
    campaign, truth = one("pairs-all", 55, "devM")
    assert set(truth["effects"]) == {"end_stop", "flexible_coupling"}
    found = stepid.diagnose(campaign)
    assert (found.verdict, set(found.effects)) == ("named", set(truth["effects"]))


@pytest.mark.slow
def test_a_square_wave_is_no_sine_though_that_leaves_only_noise() -> None:
    campaign, truth = one("outside-seen", 12, "devM")
    assert truth["outside"] == "square_wave"
    found = stepid.diagnose(campaign)
    assert (found.verdict, found.effects) == ("unexplained", ())
    assert any("leaves" in reason and "but what is left follows time" in reason for reason in found.reasons)


AFEAC = "afeac22fa9c82222255db5cc18d837f5e655e865"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("which", "number", "salt"),
    [
        pytest.param("triples", 13, "devQ", id="strong friction and damping: the linear plant swings on"),
        pytest.param("pairs-all", 68, AFEAC, id="a cogging force among friction that stops the cart"),
        pytest.param("pairs-all", 91, AFEAC, id="a damping that a lead of friction would ask to be negative"),
        pytest.param("pairs-all", 29, AFEAC, id="a sine near the plant's own frequency"),
    ],
)
def test_what_the_response_of_the_linear_plant_hides_is_named(which: str, number: int, salt: str) -> None:
    campaign, truth = one(which, number, salt)
    found = stepid.diagnose(campaign)
    assert (found.verdict, set(found.effects)) == ("named", set(truth["effects"]))


@pytest.mark.slow
def test_rivals_that_a_round_had_no_room_for_are_asked_in_the_next() -> None:
    """Friction that differs by direction: eight sets with less in them had come first, and no round had come after.

    It leaves 2 of χ² less than friction alike, which is no rival: it had been one while derivatives by the rate jumped.
    """
    campaign, truth = one("triples", 16, "devQ")
    found = stepid.diagnose(campaign)
    assert set(truth["effects"]) in [set(r.effects) for r in found.ranking]
    assert {"periodic_disturbance", "actuator_rate_limit"} < set(found.effects)


@pytest.mark.slow
def test_a_breakaway_below_the_level_sends_no_simpler_law_astray() -> None:
    """The mean of level and breakaway had: its kin ended at 130 times what the true pair leaves."""
    campaign, truth = one("pairs-all", 10, "2090368d5df9cecb29da1ec6a42e9abb69d9495a")
    assert set(truth["effects"]) == {"cogging", "asymmetric_friction"}
    found = stepid.diagnose(campaign)
    assert set(truth["effects"]) in [set(found.effects), *map(set, found.alternatives)]


FA560 = "fa56062e012ceb97357fe9fe57248148fef3cc6e"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("which", "number"),
    [
        pytest.param(
            "triples",
            42,
            id="a rate limit stands for a lag",
            marks=pytest.mark.xfail(
                reason="the race's way hangs on rounding, in which machines differ: on some it ends at the rate limit",
                strict=False,
            ),
        ),
        pytest.param("triples", 49, id="a sine in position for a cubic spring, a lag for a rate limit: one by one"),
        pytest.param("triples", 32, id="the set itself, stopped on its way to the noise"),
        pytest.param("single-all", 170, id="play, found by way of two others in the last round"),
    ],
)
def test_what_stands_for_another_or_for_nothing_is_found_out(which: str, number: int) -> None:
    campaign, truth = one(which, number, FA560)
    found = stepid.diagnose(campaign)
    assert (found.verdict, set(found.effects)) == ("named", set(truth["effects"]))
