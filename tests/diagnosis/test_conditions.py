"""What is tried where conditions differ from run to run: effects in their place, and beside them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from made_up_evidence import candidate
from stepid.diagnosis.selection.conditions import calmer, ended_elsewhere, from_the_best, in_place, instead, singles
from stepid.diagnosis.selection.moves import remain
from stepid.effects import resolve
from stepid.fitting.multistart import Start


def made_up(*names: str, deviations: tuple[str, ...] = (), cost: float = 1.0) -> Any:
    found = candidate(names, deviations=deviations)
    key = frozenset(names), frozenset(deviations)
    return SimpleNamespace(effects=found.effects, deviations=found.deviations, cost=cost, key=key, best=found.optimum)


FRICTION, PLAY, COGGING = made_up("coulomb_friction", cost=3.0), made_up("free_play", cost=2.0), made_up("cogging")
SHAKEN = made_up("cogging", deviations=("gain",))
NODES = [made_up(), FRICTION, PLAY, COGGING, SHAKEN, made_up("cogging", "free_play")]


@pytest.mark.parametrize(
    ("names", "deviations", "asked"),
    [
        ((), ("gain",), [COGGING, PLAY, FRICTION]),  # each takes much of what such conditions do
        (("coulomb_friction", "free_play"), (), [PLAY, FRICTION]),  # one of them may be such a condition
        (("stribeck_friction", "free_play"), (), [PLAY, FRICTION]),  # a simpler law is inside
        (("coulomb_friction",), (), []),
        (("cogging", "free_play"), ("gain",), [COGGING, SHAKEN, PLAY]),  # another condition, or a further one
        (("cogging", "free_play"), ("damping",), [COGGING, PLAY]),
        ((), (), []),
    ],
)
def test_single_effects_that_conditions_may_complete(
    names: tuple[str, ...], deviations: tuple[str, ...], asked: list[Any]
) -> None:
    assert singles(NODES, candidate(names, deviations=deviations)) == asked


def test_calmer_nodes_are_those_of_the_best_in_which_one_condition_less_differs() -> None:
    one = made_up("free_play", deviations=("gain",), cost=2.0)
    other = made_up("free_play", deviations=("damping",))
    nodes = [
        *(one, other, made_up("free_play"), made_up("cogging", deviations=("gain",))),
        *(made_up("free_play", deviations=("start_time",)), made_up("free_play", deviations=("gain", "damping"))),
    ]
    assert calmer(nodes, candidate(("free_play",), deviations=("gain", "damping"))) == [other, one]
    assert calmer(nodes, candidate(("free_play",), deviations=("gain",))) == [nodes[2]]
    assert calmer(nodes, candidate(("free_play",))) == []


def test_an_effect_in_the_place_of_a_condition_begins_where_the_best_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    """The plant's and the best's own parameters are the best's, in the proposal's order; the new one's as proposed."""
    stands = Start(np.array([2.0, 200.0]), ((0.3,), (5e-4,)))
    monkeypatch.setattr("stepid.diagnosis.selection.conditions.standing", lambda node: stands)
    best = made_up("coulomb_friction", "free_play", deviations=("start_time",))
    starts = iter([Start(np.array([1.0, 100.0]), ((1e-3,), (0.2,), (7e-3,)))])
    asked: Any = SimpleNamespace(effects=resolve(("free_play", "coulomb_friction", "input_delay")), starts=starts)
    begun = from_the_best(asked, best)
    assert begun.values == ((5e-4,), (0.3,), (7e-3,))
    assert begun.linear is stands.linear


