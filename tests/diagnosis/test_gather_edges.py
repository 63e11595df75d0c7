"""Evidence that is gathered, at its limits: at one the milder answer holds, and each number is what is meant."""

from __future__ import annotations

import math
from typing import Any

import pytest

from made_up_evidence import FLOOR, FRICTION, all_is_determined, candidate, context, evidence, law_of, losing, with_rest
from stepid.diagnosis import free_law, gather, states, verdict, vetoes
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor, bought_by_freedom, is_white
from stepid.diagnosis.exchangeable import Condition
from stepid.diagnosis.left_out import LeftOut
from stepid.diagnosis.selection.candidate import Candidate

CRITERIA = Criteria()


@pytest.fixture(autouse=True)
def _determined(monkeypatch: pytest.MonkeyPatch) -> None:
    all_is_determined(monkeypatch)


@pytest.mark.parametrize(("beyond", "state"), [(CRITERIA.shape, ""), (CRITERIA.shape + 0.01, "velocity")])
def test_what_is_left_may_follow_a_state_as_much_as_chance_does(
    beyond: float, state: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However little that is of the misfit."""
    monkeypatch.setattr(free_law, "free_laws", lambda *_: (law_of("velocity", 1e-9, beyond=beyond),))
    assert evidence(FRICTION).followed(FRICTION) == state


@pytest.mark.parametrize(("known", "part"), [("gain", 1.0), ("gain", 0.1), ("color", 1.0)])
@pytest.mark.parametrize(
    ("beyond", "parts", "state"),
    [(4.0, 2.0, ""), (9.0, 0.9, ""), (9.0, 1.1, "velocity")],
)
def test_what_runs_that_differ_or_colored_noise_leave_is_not_known_as_well(
    known: str, part: float, beyond: float, parts: float, state: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Laws are rough by a share of what the conditions leave them to explain."""
    parts *= part
    monkeypatch.setattr(LeftOut, "part_of_effects", lambda *_: part)
    monkeypatch.setattr(free_law, "free_laws", lambda *_: (law_of("velocity", parts, beyond=beyond),))
    found = candidate(["coulomb_friction"], deviations=["gain"] if known == "gain" else [])
    e = evidence(found)
    with_rest(e)
    e.context.colored = object() if known == "color" else None
    assert e.followed(found) == state


@pytest.mark.parametrize("noise", [False, True])
@pytest.mark.parametrize(
    ("deviations", "known", "beyond"),
    [
        ([], {}, CRITERIA.shape),
        (["gain"], {}, CRITERIA.white),
        ([], {"colored": object()}, CRITERIA.white),
        ([], {"dithered": False}, CRITERIA.white),
    ],
)
def test_chance_is_known_as_well_as_the_noise_also_of_what_a_lead_leaves(
    deviations: list[str], known: dict[str, object], beyond: float, noise: bool
) -> None:
    """What leaves only such noise has no room for a law's roughness; what leaves a rest has."""
    found = candidate(["coulomb_friction"], deviations=deviations)
    e = evidence(found)
    with_rest(e)
    vars(e.context).update(known)
    chance, rough = free_law.allowed(e.context, CRITERIA, found, noise=noise)
    assert chance == beyond
    assert (rough == 0.0) is (noise and beyond == CRITERIA.shape)


def test_two_effects_or_two_states_are_no_patchwork(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(states, "cancelling", lambda *_: "")
    three = candidate(["cogging", "end_stop", "cubic_stiffness"])
    e = evidence(three)
    for of, found in (
        ([{"position"}] * 3, "position"),
        ([{"position", "velocity"}] * 3, ""),
        ([{"position"}, {"position"}, set()], ""),
    ):
        monkeypatch.setattr(gather, "states_of_all", lambda *_, given=of: tuple(map(frozenset, given)))
        assert e.patchwork(three) == found
    monkeypatch.setattr(gather, "states_of_all", lambda *_: (frozenset({"position"}),) * 2)
    assert e.patchwork(candidate(["cogging", "end_stop"])) == ""
    monkeypatch.setattr(states, "cancelling", lambda *_: "position")
    assert e.patchwork(candidate(["cogging", "end_stop"])) == "position"
    monkeypatch.setattr(gather, "states_of_all", lambda *_: (frozenset({"position"}),))
    assert e.patchwork(candidate(["cogging"])) == ""


@pytest.mark.parametrize("qbic", [0.5, 3.0, 7.0])
def test_weights_are_akaikes(qbic: float) -> None:
    best = FRICTION
    other = losing(best, qbic, ["free_play"])
    e = evidence(best, other)
    assert [w.loss for w in e.weighed[:2]] == pytest.approx([0.0, qbic])
    assert e.weight(best) == pytest.approx(1 / (1 + math.exp(-qbic / 2)))
    assert e.weight(other, best) == pytest.approx(1.0)


def test_a_further_effect_and_a_condition_must_earn_their_price() -> None:
    one, more = FRICTION, CRITERIA.further
    for gain, named in ((more + 1, ("coulomb_friction", "free_play")), (more - 1, ("coulomb_friction",))):
        two = losing(one, -gain, ["coulomb_friction", "free_play"])
        assert evidence(one, two).best.names == named
    for gain, differ in ((more + 1, {"gain"}), (more - 1, set())):
        scattered = losing(one, -gain, ["coulomb_friction"], deviations=["gain"])
        assert evidence(one, scattered).best.deviations == differ


@pytest.mark.parametrize(("times", "told"), [(1.9, True), (2.1, False)])
def test_a_general_law_is_a_rival_where_the_linear_plant_leaves_less_than_twice_the_floor(
    times: float, told: bool
) -> None:
    """Its price alone speaks against it there: what sets it apart is below the noise."""
    general = losing(FRICTION, 7.0, ["asymmetric_friction"])
    assert evidence(FRICTION, general, candidate(times=times)).rivals == ((general,) if told else ())
    far = losing(FRICTION, 11.0, ["asymmetric_friction"])
    assert evidence(FRICTION, far, candidate(times=times)).rivals == ()


def test_a_general_law_is_no_rival_of_a_faint_one_that_is_open_or_beside_runs_that_differ(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is no surer than the law inside; and what is left of the linear plant with runs alike is scatter, too."""
    plain, best = candidate(times=1.9), candidate(["coulomb_friction"], deviations=["gain"])
    assert evidence(best, losing(best, 7.0, ["asymmetric_friction"], deviations=["gain"]), plain).rivals == ()
    for module in (gather, vetoes):
        monkeypatch.setattr(module, "undetermined", lambda *_: ("coulomb_friction.level",))
    monkeypatch.setattr(vetoes, "limited", lambda *_: {})
    monkeypatch.setattr(vetoes, "present", lambda *_: frozenset())
    assert evidence(FRICTION, losing(FRICTION, 7.0, ["asymmetric_friction"]), plain).rivals == ()


@pytest.mark.parametrize(
    ("conditions", "gained", "bought"),
    [
        (["gain"], 20.0, 7.0),
        (["damping"], 20.0, 7.0),
        ([], -40.0, -3.0),  # fewer than the best has: no more than against the best
        (["gain"], -20.0, 27.0),  # stuck above the best
        (None, 0.0, 27.0),  # not fitted
    ],
)
def test_what_conditions_buy_is_not_the_freedom_of_a_general_law(
    conditions: list[str] | None, gained: float, bought: float
) -> None:
    """It is held against the simpler law with the same conditions free, where that was fitted and leaves less."""
    unit = context().floor ** 2

    def beside(names: list[str], deviations: list[str], less: float) -> Candidate:
        found = candidate(names, deviations=deviations)
        found.optimum.cost = FRICTION.optimum.cost - less * unit
        return found

    others = [candidate(["coulomb_friction"], deviations=["gain"]) if conditions == [] else FRICTION]
    general = beside(["asymmetric_friction"], conditions or [], -3.0 if conditions == [] else 27.0)
    alike = [] if conditions is None else [beside(["coulomb_friction"], conditions, gained)]
    found = bought_by_freedom(evidence(FRICTION).context, [*others, general, *alike], others[0], general)
    assert found == pytest.approx(bought)


@pytest.mark.parametrize(("gained", "told"), [(20.0, False), (18.0, True)])
def test_a_general_law_is_a_rival_by_its_freedom(gained: float, told: bool) -> None:
    alike, general = (candidate([name], deviations=["gain"]) for name in ("coulomb_friction", "asymmetric_friction"))
    for found, less in ((alike, gained), (general, 20.0 + CRITERIA.rival - 1)):
        found.optimum.cost = FRICTION.optimum.cost - less * context().floor ** 2
    assert evidence(FRICTION, candidate(times=9.0), general, alike)._rivals(general, 15.0) is told


@pytest.mark.parametrize(("qbic", "near"), [(9.9, True), (10.1, False)])
def test_rivals_are_within_a_tie(qbic: float, near: bool) -> None:
    other = losing(FRICTION, qbic, ["free_play"])
    assert evidence(FRICTION, other).rivals == ((other,) if near else ())


@pytest.mark.parametrize(
    ("qbic", "law", "times", "simpler"),
    [
        (9.9, "", 1.0, True),
        (10.1, "", 1.0, False),  # told apart
        (9.9, "gain", 1.0, False),  # what goes with a condition is no scatter
        (9.9, "", 1.2, False),  # nor is it what leaves a rest
    ],
)
def test_a_linear_plant_whose_runs_differ_is_simpler_than_a_law_in_the_place_of_that(
    qbic: float, law: str, times: float, simpler: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gather, "followed_condition", lambda *_: Condition("gain", "the size", 9.0) if law else None)
    monkeypatch.setattr(gather, "sizes_of_scatter", lambda one: {} if one is FRICTION.optimum else {"gain": 0.02})
    scattered = losing(FRICTION, qbic, (), deviations=["gain"])
    if times > 1:
        scattered = candidate(deviations=["gain"], times=times)
    e = evidence(FRICTION, scattered)
    assert (e.best is scattered) == simpler
    if simpler:
        assert e.rivals == (FRICTION,)
        said = verdict.runs_differ(e)
        assert said is not None
        assert said.verdict == "adequate"
        assert "do not tell that from Coulomb friction and runs that are alike" in " ".join(said.reasons)


@pytest.mark.parametrize(("share", "steady", "found"), [(0.85, 0.4, True), (0.84, 0.9, False), (0.9, 0.39, False)])
def test_a_simpler_effect_is_told_where_it_leads(
    share: float, steady: float, found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However much it leaves: a law that contains it and is open takes that."""
    monkeypatch.setattr(LeftOut, "share", lambda *_: (share, steady))
    monkeypatch.setattr(LeftOut, "judges", lambda *_: True)
    simple = candidate(["coulomb_friction"], times=4.9)
    e = evidence(candidate(["stribeck_friction"]), simple)
    assert e.simpler == ((simple,) if found else ())


@pytest.mark.parametrize(("times", "found"), [(2.2, True), (2.31, False)])
def test_without_runs_that_can_be_left_out_a_simpler_effect_has_to_come_near_the_floor(
    times: float, found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(LeftOut, "share", lambda *_: (0.0, 0.0))
    monkeypatch.setattr(LeftOut, "judges", lambda *_: False)
    simple = candidate(["coulomb_friction"], times=times)
    e = evidence(candidate(["stribeck_friction"]), simple)
    assert e.simpler == ((simple,) if found else ())


def test_the_floor_is_as_wide_as_its_own_uncertainty() -> None:
    """A residual that follows itself from sample to sample is noise by its size alone: 1.05 and 2/√400."""
    slow = 1.0 + 0 * FRICTION.optimum.residual
    for times, there in ((1.149, True), (1.151, False)):
        found = candidate(["coulomb_friction"], times=times, residual=slow)
        assert at_floor(context(), CRITERIA, found) is there
        assert at_floor(context(), Criteria(near=1.5), found) is there
    assert context().floor == FLOOR


@pytest.mark.parametrize(("ratio", "there"), [(1.099, True), (1.101, False)])
def test_a_rest_above_the_floor_is_noise_where_it_is_white(
    ratio: float, there: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within two standard deviations, 2/√400, of the ratio that white noise has."""
    monkeypatch.setattr("stepid.diagnosis.evidence.von_neumann_ratio", lambda *_: (ratio, 400))
    found = candidate(["coulomb_friction"], times=1.3)
    assert at_floor(context(), Criteria(near=1.5), found) is there
    assert is_white(context(), found, 2.0) is there
    assert is_white(context(), found, 3.0)


def test_what_is_better_by_far_has_all_weight() -> None:
    far = candidate(["free_play"], times=1e4)
    e = evidence(FRICTION, far, candidate(times=2e4))
    assert e.weighed[1].loss > 2000  # no number holds the inverse of its weight
    assert e.weight(FRICTION) == 1.0
    assert e.weight(far) == 0.0


def test_colored_noise_is_known_by_its_size_within_near() -> None:
    slow = 1.0 + 0 * FRICTION.optimum.residual
    colored = context()
    colored.colored = object()
    for times, there in ((1.149, True), (1.151, False)):
        found = candidate(["coulomb_friction"], times=times, residual=slow, structure=2 * CRITERIA.white)
        assert at_floor(colored, CRITERIA, found) is there
        assert at_floor(context(), CRITERIA, found) is False  # what follows itself over a block is no white noise


@pytest.mark.parametrize(
    ("colored", "times", "enough"), [(None, 1.04, True), (None, 1.1, False), (1.0, 1.1, True), (1.0, 1.2, False)]
)
def test_beside_colored_noise_a_name_needs_more(colored: Any, times: float, enough: bool) -> None:
    """Its size is known less well: what is taken for noise at the end is no effect at the beginning."""
    e = evidence(FRICTION, candidate(times=times))
    e.context.colored = colored
    assert bool(verdict.linear_is_enough(e)) is enough
