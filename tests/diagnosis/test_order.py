"""Which sets come first, and which are looked at again beside the best answer."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from made_up_evidence import candidate
from stepid.diagnosis.selection.candidate import LINEAR
from stepid.diagnosis.selection.order import (
    apart,
    beside,
    exchanges,
    generals,
    inside,
    larger,
    largest_beyond,
    largest_lead,
    modes,
    no_answer,
    of_each_size,
    resting,
    starts_in_order,
)
from stepid.diagnosis.selection.proposal import overshadowed
from stepid.effects import resolve
from stepid.fitting.multistart import Start


def made_up(*names: str, deviations: tuple[str, ...] = (), cost: float = 1.0) -> Any:
    found = candidate(names, deviations=deviations)
    return SimpleNamespace(key=found.key, effects=found.effects, deviations=found.deviations, cost=cost)


FRICTION, PLAY, COGGING = made_up("coulomb_friction", cost=3.0), made_up("free_play", cost=2.0), made_up("cogging")


@pytest.mark.parametrize(
    ("general", "simple", "hidden"),
    [(0.4, 1.0, False), (0.6, 1.0, True), (0.4, None, False)],  # less than half; more; none inside was scored
)
def test_a_general_law_stands_in_its_own_right_where_it_leaves_less_than_half(
    general: float, simple: float | None, hidden: bool
) -> None:
    stribeck, coulomb, play = resolve(["stribeck_friction", "coulomb_friction", "free_play"])
    scored = [((play, stribeck), general), ((play, stribeck), 2.0), ((play,), 0.1)]
    scored += [((coulomb, play), simple)] if simple is not None else []
    assert overshadowed(scored) == ({frozenset({"free_play", "stribeck_friction"})} if hidden else set())


def test_nodes_are_told_apart_by_size_in_the_order_given() -> None:
    nodes = [SimpleNamespace(size=size, name=name) for size, name in ((2, "a"), (1, "b"), (2, "c"), (0, "d"))]
    names = [[node.name for node in alike] for alike in of_each_size(nodes)]  # type: ignore[arg-type]
    assert names == [["d"], ["b"], ["a", "c"]]


def test_starts_follow_their_effects() -> None:
    play, cogging = resolve(["free_play", "cogging"])
    start = Start(np.zeros(4), ((1e-3,), (0.1, 0.02, 0.0)))
    source = SimpleNamespace(effects=(play, cogging), starts=(start,))
    (turned,) = starts_in_order(source, (cogging, play))  # type: ignore[arg-type]
    assert turned.values == ((0.1, 0.02, 0.0), (1e-3,))


@pytest.mark.parametrize(("count", "cost", "none"), [(2, 9.0, False), (3, 1.0, False), (3, 1.2, True), (4, 9.0, True)])
def test_more_effects_than_may_lead_are_an_answer_at_the_floor_only(count: int, cost: float, none: bool) -> None:
    effects = resolve(["coulomb_friction", "free_play", "cogging", "actuator_lag"])[:count]
    assert no_answer(1.1, effects, cost) is none


def test_the_largest_set_that_may_lead_is_the_one_of_two_effects_that_leaves_least() -> None:
    pairs = [made_up("coulomb_friction", "cogging", cost=2.0), made_up("free_play", "cogging", cost=1.0)]
    others = [COGGING, made_up("free_play", "sensor_drift", deviations=("gain",), cost=0.1), made_up(cost=9.0)]
    assert largest_lead([*pairs, *others]) is pairs[1]
    assert largest_lead(others) is None


def proposed(names: str, base: str, left: float, deviations: tuple[str, ...] = (), move: str = "add") -> Any:
    effects = resolve(tuple(names.split()))
    key = frozenset(e.name for e in effects), frozenset(deviations)
    on = frozenset(base.split()), frozenset[str]()
    return SimpleNamespace(effects=effects, deviations=key[1], key=key, base=on, rank=left, left=left, move=move)


def test_larger_sets_are_the_first_few_on_the_best_pair_and_of_those_scored_together() -> None:
    pair = made_up("free_play", "cogging")
    pair.key = frozenset(e.name for e in pair.effects), frozenset()
    own = [
        proposed(f"free_play cogging {name}", "free_play cogging", left)
        for name, left in (("sensor_drift", 3.0), ("coulomb_friction", 1.0), ("cubic_stiffness", 2.0))
    ]
    moves: Any = (SimpleNamespace(name="along"), SimpleNamespace(name="together"))
    together = [proposed("sensor_drift free_play cogging", "", 5.0), proposed("end_stop free_play cogging", "", 6.0)]
    for one, move in zip(together, moves, strict=True):
        one.move = move.name
    others = [
        proposed("end_stop sensor_drift cogging", "end_stop cogging", 0.1),  # on another pair
        proposed("free_play end_stop", "free_play", 0.1),
        proposed("free_play cogging input_delay", "free_play cogging", 0.1, ("gain",)),
    ]
    known: Any = {others[0].key: None}
    assert larger([*own, *together, *others], known, pair, 2, moves) == [*together, own[1], own[2]]
    assert larger([*own, *together, *others], known, pair, 3, moves) == [
        own[0],
        together[1],
        own[1],
        own[2],
    ]  # the same once
    assert larger([*own, *together, *others], known | {own[1].key: None}, pair, 1, moves) == [together[0], own[2]]
    assert larger([*own, *together], {}, None, 1, moves) == [together[0]]  # the moves in turn
    assert larger([*own, *together], {together[0].key: None}, None, 1, moves) == [together[1]]


def test_single_effects_inside_a_pair() -> None:
    simple, general, free = made_up("coulomb_friction"), made_up("stribeck_friction"), made_up("cogging")
    scattered, apart_ = made_up("coulomb_friction", deviations=("gain",)), made_up("cogging", deviations=("damping",))
    nodes = [scattered, apart_, simple, general, free, made_up()]
    assert inside(nodes, [made_up("stribeck_friction", "cogging")]) == [simple, general, free]
    assert inside(nodes, [made_up("stribeck_friction", "cogging", deviations=("gain",))]) == [scattered, general, free]
    assert inside(nodes, []) == []


def test_a_mode_is_asked_beside_what_leads_and_beside_nothing_else() -> None:
    bases = {name: candidate([name]).key for name in ("coulomb_friction", "cogging")}
    linear = candidate().key

    def proposed(base: Any, *names: str) -> Any:
        found = candidate(names)
        return SimpleNamespace(base=base, key=found.key, effects=found.effects)

    beside = proposed(bases["coulomb_friction"], "coulomb_friction", "flexible_coupling")
    every = [
        beside,
        proposed(bases["coulomb_friction"], "coulomb_friction", "free_play"),  # no mode
        proposed(bases["coulomb_friction"], "flexible_coupling"),  # in the place of what leads
        proposed(linear, "flexible_coupling"),
        proposed(bases["cogging"], "cogging", "flexible_coupling"),
        beside,
    ]
    assert modes(every, {}, [bases["coulomb_friction"], linear]) == [beside]
    assert modes(every, {beside.key: FRICTION}, [bases["coulomb_friction"]]) == []


def test_what_lets_a_cart_rest_anywhere_is_asked_alone() -> None:
    def proposed(*names: str, base: Any = LINEAR, deviations: tuple[str, ...] = ()) -> Any:
        found = candidate(names)
        return SimpleNamespace(base=base, key=found.key, effects=found.effects, deviations=deviations)

    friction, play = proposed("coulomb_friction"), proposed("free_play")
    every = [
        friction,
        proposed("cubic_stiffness"),  # the cart rests at one place
        proposed("stribeck_friction"),  # more than Coulomb friction
        proposed("coulomb_friction", "cogging"),
        proposed("coulomb_friction", base=candidate(["cogging"]).key),  # in the place of another
        proposed("coulomb_friction", deviations=("gain",)),
        play,
        friction,
    ]
    assert resting(every) == [friction, play]


THREE = ("coulomb_friction", "free_play", "cogging")


def beyond(cost: float, *names: str, deviations: tuple[str, ...] = ()) -> Any:
    node = made_up(*(names or THREE), deviations=deviations, cost=cost)
    node.key = frozenset(e.name for e in node.effects), frozenset(deviations)
    return node


def test_a_larger_set_far_below_all_that_may_lead_is_looked_at_once() -> None:
    pair, best = beyond(10.0, "cogging", "free_play"), beyond(2.0)
    near, far = (beyond(cost, *THREE[:2], "end_stop") for cost in (4.0, 4.1))
    differ = beyond(0.1, deviations=("gain",))  # conditions that differ take what they like
    assert largest_beyond([pair, near, best, differ], ()) is best
    assert largest_beyond([pair, near, best, differ], [best.key]) is near
    assert largest_beyond([pair, near, best], [best.key, near.key]) is None
    assert largest_beyond([pair, far, best], [best.key]) is None  # far from the best of them
    assert largest_beyond([pair, beyond(5.0)], ()) is None  # half of what the pair leaves
    assert largest_beyond([pair], ()) is None


def test_exchanges_of_an_effect_are_of_those_that_its_absence_needs() -> None:
    """Left without cogging are 40: what promises 20 or more does not stand for it."""
    base = beyond(2.0)
    base.key = frozenset(THREE), frozenset()
    nodes: Any = {
        base.key: base,
        (frozenset(THREE[:2]), frozenset()): beyond(40.0, *THREE[:2]),
        (frozenset({*THREE[:2], "end_stop"}), frozenset()): beyond(5.0),
        (frozenset({*THREE[:2], "sensor_drift"}), frozenset()): beyond(50.0),
    }

    def proposed(new: str, left: float, *, kept: tuple[str, ...] = THREE[:2], move: str = "exchange") -> Any:
        key = frozenset({*kept, new}), frozenset[str]()
        own = {"key": key, "effects": tuple(key[0]), "deviations": frozenset(), "base": base.key}
        return SimpleNamespace(**own, move=move, left=left, rank=left)

    first, second = proposed("actuator_lag", 19.0), proposed("sensor_drift", 9.0)  # stuck at 50
    unknown = proposed("end_stop", 60.0, kept=THREE[1:])  # nobody has asked what its absence leaves
    given = [
        first,
        second,
        unknown,
        proposed("flexible_coupling", 20.0),
        proposed("end_stop", 6.0),  # left 5 once it was fitted
        proposed("input_delay", 1.0, move="add"),
        proposed("input_delay", 1.0, kept=THREE[:1]),
    ]
    assert exchanges(given, nodes, base, 9) == [second, first, unknown]
    assert exchanges(given, nodes, base, 2) == [second, first]


def test_a_set_with_a_more_general_law_that_left_more_had_ended_elsewhere() -> None:
    base = beyond(2.0)
    base.key = frozenset(THREE), frozenset()

    def grown(name: str, *, of: Any = base.key, move: str = "generalize") -> Any:
        return SimpleNamespace(key=(frozenset({*THREE[:2], name}), frozenset[str]()), base=of, move=move)

    earlier, newest, stuck = grown("stribeck_friction"), grown("stribeck_friction"), grown("power_damping")
    done = grown("presliding_hysteresis")
    nodes: Any = {base.key: base, stuck.key: beyond(2.1), done.key: beyond(1.9)}
    others = [grown("end_stop", move="add"), grown("asymmetric_friction", of=stuck.key)]
    assert generals([earlier, stuck, done, newest, *others], nodes, base) == [newest, stuck]


def test_the_best_sets_of_a_size_are_apart_where_none_is_another_by_a_law_inside() -> None:
    stribeck, coulomb = made_up("stribeck_friction", cost=1.0), made_up("coulomb_friction", cost=1.5)
    nodes = [PLAY, coulomb, stribeck, made_up("cogging", cost=4.0), made_up("end_stop", cost=5.0)]
    others = [made_up("sensor_drift", deviations=("gain",), cost=0.1), made_up("cogging", "free_play", cost=0.1)]
    assert apart([*nodes, *others, made_up(cost=9.0)], 1, 3) == [stribeck, PLAY, nodes[3]]
    assert apart(others, 2, 3) == others[1:]


def test_beside_a_base_stand_sets_of_one_effect_more_the_most_promising_first() -> None:
    base = frozenset({"free_play"}), frozenset[str]()
    drift, friction = (
        proposed("free_play sensor_drift", "free_play", 3.0),
        proposed("free_play cogging", "free_play", 2.0),
    )
    others = [
        proposed("cogging end_stop", "cogging", 0.1),  # of another base
        proposed("sensor_drift", "free_play", 0.1, move="exchange"),  # in its place
        proposed("free_play input_delay", "free_play", 0.1, ("gain",)),
    ]
    assert beside([drift, *others, friction], base) == [friction, drift]
