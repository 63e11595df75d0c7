"""Which sets are fitted to all samples: those that lead the race, and those near the best by the samples that count."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from made_up_evidence import FLOOR, RUNS, SAMPLES, candidate, losing
from made_up_search import a_search, node, nothing_imitates, proposed
from stepid import Effort
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.selection.fits import Fits
from stepid.diagnosis.selection.promote import promote
from stepid.diagnosis.selection.standings import Standings

SWINGS = np.sin(0.3 * np.arange(RUNS * SAMPLES))
NOISE = RUNS * SAMPLES * FLOOR**2


@pytest.fixture(autouse=True)
def plain_search(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing_imitates(monkeypatch)


def raced(found: Candidate) -> Any:
    fitted = SimpleNamespace(polished=None, other_valleys=lambda: False)
    own = {"effects": found.effects, "deviations": found.deviations, "key": found.key, "best": found.optimum}
    return SimpleNamespace(**own, size=len(found.effects), cost=found.optimum.cost, fitted=fitted)


def a_race(*found: Candidate, effort: Effort | None = None) -> Any:
    """A search that has fitted some sets beside a linear plant, which swings: of its rest few samples count."""
    search = a_search(lead=9.0, effort=effort, unit=FLOOR**2, noise_cost=NOISE)
    plain = candidate(times=30.0, residual=SWINGS)
    search.standings.candidates, search.standings.noise_limit = {plain.key: plain}, 1.1 * NOISE
    search.standings.nodes = {c.key: raced(c) for c in (plain, *found)}
    return search


def fitted_in(search: Any, monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """Names of the sets that are fitted to all samples, in their order."""
    order: list[tuple[str, ...]] = []

    def polish(_: Any, one: Any) -> None:
        order.append(tuple(e.name for e in one.effects))
        search.standings.candidates[one.key] = Candidate(one.effects, one.deviations, one.best, 0.0)

    monkeypatch.setattr(Fits, "polish", polish)
    assert search.fits.polish_best() is search.standings.best
    return order


@pytest.mark.parametrize(
    ("times", "qbic", "spread", "near"),
    [
        (10.0, 9.0, 0.02, True),  # less than a tie
        (10.0, 12.0, 0.02, False),
        (10.0, 30.0, 0.1, True),  # a tenth of the cost is 38
        (1.0, 40.0, 0.02, True),  # six ties of χ² are 56
        (1.0, 70.0, 0.02, False),
    ],
)
def test_how_near_others_are_is_told_by_what_the_best_leaves(
    times: float, qbic: float, spread: float, near: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the few samples that count of what the linear plant leaves all would be near."""
    best = candidate(["free_play"], times=times)
    other = losing(best, qbic, ["end_stop"])
    search = a_race(other, best, effort=Effort(spread=spread))
    assert fitted_in(search, monkeypatch) == [best.names, *([other.names] if near else [])]


