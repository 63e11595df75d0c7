"""Why a proposal is not fitted, as a search says it to who adds a move; nothing is searched."""

from __future__ import annotations

from typing import Any

import pytest

from made_up_search import PAIR, a_search, node, nothing_imitates, proposed
from stepid.diagnosis.selection.moves import MOVES


@pytest.fixture(autouse=True)
def plain_search(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing_imitates(monkeypatch)


def refusals(found: Any) -> dict[tuple[str, int], str]:
    return {(p.move, p.size): found.queue.refusal(p) for p in found.queue.proposals}


@pytest.mark.parametrize("lead", [9.0, 40.0])  # one that leads, one that does not
def test_what_is_refused_is_what_is_not_asked(lead: float) -> None:
    found: Any = a_search(lead)
    asked = found.queue.rivals([found.queue.proposals[0].base], unforeseen=found.queue.unforeseen())
    assert {key for key, why in refusals(found).items() if not why} == {(p.move, p.size) for p in asked}


def test_each_gate_has_its_words() -> None:
    far: Any = a_search(lead=40.0)
    assert refusals(far)["drop", 1] == "nothing is answered, and it promises no answer"
    found: Any = a_search(lead=9.0)
    drop = next(p for p in found.queue.proposals if p.move == "drop")
    assert found.queue.refusal(drop) == ""
    found.queue.tried = {(drop.base, drop.key)}
    assert found.queue.refusal(drop) == "it was fitted"
    found.queue.tried = set()
    general = node("stribeck_friction", "cogging", cost=8.8)
    found.standings.nodes[general.key] = general
    assert refusals(found)["generalize", 2].startswith("its set was fitted")
    other = proposed(node(*PAIR, cost=9.0), "coulomb_friction", "free_play", move="resemble", left=8.0)
    found.queue.proposals.append(other)
    assert "another proposal of its set" in found.queue.refusal(other)
    nothing = proposed(found.standings.root, "cogging", move="add", left=99.9)
    found.queue.proposals.append(nothing)
    assert found.queue.refusal(nothing).startswith("it promises to leave no less")


def test_sets_at_once_wait_for_room_only() -> None:
    found: Any = a_search(lead=9.0)
    together = proposed(found.standings.root, "cogging", "sensor_drift", move=MOVES.together[0].name, left=99.0)
    found.queue.proposals.append(together)
    assert found.queue.refusal(together) == ""
