"""Which rivals are asked: none where nothing can be named, but for what may itself become an answer."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from made_up_evidence import candidate
from made_up_search import PAIR, a_search, node, nothing_imitates, proposed
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.fits import Fits
from stepid.diagnosis.selection.moves import MOVES
from stepid.diagnosis.selection.moves.exchange import Exchange
from stepid.diagnosis.selection.moves.generalize import Generalize
from stepid.diagnosis.selection.search import Search
from stepid.diagnosis.selection.standings import Standings


@pytest.fixture(autouse=True)
def plain_search(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing_imitates(monkeypatch)


def asked(search: Search, *, nearest: bool = False) -> list[tuple[str, int]]:
    base = frozenset(PAIR), frozenset[str]()
    return [(p.move, p.size) for p in search.queue.rivals([base], unforeseen=MOVES.unforeseen if nearest else ())]


@pytest.mark.parametrize("nearest", [False, True])
def test_where_nothing_leads_only_what_may_become_an_answer_is_asked(nearest: bool) -> None:
    """A step tells nothing of a mode."""
    assert asked(a_search(lead=40.0), nearest=nearest) == [("exchange", 2), ("resemble", 2)]


ALL = [("drop", 1), ("exchange", 2), ("generalize", 2), ("resemble", 2)]


@pytest.mark.parametrize("lead", [9.0, 16.0])  # two effects lead where they leave 8.4; twice that is near
def test_beside_a_lead_all_rivals_are_asked_what_needs_less_first(lead: float) -> None:
    assert asked(a_search(lead)) == ALL


@pytest.mark.parametrize("lead", [9.0, 40.0])  # one that leads, one that does not
def test_three_effects_are_asked_only_where_they_may_reach_the_noise(lead: float) -> None:
    found = a_search(lead)
    assert ("exchange", 3) not in asked(found)  # 0.9^8 = 0.43
    found.queue.proposals[-1].left = 0.6 * lead  # 40 × 0.6^8 = 0.7
    assert ("exchange", 3) in asked(found)


def test_larger_sets_take_no_place_where_none_may_be_asked() -> None:
    found = a_search(lead=9.0, effort=Effort(width=1))
    found.queue.proposals[-1].left = found.queue.proposals[-1].rank = 0.5 * 9.0  # three effects, before two
    found.queue.proposals = [p for p in found.queue.proposals if p.move == "exchange"]
    base = frozenset(PAIR), frozenset[str]()
    assert [p.size for p in found.queue.rivals([base])] == [3]
    assert [p.size for p in found.queue.rivals([base], most=2)] == [2]


def test_rivals_on_other_bases_are_not_asked() -> None:
    found = a_search(lead=9.0)
    assert found.queue.rivals([found.standings.root.key], unforeseen=MOVES.unforeseen) == []


def test_sets_that_were_tried_from_a_base_are_not_asked_again_from_there() -> None:
    found = a_search(lead=9.0)
    found.queue.tried = {(p.base, p.key) for p in found.queue.proposals if p.move == "drop"}
    assert asked(found) == ALL[1:]


@pytest.mark.parametrize(
    ("names", "deviations", "complete", "exchanged"),
    [
        (["cogging"], [], True, False),  # every other effect in its place was scored on the linear plant
        (["cogging"], [], False, True),
        (["cogging"], ["gain"], True, True),
        (list(PAIR), [], True, True),
    ],
)
def test_in_the_place_of_one_effect_that_leaves_noise_none_is_asked_that_promises_nothing(
    names: list[str], deviations: list[str], complete: bool, exchanged: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: Any = a_search(lead=9.0)
    best = candidate(names, deviations=deviations)
    found.standings.candidates = {best.key: best}
    monkeypatch.setattr(Standings, "complete", lambda *_: complete)
    assert found.queue.unforeseen() == (MOVES.unforeseen if exchanged else {"regeneralize"})


def fitting_by(fit: Any, found: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A search whose fits are made up, and go no further."""
    found.queue.context = None
    monkeypatch.setattr(found.fits, "attempt", fit)
    monkeypatch.setattr(found.fits, "polish_near", lambda base: found.standings.best)
    monkeypatch.setattr(found.fits, "polish_best", lambda: found.standings.best)
    monkeypatch.setattr("stepid.diagnosis.selection.fits.promote", lambda *_: None)


def test_a_set_of_which_no_fit_is_found_gives_others_their_turn() -> None:
    found: Any = a_search(lead=9.0)
    move = MOVES.together[0].name
    sets = [(name, "sensor_drift") for name in ("cogging", "free_play", "end_stop", "actuator_lag")]
    found.queue.proposals = [proposed(found.standings.root, *names, move=move, left=30.0) for names in sets]
    assert [p.key[0] for p in found.queue.promising()] == [frozenset(names) for names in sets[:3]]  # Effort.share
    first = found.queue.proposals[0]
    found.queue._failed = {(first.base, first.key, move)}
    assert [p.key[0] for p in found.queue.promising()] == [frozenset(names) for names in sets[1:]]


