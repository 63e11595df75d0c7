"""Which of what a search has found leads, and what it looks for rivals of."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from made_up_evidence import candidate, context, losing
from stepid import Criteria, Effort
from stepid.diagnosis.free_law import FreeLaw
from stepid.diagnosis.selection.candidate import LINEAR
from stepid.diagnosis.selection.standings import Standings

PAIR = candidate(["coulomb_friction", "cogging"], times=8.0)
THREE = ["coulomb_friction", "cogging", "free_play"]


@pytest.fixture(autouse=True)
def no_imitators(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stepid.diagnosis.selection.standings.imitators", lambda *_: {})
    monkeypatch.setattr("stepid.diagnosis.selection.standings.barred", lambda *_: False)
    monkeypatch.setattr("stepid.diagnosis.selection.standings.repeatability", lambda _: None)


@pytest.mark.parametrize(
    ("times", "both"),
    [(2.0, True), (6.0, False), (8.0, False)],  # takes 94 %, 44 % and nothing of the power that the pair leaves
)
def test_a_larger_set_on_its_way_to_the_noise_has_its_rivals_looked_for(times: float, both: bool) -> None:
    larger = candidate(THREE, times=times)
    found = Standings(context(), Criteria(), Effort())
    found.candidates = {c.key: c for c in (candidate(times=30.0), PAIR, larger)}
    assert found.leading() == ([PAIR, larger] if both else [PAIR])


def test_how_much_a_larger_set_has_to_take_is_the_criterion_of_a_lead() -> None:
    larger = candidate(THREE, times=6.0)
    found = Standings(context(), Criteria(lead=0.4), Effort())
    found.candidates = {c.key: c for c in (candidate(times=30.0), PAIR, larger)}
    assert found.leading() == [PAIR, larger]


def test_a_pair_that_leaves_least_is_the_only_one_looked_at() -> None:
    found = Standings(context(), Criteria(), Effort())
    found.candidates = {c.key: c for c in (candidate(times=30.0), candidate(["cogging"], times=20.0), PAIR)}
    assert found.best is PAIR
    assert found.leading() == [PAIR]


def test_a_larger_set_that_needs_runs_to_differ_is_not_on_its_way() -> None:
    larger = candidate(THREE, times=2.0, deviations=["gain"])
    found = Standings(context(), Criteria(), Effort())
    found.candidates = {c.key: c for c in (candidate(times=30.0), PAIR, larger)}
    assert found.best is larger
    assert found.leading() == [PAIR]


@pytest.mark.parametrize(("qbic", "answered"), [(9.0, True), (17.0, False)])
def test_rivals_are_looked_for_of_what_is_answered_too(qbic: float, answered: bool) -> None:
    """A further effect earns less than it must: it is the best, and no answer."""
    best = candidate(["coulomb_friction", "cogging"])
    simple = losing(best, qbic, ["coulomb_friction"])
    found = Standings(context(), Criteria(), Effort())
    found.candidates = {c.key: c for c in (candidate(times=30.0), best, simple)}
    assert found.best is best
    assert found.leading() == ([best, simple] if answered else [best])


@pytest.mark.parametrize("is_open", [True, False])
def test_what_leaves_only_noise_and_is_open_ends_no_search(is_open: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is no answer; another that leaves only noise has its rivals looked for, too."""
    best, other = candidate(["flexible_coupling"]), candidate(["end_stop"], times=1.01)
    barred = "stepid.diagnosis.selection.standings.barred"
    monkeypatch.setattr(barred, lambda fit, criteria, found: is_open and found is best)
    monkeypatch.setattr(Standings, "followed", lambda *_: None)
    found = Standings(context(), Criteria(), Effort())
    found.candidates = {c.key: c for c in (candidate(times=30.0), best, other)}
    assert found.best is best
    assert found.complete(best) is not is_open
    assert found.one_is_enough() is not is_open
    assert found.leading() == ([best, other] if is_open else [best])


def test_what_is_open_and_simpler_takes_no_place_from_what_can_be_named(monkeypatch: pytest.MonkeyPatch) -> None:
    best = candidate(["flexible_coupling", "cogging"])
    simple, other = losing(best, 9.0, ["flexible_coupling"]), candidate(["end_stop"], times=1.05)
    barred = "stepid.diagnosis.selection.standings.barred"
    monkeypatch.setattr(barred, lambda fit, criteria, found: "flexible_coupling" in found.names)
    found = Standings(context(), Criteria(), Effort())
    found.candidates = {c.key: c for c in (candidate(times=30.0), best, simple, other)}
    assert found.simplest() is simple
    assert found.leading() == [best, other]


