"""What is tried where no set is enough: further effects are fitted beside the best sets, not only scored."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from made_up_search import PAIR, a_search, node, nothing_imitates, proposed

FITTED_IN = 1e5  # steps times states


@pytest.fixture(autouse=True)
def plain_search(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing_imitates(monkeypatch)
    monkeypatch.setattr("stepid.diagnosis.selection.fits.promote", lambda *_: None)


def tried(
    monkeypatch: pytest.MonkeyPatch, *, lead: float, work: float = FITTED_IN, found_beside: float | None = None
) -> tuple[bool, list[set[str]]]:
    """Whether the attempt took enough, and the sets beside which effects were fitted."""
    search: Any = a_search(lead=lead)
    single = node("coulomb_friction", cost=2 * lead)
    search.standings.nodes[single.key] = single
    for one in search.standings.nodes.values():
        one.fitted.work = work
    bases: list[set[str]] = []

    def fit(base: Any) -> None:
        bases.append(set(base.key[0]))
        if found_beside is not None and len(base.effects) == 2:
            three = node(*PAIR, "end_stop", cost=found_beside)
            search.standings.nodes[three.key] = three

    monkeypatch.setattr(search.queue, "expand", lambda *_: True)
    monkeypatch.setattr(search.fits, "beside", fit)
    return search._attempts.beside(), bases


@pytest.mark.parametrize(("cost", "anew"), [(4.4, True), (4.6, False), (9.1, None)])
def test_moves_are_made_anew_from_an_end_that_leaves_less_than_half(cost: float, anew: bool | None) -> None:
    """What was proposed from the other end, and what was tried of that, no longer counts."""
    search: Any = a_search(lead=9.0)
    key = frozenset(PAIR), frozenset[str]()
    pair, other = search.standings.nodes[key], proposed(search.standings.root, *PAIR, move="add", left=1.0)
    pair.moves_made = {"generalize"}
    search.queue.proposals.append(other)
    search.queue.tried = {(p.base, p.key) for p in search.queue.proposals}
    before = len(search.queue.proposals), len(search.queue.tried)
    search.fits._keep(SimpleNamespace(best=object(), cost=cost, effects=pair.effects, deviations=frozenset()), key)
    assert (search.standings.nodes[key] is pair) == (anew is None)
    if anew is not None:
        assert search.standings.nodes[key].moves_made == (set() if anew else {"generalize"})
    left = len(search.queue.proposals), len(search.queue.tried)
    assert left == ((1, 1) if anew else before)
    assert other in search.queue.proposals


def test_effects_are_fitted_beside_the_best_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    assert tried(monkeypatch, lead=9.0) == (False, [set(PAIR)])


def test_all_go_a_few_steps_from_one_start_and_the_best_few_run_on(monkeypatch: pytest.MonkeyPatch) -> None:
    search: Any = a_search(lead=9.0)
    base = search.standings.nodes[frozenset(PAIR), frozenset()]
    costs = {"end_stop": 8.0, "free_play": 7.0, "sensor_drift": 6.0, "input_delay": 5.0, "actuator_lag": 8.5}
    search.queue.proposals = [proposed(base, *PAIR, name, move="add", left=9.0) for name in costs]
    begun: list[dict[str, Any]] = []
    ran: list[tuple[str, int]] = []

    def told(proposal: Any) -> Any:
        (name,) = proposal.key[0] - set(PAIR)
        return SimpleNamespace(
            cost=costs[name],
            best=object(),
            begin=lambda starts, **how: begun.append(how),
            run=lambda iterations: ran.append((name, iterations)),
        )

    monkeypatch.setattr(search.fits, "_told", told)
    monkeypatch.setattr("stepid.diagnosis.selection.fits.Node", lambda fitted, made: fitted)
    for p in search.queue.proposals:
        p.starts, p.deviations = (), frozenset()
    search.fits.beside(base)
    assert len(begun) == 5
    assert all(how["keep"] == 1 and how["iterations"] == search.effort.begin and how["patient"] for how in begun)
    assert ran == [(name, search.effort.polishing) for name in ("input_delay", "sensor_drift", "free_play")]
    assert {key[0] - set(PAIR) for key in search.standings.nodes if len(key[0]) == 3} == {
        frozenset({name}) for name in costs
    }


@pytest.mark.parametrize(("left", "enough"), [(0.5, True), (1.3, True), (4.0, False)])  # noise; most of it; not most
def test_the_search_goes_on_where_one_takes_most_of_what_was_left(
    left: float, enough: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert tried(monkeypatch, lead=9.0, found_beside=left)[0] is enough


def test_what_is_explained_needs_none(monkeypatch: pytest.MonkeyPatch) -> None:
    assert tried(monkeypatch, lead=0.9) == (False, [])


def test_of_long_records_none_is_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    assert tried(monkeypatch, lead=9.0, work=10 * FITTED_IN) == (False, [])