@pytest.mark.parametrize(("slack", "anew"), [(0.5, ["gain start_time", "damping"]), (1.5, ["gain start_time"])])
def test_more_that_differs_cannot_leave_more(slack: float, anew: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """It is begun from what leaves least, of the same effects with fewer conditions free."""
    monkeypatch.setattr("stepid.diagnosis.selection.conditions.standing", lambda node: node)
    plain, gain = made_up("free_play", cost=4.0), made_up("free_play", deviations=("gain",), cost=2.0)
    nodes = [
        *(plain, gain, made_up("cogging", deviations=("gain",), cost=9.0)),
        made_up("free_play", deviations=("gain", "start_time"), cost=5.0),
        made_up("free_play", deviations=("damping",), cost=5.0),
        made_up("free_play", deviations=("start_time",), cost=4.2),
        made_up("free_play", deviations=("gain", "damping"), cost=1.0),
    ]
    found = ended_elsewhere(nodes, slack)
    assert [" ".join(sorted(p.deviations)) for p in found] == anew
    assert [list(p.starts) for p in found] == [[gain], [plain]][: len(anew)]
    assert (found[0].base, found[0].left, found[0].like) == (gain.key, 2.0, gain.best)


def proposed(names: str, base: str, left: float, deviations: tuple[str, ...] = (), move: str = "add") -> Any:
    effects = resolve(tuple(names.split()))
    key = frozenset(e.name for e in effects), frozenset(deviations)
    on = frozenset(base.split()), frozenset[str]()
    return SimpleNamespace(effects=effects, deviations=key[1], key=key, base=on, rank=left, left=left, move=move)


def test_effects_in_the_place_of_a_condition_are_the_first_few_on_each_base_not_tried() -> None:
    on_play = [
        proposed(f"free_play {name}", "free_play", left, move="instead")
        for name, left in (("sensor_drift", 3.0), ("coulomb_friction", 1.0), ("cubic_stiffness", 2.0))
    ]
    on_cogging = [proposed("cogging sensor_drift", "cogging", 9.0, move="instead")]
    others = [
        proposed("free_play end_stop", "free_play", 0.1),
        proposed("end_stop cogging", "end_stop", 0.1, (), "instead"),
    ]
    every = [*on_play, *on_cogging, *others]
    bases = {on_play[0].base, on_cogging[0].base}
    assert instead(every, set(), bases, 2) == [on_play[1], on_play[2], on_cogging[0]]
    tried = {(on_play[1].base, on_play[1].key)}
    assert instead(every, tried, bases, 2) == [on_play[2], on_play[0], on_cogging[0]]  # what was tried takes no place


BEST = made_up("free_play", deviations=("gain",), cost=1.0)
WITHOUT = made_up("free_play", cost=11.0)


@pytest.mark.parametrize(("cost", "asked"), [(5.9, True), (6.1, False)])
def test_an_effect_that_takes_most_of_what_a_condition_does_is_tried_beside_it(cost: float, asked: bool) -> None:
    found = made_up("free_play", "actuator_dead_zone", cost=cost)
    others = [made_up("free_play", "cogging", cost=9.0), made_up("cogging", "end_stop", cost=0.1)]
    others += [made_up("free_play", "cogging", deviations=("damping",), cost=0.1)]  # another condition takes it
    others += [made_up("free_play", "cogging", "end_stop", cost=0.1)]
    assert in_place([*others, found], [WITHOUT, WITHOUT], BEST, 0.5) == ([found] if asked else [])


@pytest.mark.parametrize(("cost", "stuck"), [(1.4, False), (1.6, True)])
def test_what_was_tried_beside_the_conditions_is_tried_again_where_it_is_stuck(cost: float, stuck: bool) -> None:
    """A larger set leaves no more."""
    found = made_up("free_play", "actuator_dead_zone", cost=3.0)
    known = made_up("free_play", "actuator_dead_zone", deviations=("gain",), cost=cost)
    assert in_place([found, known], [WITHOUT], BEST, 0.5) == ([found] if stuck else [])


def test_nothing_is_tried_beside_a_condition_that_no_effect_comes_near() -> None:
    assert in_place([BEST, WITHOUT], [WITHOUT], BEST, 0.5) == []
    assert in_place([BEST, WITHOUT], [], BEST, 0.5) == []


def test_what_remains_starts_from_the_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remain, "standing", lambda node: node.key)
    found = made_up("free_play", "actuator_dead_zone", cost=3.0)
    (proposal,) = remain.Remain(BEST.deviations).propose(found, SimpleNamespace())  # type: ignore[arg-type]
    assert (proposal.key, proposal.base) == ((found.key[0], BEST.deviations), found.key)
    assert (proposal.starts, proposal.move) == ((found.key,), "remain")