@pytest.mark.parametrize("times", [1.0, 8.0])
def test_what_is_far_from_the_noise_is_fitted_to_all_samples_and_not_kept(
    times: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three effects that leave a rest name nothing, and must not decide what does."""
    found: Any = a_search(lead=9.0)
    three = candidate((*PAIR, "free_play"), times=times)
    monkeypatch.setattr(Fits, "polish", lambda self, node: self.standings.candidates.update({node.key: three}))
    monkeypatch.setattr(Standings, "complete", lambda *_: False)
    known = set(found.standings.candidates)
    assert found.fits.polish_near(node(*PAIR, "free_play", cost=2.0)) is (
        three if times == 1.0 else found.standings.best
    )
    assert set(found.standings.candidates) - known == ({three.key} if times == 1.0 else set())


@pytest.mark.parametrize(("times", "dropped"), [(1.0, True), (8.0, False)])
def test_what_the_answer_does_not_need_is_dropped_before_the_end(
    times: float, dropped: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: Any = a_search(lead=1.0)
    pair, one = candidate(PAIR, times=times), candidate(PAIR[:1], times=times)
    found.standings.candidates = {pair.key: pair}
    found.standings.qbic = lambda optimum: 0.0
    fitted: list[str] = []

    def fit(proposal: Any, keep: int | None = None) -> None:
        fitted.append(proposal.move)
        found.queue.tried.add((proposal.base, proposal.key))
        found.standings.candidates[one.key] = one
        found.standings.nodes[one.key] = node(*PAIR[:1], cost=1.0)

    fitting_by(fit, found, monkeypatch)
    monkeypatch.setattr(found.queue, "expand", lambda *_: False)  # made before, and not fitted then
    assert found._simplify() is dropped
    assert fitted == (["drop"] if dropped else [])


def test_from_what_an_exchange_led_to_the_search_goes_on_but_not_from_other_sets(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found: Any = a_search(lead=40.0)
    best, near = node(*PAIR, "free_play", cost=8.0), node(*PAIR, "sensor_drift", cost=9.0)
    led = node(*PAIR, "end_stop", cost=8.5)
    found.standings.nodes |= {best.key: best, near.key: near}
    one = proposed(best, *PAIR, "end_stop", move="exchange", left=9.0)
    asked: list[Any] = []
    monkeypatch.setattr(Exchange, "propose", lambda self, base, context: asked.append(base) or [one])
    fitting_by(lambda *_: found.standings.nodes.update({led.key: led}), found, monkeypatch)
    monkeypatch.setattr(Generalize, "propose", lambda *_: [])
    found._attempts.exchanges()
    assert asked == [best, led]


def test_exchanges_of_the_best_larger_set_are_fitted_until_one_leaves_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    found: Any = a_search(lead=40.0)
    three = node(*PAIR, "free_play", cost=8.0)
    found.standings.nodes[three.key] = three
    better = proposed(three, *PAIR, "end_stop", move="exchange", left=9.0)
    monkeypatch.setattr(Exchange, "propose", lambda *_: [better, proposed(three, *PAIR, move="exchange", left=1.0)])
    fitted = []

    def fit(proposal: Any, keep: int | None = None) -> None:
        fitted.append(proposal)
        found.standings.nodes[proposal.key] = node(*PAIR, "end_stop", cost=1.0)

    fitting_by(fit, found, monkeypatch)
    general = proposed(three, "cogging", "stribeck_friction", "free_play", move="generalize", left=7.9)
    monkeypatch.setattr(Generalize, "propose", lambda *_: [general])
    found._attempts.exchanges()
    assert fitted == [general, better]
    fitted.clear()
    del found.standings.nodes[better.key]
    monkeypatch.setattr(found.standings, "complete", lambda best: True)
    found._attempts.exchanges()
    assert fitted == []  # the set itself, fitted to all samples, leaves noise


@pytest.mark.parametrize(
    ("names", "complete", "again"),
    [
        (PAIR, False, 2),
        (PAIR, True, 1),
        (("flexible_coupling",), False, 2),
        (("actuator_lag",), False, 1),
        (("cogging",), False, 1),
    ],
)
def test_where_friction_may_stop_the_cart_elsewhere_or_a_mode_be_stronger_a_set_is_fitted_anew(
    names: tuple[str, ...], complete: bool, again: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: Any = a_search(lead=9.0)
    fits = []
    one = node(*names, cost=2.0)
    one.fitted.other_valleys = lambda: True
    monkeypatch.setattr(Standings, "complete", lambda *_: complete)

    def polish(self: Any, node: Any) -> None:
        fits.append(node)
        self.standings.candidates[node.key] = candidate(names)

    monkeypatch.setattr(Fits, "polish", polish)
    found.fits.polish_near(one)
    assert len(fits) == again


@pytest.mark.parametrize("barred", [True, False])
def test_rivals_are_held_against_what_may_be_named(barred: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pair that leaves far less, and cannot be named, is no measure of them."""
    found: Any = a_search(lead=9.0)
    other = node("periodic_disturbance", "cubic_stiffness", cost=2.0)
    found.standings.nodes[other.key] = other
    monkeypatch.setattr(found.standings, "named", lambda nodes: (n for n in nodes if not (barred and n is other)))
    like = next(p for p in found.queue.proposals if p.move == "resemble")  # leaves as much as the pair that it rivals
    assert (like in found.queue._gaining([like])) is barred


@pytest.mark.parametrize(("left", "again"), [(8.5, True), (8.7, False)])
def test_what_a_set_does_without_for_nothing_is_fitted_again_where_it_had_ended_above(left: float, again: bool) -> None:
    """However much less others leave, whose runs differ in more."""
    found: Any = a_search(lead=9.0)
    larger, other = node(*PAIR, "sine_stiffness", cost=8.0), node(*PAIR, "periodic_disturbance", cost=1.0)
    found.standings.nodes |= {larger.key: larger, other.key: other}
    assert found.queue._new(proposed(larger, *PAIR, move="drop", left=left)) is again


def test_a_set_with_a_condition_less_is_not_fitted_again_for_what_no_step_tells() -> None:
    found: Any = a_search(lead=9.0)
    free, other = node(*PAIR, cost=8.0), node(*PAIR, "periodic_disturbance", cost=1.0)
    free.key, free.deviations = (free.key[0], frozenset({"gain"})), frozenset({"gain"})
    found.standings.nodes |= {free.key: free, other.key: other}
    assert not found.queue._new(proposed(free, *PAIR, move="drop", left=free.cost))


@pytest.mark.parametrize(("left", "further"), [(2.0, True), (8.5, False)])
def test_a_set_whose_rival_leaves_far_less_is_run_on_from_where_it_stood(
    left: float, further: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: Any = a_search(lead=9.0)
    ran: list[int] = []
    known = node("sine_stiffness", cost=8.0)
    known.fitted.run = lambda iterations: ran.append(iterations)
    found.standings.nodes[known.key] = known
    proposal = proposed(found.standings.root, "sine_stiffness", move="resemble", left=left)
    stuck = SimpleNamespace(cost=50.0, best=object(), begin=lambda *_, **__: None, run=lambda **_: None)
    monkeypatch.setattr(found.fits, "_told", lambda _: stuck)
    monkeypatch.setattr("stepid.diagnosis.selection.fits.by.starts_in_order", lambda *_: [])
    found.fits.attempt(proposal)
    assert ran == [found.effort.polishing] * further


def test_what_leaves_more_than_with_fewer_conditions_is_fitted_again_once_from_each_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found: Any = a_search(lead=9.0)
    first, second = (proposed(found.standings.root, "cogging", move="deviate", left=2.0) for _ in range(2))
    first.like, second.like = object(), object()
    ends: list[Any] = [first]
    monkeypatch.setattr("stepid.diagnosis.selection.fits.runs.ended_elsewhere", lambda nodes, slack: list(ends))
    fitted: list[Any] = []
    monkeypatch.setattr(found.fits, "attempt", fitted.append)
    found.fits._anew()
    found.fits._anew()
    assert fitted == [first]
    ends.append(second)  # the same set, from where less is left by now
    found.fits._anew()
    assert fitted == [first, second]


@pytest.mark.parametrize(("move", "names", "begun"), [("instead", PAIR, 2), ("exchange", PAIR, 1), ("instead", (), 1)])
def test_an_effect_in_the_place_of_a_condition_is_begun_from_the_best_too(
    move: str, names: tuple[str, ...], begun: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the best is a part of the set by now."""
    found: Any = a_search(lead=9.0)
    found.standings.nodes[frozenset(PAIR), frozenset()].best = object()
    likes: list[Any] = []
    fitted = SimpleNamespace(cost=5.0, best=None, begin=lambda starts, like, **_: likes.append(like), run=lambda **_: 0)
    monkeypatch.setattr(found.fits, "_told", lambda _: fitted)
    monkeypatch.setattr("stepid.diagnosis.selection.fits.by.starts_in_order", lambda *_: [])
    monkeypatch.setattr("stepid.diagnosis.selection.fits.runs.from_the_best", lambda *_: None)
    monkeypatch.setattr(Standings, "best", candidate(PAIR))
    proposal = proposed(found.standings.root, *names, "end_stop", move=move, left=2.0)
    found.fits.attempt(proposal)
    assert likes == [proposal.like, found.standings.nodes[frozenset(PAIR), frozenset()].best][:begun]
