"""What is tried where no set is enough: further effects are fitted beside the best sets, not only scored."""

from __future__ import annotations

from typing import Any

import pytest

from made_up_search import PAIR, a_search, node, nothing_imitates

FITTED_IN = 1e5  # steps times states


@pytest.fixture(autouse=True)
def plain_search(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing_imitates(monkeypatch)
    monkeypatch.setattr("stepid.diagnosis.selection.attempts.promote", lambda *_: None)


def tried(
    monkeypatch: pytest.MonkeyPatch, *, lead: float, work: float = FITTED_IN, found_beside: float | None = None
) -> tuple[bool, list[set[str]]]:
    """Whether the attempt took enough, and the sets beside which effects were fitted."""
    search: Any = a_search(lead=lead)
    single = node("coulomb_friction", cost=2 * lead)
    search.nodes[single.key] = single
    for one in search.nodes.values():
        one.fitted.work = work
    bases: list[set[str]] = []

    def fit(base: Any) -> None:
        bases.append(set(base.key[0]))
        if found_beside is not None and len(base.effects) == 2:
            three = node(*PAIR, "end_stop", cost=found_beside)
            search.nodes[three.key] = three

    monkeypatch.setattr(search, "_expand", lambda *_: True)
    monkeypatch.setattr(search, "_fit_beside", fit)
    return search._try_beside(), bases


def test_effects_are_fitted_beside_the_best_single_effects_and_the_best_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    assert tried(monkeypatch, lead=9.0) == (False, [{"coulomb_friction"}, set(PAIR)])


@pytest.mark.parametrize(("left", "enough"), [(0.5, True), (1.3, True), (4.0, False)])  # noise; most of it; not most
def test_the_search_goes_on_where_one_takes_most_of_what_was_left(
    left: float, enough: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert tried(monkeypatch, lead=9.0, found_beside=left)[0] is enough


def test_what_is_explained_needs_none(monkeypatch: pytest.MonkeyPatch) -> None:
    assert tried(monkeypatch, lead=0.9) == (False, [])


def test_of_long_records_none_is_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    assert tried(monkeypatch, lead=9.0, work=10 * FITTED_IN) == (False, [])