def costing(cost: float, *, polished: bool = True) -> Any:
    return SimpleNamespace(cost=cost, fitted=SimpleNamespace(polished=object() if polished else None))


@pytest.mark.parametrize(("beyond", "lowered"), [(9.0, True), (3.0, False)])
def test_below_a_wrong_law_as_small_as_the_noise_the_search_goes_on(
    beyond: float, lowered: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By as much as a law of any shape takes of what it leaves."""
    best = candidate(["cogging"])
    law = FreeLaw("position", 0.1, 0.3 * best.optimum.cost, beyond)
    monkeypatch.setattr("stepid.diagnosis.free_law.free_laws", lambda *_: (law,))
    found = Standings(context(), Criteria(), Effort())
    found.candidates = {c.key: c for c in (candidate(times=30.0), best)}
    found.nodes = {key: costing(c) for key, c in ((LINEAR, 9e-5), (best.key, best.optimum.cost))}
    before = found.noise_limit
    assert found.complete(best) is not lowered
    found.lower_floor(best)
    assert found.noise_limit == pytest.approx(0.7 * best.optimum.cost if lowered else before)


@pytest.mark.parametrize(
    ("times", "structure", "complete", "lowered"),
    [(1.12, 9.0, False, True), (1.02, 0.0, True, False), (1.1502, 9.0, False, False), (1.5, 9.0, False, False)],
)
def test_below_what_costs_as_little_as_noise_and_is_not_white_the_search_goes_on(
    times: float, structure: float, complete: bool, lowered: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By what a tie does not tell from it; one that leaves more than noise may lowers no floor."""
    best = candidate(["cogging"], times=times, structure=structure)
    monkeypatch.setattr("stepid.diagnosis.free_law.free_laws", lambda *_: (FreeLaw("position", 0.0, 0.0, 0.0),))
    found = Standings(context(), Criteria(), Effort())
    found.noise_limit = 1.15**2 * found.fit.full_noise_cost
    found.candidates = {c.key: c for c in (candidate(times=30.0), best)}
    found.nodes = {key: costing(c) for key, c in ((LINEAR, 9e-5), (best.key, best.optimum.cost))}
    before = found.noise_limit
    found.lower_floor(best)
    assert found.noise_limit == pytest.approx(best.optimum.cost - 10.0 * found.fit.unit if lowered else before)
    assert found.complete(best) is complete


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize(
    ("freer", "now", "asked"),
    [
        ({"structure": 9.0}, True, "freer"),
        ({"structure": 9.0}, False, "best"),  # of another end: it ran on since
        ({"structure": 0.0}, True, "best"),  # that leaves only noise
    ],
)
def test_what_has_more_in_it_and_costs_less_is_no_noise_either_unless_it_is_white(
    freer: dict[str, float], now: bool, asked: str, backwards: bool
) -> None:
    """With conditions free a law leaves a little less of the same rest; the order of candidates tells nothing."""
    best = candidate(["cogging"], times=1.12, structure=9.0)
    some = {
        "best": best,
        "near": candidate(["free_play"], times=1.085, structure=9.0) if asked == "freer" else best,  # within a tie
        "freer": candidate(["cogging"], times=1.08, deviations=["gain"], **freer),
    }
    found = Standings(context(), Criteria(), Effort())
    found.noise_limit = 1.15**2 * found.fit.full_noise_cost
    root = candidate(times=1.0, structure=9.0)
    order = [root, *(reversed(some.values()) if backwards else some.values())]
    found.candidates = {c.key: c for c in order}
    found.nodes = {c.key: costing(c.optimum.cost, polished=now or c is best) for c in order}
    found.lower_floor(best)
    assert found.noise_limit == pytest.approx(some[asked].optimum.cost - 10.0 * found.fit.unit)


@pytest.mark.parametrize(("plain", "part"), [(0.5, 0.5), (0.0, 0.0), (None, 1.0), (1.5, 1.0)])
def test_the_search_knows_what_conditions_leave_to_explain(
    plain: float | None, part: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the verdict does; where the linear plant was not fitted with them it is all."""
    best, found = candidate(["cogging"], deviations=["gain"]), Standings(context(), Criteria(), Effort())
    noise = found.fit.noise_cost
    costs = {LINEAR: 10 * noise} | ({} if plain is None else {(frozenset(), best.deviations): (1 + 9 * plain) * noise})
    found.nodes = {key: SimpleNamespace(cost=cost) for key, cost in costs.items()}  # type: ignore[misc]
    monkeypatch.setattr("stepid.diagnosis.selection.standings.followed", lambda *given: given[-1])
    assert found.followed(best) == pytest.approx(part)


def raced(names: list[str], cost: float, deviations: tuple[str, ...] = ()) -> SimpleNamespace:
    found = candidate(names, deviations=deviations)
    return SimpleNamespace(effects=found.effects, deviations=found.deviations, key=found.key, cost=cost)


@pytest.mark.parametrize(
    ("names", "deviations", "alone", "needed"),
    [
        (["cogging"], (), 90.0, 1 + 0.2 * 100),
        ([], (), 90.0, 1.0),  # no effect is an answer where only noise is left
        ([], ("gain",), 90.0, 1.0),
        (["cogging"], ("gain",), 90.0, 1 + 0.2 * 50),  # of what the plant with the same condition leaves
        (["cogging"], ("damping",), 90.0, 1 + 0.2 * 100),  # not fitted: of what the plant leaves
        (["cogging", "free_play"], (), 90.0, 1 + 0.1 * 100),  # a second effect halves what may be left
        (["cogging", "free_play"], (), 11.0, 1 + 0.2 * 10),  # one of them leads: the other has to lead beside it
        (["coulomb_friction", "free_play"], (), 11.0, 1 + 0.1 * 100),  # none of these does
        (THREE, (), 11.0, 1.0),  # so many are an answer at the noise only
    ],
)
def test_what_a_set_may_leave_to_be_an_answer(
    names: list[str], deviations: tuple[str, ...], alone: float, needed: float
) -> None:
    found = Standings(context(), Criteria(lead=0.8), Effort())
    found.noise_limit = 1.0
    nodes = [raced([], 101.0), raced([], 51.0, ("gain",)), raced(["cogging"], alone), raced(["free_play"], 70.0)]
    found.nodes = {node.key: node for node in nodes}  # type: ignore[misc]
    wanted = candidate(names, deviations=deviations)
    assert found.needed(wanted.effects, wanted.deviations) == pytest.approx(needed)


def test_a_law_inside_one_of_a_pair_leads_too() -> None:
    found = Standings(context(), Criteria(lead=0.8), Effort())
    found.noise_limit = 1.0
    nodes = [raced([], 101.0), raced(["coulomb_friction"], 11.0)]
    found.nodes = {node.key: node for node in nodes}  # type: ignore[misc]
    pair = candidate(["stribeck_friction", "free_play"])
    assert found.needed(pair.effects, pair.deviations) == pytest.approx(1 + 0.2 * 10)


@pytest.mark.parametrize(
    ("cost", "times", "answered"),
    [(40.0, 8.0, True), (44.0, 8.0, False), (44.0, 1.0, True)],  # twice 21; on all samples only noise may be left
)
def test_the_leading_set_is_an_answer_or_misses_that_by_a_factor_of_two(
    cost: float, times: float, answered: bool
) -> None:
    one = candidate(["cogging"], times=times)
    found = Standings(context(), Criteria(lead=0.8), Effort())
    found.noise_limit = 1.0
    found.nodes = {node.key: node for node in (raced([], 101.0), raced(["cogging"], cost))}  # type: ignore[misc]
    found.candidates = {c.key: c for c in (candidate(times=30.0), one)}
    assert found.answered() is answered


def test_what_repeated_runs_differ_by_no_set_has_to_take() -> None:
    found = Standings(context(), Criteria(lead=0.8), Effort())
    found.noise_limit, found._spread = 1.0, 3.0 * context().floor
    found.nodes = {node.key: node for node in (raced([], 101.0), raced(["cogging"], 20.0))}  # type: ignore[misc]
    cogging = candidate(["cogging"])
    assert found.needed(cogging.effects, frozenset()) == pytest.approx(9 + 0.2 * 92)
    found._spread = 0.5 * context().floor
    assert found.needed(cogging.effects, frozenset()) == pytest.approx(21)


def test_what_would_be_answered_pays_for_each_effect_and_condition() -> None:
    """Two conditions more must earn twice `Criteria.further`, as where the answer is chosen."""
    one = candidate(["cogging"])
    free = candidate(["cogging"], deviations=["gain", "start_time"])
    found = Standings(context(), Criteria(), Effort())
    found.candidates = {c.key: c for c in (one, free)}
    losses = {id(one.optimum): 30.0, id(free.optimum): 0.0}
    found.qbic = lambda optimum: losses[id(optimum)]  # type: ignore[method-assign]
    assert (found.best, found.simplest()) == (free, one)
    losses[id(one.optimum)] = 34.0
    assert found.simplest() is free
