"""Which sets come first, and which are looked at again beside the best answer."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from made_up_evidence import candidate
from stepid.diagnosis.selection.order import no_answer, of_each_size, singles, starts_in_order
from stepid.diagnosis.selection.proposal import overshadowed
from stepid.effects import resolve
from stepid.fitting.multistart import Start


def made_up(*names: str, deviations: tuple[str, ...] = (), cost: float = 1.0) -> Any:
    found = candidate(names, deviations=deviations)
    return SimpleNamespace(effects=found.effects, deviations=found.deviations, cost=cost)


FRICTION, PLAY, COGGING = made_up("coulomb_friction", cost=3.0), made_up("free_play", cost=2.0), made_up("cogging")
NODES = [made_up(), FRICTION, PLAY, COGGING, made_up("cogging", deviations=("gain",)), made_up("cogging", "free_play")]


@pytest.mark.parametrize(
    ("names", "deviations", "asked"),
    [
        ((), ("gain",), [COGGING, PLAY, FRICTION]),  # each takes much of what such conditions do
        (("coulomb_friction", "free_play"), (), [PLAY, FRICTION]),  # one of them may be such a condition
        (("stribeck_friction", "free_play"), (), [PLAY, FRICTION]),  # a simpler law is inside
        (("coulomb_friction",), (), []),
        (("coulomb_friction", "free_play"), ("gain",), []),
        ((), (), []),
    ],
)
def test_single_effects_that_conditions_may_complete(
    names: tuple[str, ...], deviations: tuple[str, ...], asked: list[Any]
) -> None:
    assert singles(NODES, candidate(names, deviations=deviations)) == asked


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
    assert no_answer(SimpleNamespace(floored=1.1), effects, cost) is none  # type: ignore[arg-type]