@pytest.mark.parametrize(("stuck", "fitted"), [(6.0, True), (2.0, False)])
def test_what_leaves_least_is_fitted_if_it_may_win(stuck: float, fitted: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """The samples that count are those of its rest; its parameters cost 30 more, so many ties are 60 or 20."""
    best = candidate(["cogging"], times=10.0)
    most = candidate(["free_play"], times=9.999, deviations=["damping", "gain", "start_time"])
    search = a_race(best, most, effort=Effort(stuck=stuck))
    assert search.standings.foreseen(search.standings.nodes[most.key]) > search.standings.foreseen(
        search.standings.nodes[best.key]
    )
    assert fitted_in(search, monkeypatch) == [best.names, *([most.names] if fitted else [])]


def test_the_first_that_may_be_named_is_fitted_however_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    best = candidate(["free_play"], times=10.0)
    search = a_race(best, losing(best, 99.0, ["end_stop"]))
    assert fitted_in(search, monkeypatch) == [("free_play",)]
    barred = "stepid.diagnosis.selection.order.imitators"
    monkeypatch.setattr(barred, lambda fit, criteria, c: {"damping": 1.0} if c.names != ("end_stop",) else {})
    search = a_race(best, losing(best, 99.0, ["end_stop"]))
    assert fitted_in(search, monkeypatch) == [("free_play",), ("end_stop",)]
    assert fitted_in(search, monkeypatch) == []  # one that is far is not fitted again and again


@pytest.mark.parametrize(("answers", "fitted"), [(True, True), (False, False)])
def test_a_pair_that_is_near_is_fitted_if_it_may_be_an_answer(
    answers: bool, fitted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    best = candidate(["end_stop"], times=4.0)
    pair = losing(best, 5.0, ["free_play", "actuator_lag"])  # as many parameters
    monkeypatch.setattr(Standings, "answers", lambda *_: answers)
    assert fitted_in(a_race(best, pair), monkeypatch) == [best.names, *([pair.names] if fitted else [])]


def test_three_effects_that_leave_a_rest_are_not_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    best = candidate(["cogging"], times=4.0)
    three = candidate(["free_play", "end_stop", "actuator_lag"], times=3.0)
    assert fitted_in(a_race(best, three), monkeypatch) == [best.names]


def test_a_cost_in_the_race_stands_for_that_in_all_samples() -> None:
    """Every tenth sample: noise counts a tenth, a misfit ten times; what rounding leaves at least is of all samples."""
    best = candidate(["free_play"], times=2.0)
    search = a_race(best)
    search.standings.candidates[best.key] = best
    in_all = search.standings.qbic(best.optimum)
    search.fit.unit, search.fit.noise_cost, search.fit.rounding_cost = FLOOR**2 / 10, NOISE / 10, NOISE / 2
    tenth = raced(best)
    tenth.cost = best.optimum.cost / 10
    assert search.standings.foreseen(tenth) == pytest.approx(in_all)
    assert search.standings.foreseen(tenth, tenth.cost) == pytest.approx(in_all + RUNS * SAMPLES * np.log(2), rel=1e-3)


def beside(name: str, cost: float, *conditions: str, already: tuple[str, ...] = (), left: float) -> tuple[Any, Any]:
    """An effect in the race, and what is proposed beside it."""
    base = node(name, cost=cost)
    base.deviations = frozenset(already)
    base.key = base.key[0], base.deviations
    more = proposed(base, name, move="deviate", left=left)
    more.deviations, more.size = base.deviations.union(conditions), 2
    more.key = more.key[0], more.deviations
    return base, more


def test_one_condition_beside_an_effect_is_asked_out_of_its_turn() -> None:
    """Smaller sets go first, but for the one that promises most; all conditions together promise to leave nothing."""
    found: Any = a_search(lead=9.0)
    alone = [proposed(found.standings.root, name, move="add", left=50.0) for name in ("free_play", "end_stop")]
    lag, most = beside("actuator_lag", 55.0, "damping", already=("gain",), left=2.0)
    cogging, next_one = beside("cogging", 60.0, "gain", left=3.0)
    drift, every = beside("sensor_drift", 70.0, "gain", "damping", left=0.0)
    found.standings.nodes |= {base.key: base for base in (lag, cogging, drift)}
    for larger, asked in (([every], []), ([next_one, every], [next_one]), ([next_one, most, every], [most])):
        found.queue.proposals = [*alone, *larger]
        assert found.queue.promising() == [*alone, *asked]


@pytest.mark.parametrize(
    ("left", "of_the_best", "asked"),
    [
        (50.0, True, True),  # more than what is known: so far a step tells nothing
        (50.0, False, False),
        (35.0, True, False),  # the set may be at its end
        (10.0, False, True),  # it had ended elsewhere
    ],
)
def test_what_the_best_may_not_need_is_dropped_though_a_step_promises_nothing(
    left: float, of_the_best: bool, asked: bool
) -> None:
    found: Any = a_search(lead=9.0)
    alone, pair = (
        node("coulomb_friction", cost=40.0),
        next(n for n in found.standings.nodes.values() if len(n.effects) > 1),
    )
    found.standings.nodes[alone.key] = alone
    if not of_the_best:
        found.standings.candidates = {c.key: c for c in (candidate(times=30.0), candidate(["end_stop"], times=2.0))}
    assert found.queue._new(proposed(pair, "coulomb_friction", move="drop", left=left)) is asked


@pytest.mark.parametrize(("known", "times", "named"), [(True, 1.0, False), (True, 4.0, True), (False, 1.0, True)])
def test_what_leaves_only_noise_on_all_samples_and_is_open_is_not_named(
    known: bool, times: float, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside a rest what is open may explain some of it."""
    found = candidate(["cogging"], times=times)
    search = a_race(found)
    search.standings.nodes[found.key].fitted.polished = found.optimum if known else None
    monkeypatch.setattr("stepid.diagnosis.selection.order.barred", lambda *_: True)
    search.standings.candidates = {found.key: found}
    assert [n.key for n in search.standings.named(search.standings.nodes.values())].count(found.key) == named


def test_who_runs_on_in_the_race_is_told_by_qbic_too() -> None:
    """Sets in which the runs differ in everything leave least, and would take every place."""
    went: list[str] = []
    others_too = []

    def racing(name: str, cost: float) -> Any:
        def run(*, iterations: int, tolerance: float, others: bool) -> None:
            went.append(name)
            others_too.append(others)

        fitted = SimpleNamespace(excess=cost, run=run)
        effects = ("cogging",) if name.startswith("differs") else ("cogging", "free_play")
        return SimpleNamespace(name=name, cost=cost, size=2, fitted=fitted, effects=effects)

    nodes = [*(racing(f"differs in everything {i}", 1.0 + 0.1 * i) for i in range(5)), racing("gain", 9.0)]
    nodes += [racing("named", 30.0), racing("named, too", 31.0)]
    fit: Any = SimpleNamespace(unit=0.001)

    def named(some: Any) -> Any:
        return (n for n in some if n.name.startswith("named"))

    promote(nodes, fit, 10.0, Effort(promoted=1), lambda n: n.cost + 20.0 * n.name.startswith("differs"), named)
    assert went == ["differs in everything 0", "gain", "named"]  # that of least cost, and the first by either
    assert others_too == [True, False, False]  # from the end of another start, too: only single effects


def test_each_effect_of_what_leads_is_asked_alone_as_its_runs_differ(monkeypatch: pytest.MonkeyPatch) -> None:
    """However many sets with conditions one of them was tried in; and with conditions alike in all runs."""
    found: Any = a_search(lead=9.0)
    pair = raced(candidate(["coulomb_friction", "cogging"], times=2.0, deviations=["gain", "damping"]))
    rubs = [
        raced(candidate(["coulomb_friction"], times=3.0, deviations=d)) for d in (["gain", "damping"], ["gain"], [])
    ]
    bumps = [raced(candidate(["cogging"], times=5.0, deviations=d)) for d in (["gain"], [])]
    apart = raced(candidate(["cogging"], times=2.5, deviations=["start_time"]))  # which the pair has not
    order = [pair, apart, *rubs, *bumps]
    found.standings.nodes = {n.key: n for n in (found.standings.root, *order)}
    found.standings.candidates = {
        c.key: c for c in (candidate(times=30.0), Candidate(pair.effects, pair.deviations, pair.best, 9.0))
    }
    asked: list[Any] = []
    monkeypatch.setattr(found.fits, "polish", asked.append)
    monkeypatch.setattr(found.standings, "in_order", lambda: order)
    monkeypatch.setattr(found.standings, "nameable", lambda nodes: iter([pair, *rubs[:1]]))
    found.fits.polish_leads()
    alone = [n for n in asked if len(n.effects) == 1]
    assert {n.key for n in alone} == {n.key for n in (rubs[0], rubs[2], bumps[0], bumps[1])}
