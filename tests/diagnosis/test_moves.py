"""Moves to sets that explain more, from one small node: what they propose, and in which order. Nothing is searched."""

from __future__ import annotations

from copy import copy

import numpy as np
import pytest

from exact_plants import EFFECTS, exact_campaign
from search_nodes import FRICTION, GENERAL, SIMPLE, TWO, context, node, prepared, sets, sound
from stepid.diagnosis.selection.moves import MOVES
from stepid.diagnosis.selection.moves.add import Add
from stepid.diagnosis.selection.moves.add_together import AddTogether
from stepid.diagnosis.selection.moves.deviate import Deviate
from stepid.diagnosis.selection.moves.generalize import Generalize
from stepid.diagnosis.selection.moves.instead import Instead
from stepid.diagnosis.selection.moves.remain import Remain
from stepid.diagnosis.selection.proposal import Node, related, standing
from stepid.effects import resolve
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.fit import prepare


def test_each_move_has_a_name_of_its_own() -> None:
    kinds = {type(m) for m in (*MOVES.exploring, *MOVES.confirming, *MOVES.in_place, *MOVES.same)}
    assert len(MOVES.every) == len(kinds) + len(MOVES.together), "two moves have one name"


def test_add_offers_every_simple_effect_the_right_one_first() -> None:
    fit = prepared("friction")
    root = node(fit)
    found = Add().propose(root, context(fit))
    sound(Add(), root, found)
    assert sorted(sets(found)) == sorted((e.name,) for e in SIMPLE)
    first = min(found, key=lambda p: p.left)
    assert first.effects[0].dry
    assert first.left < 0.5 * root.cost


def test_add_goes_on_from_a_node_with_what_is_not_related() -> None:
    fit = prepared("two")
    one = node(fit, FRICTION)
    found = Add().propose(one, context(fit))
    sound(Add(), one, found)
    assert all(names[0] == "coulomb_friction" and len(names) == 2 for names in sets(found))
    assert not {e.name for e in GENERAL} & {names[1] for names in sets(found)}
    assert "free_play" in [p.effects[1].name for p in sorted(found, key=lambda p: p.left)[:3]]


def test_instead_offers_what_add_does_by_a_name_of_its_own() -> None:
    fit = prepared("two")
    one = node(fit, FRICTION)
    found = Instead().propose(one, context(fit))
    sound(Instead(), one, found)
    assert sets(found) == sets(Add().propose(one, context(fit)))
    assert {p.move for p in found} == {"instead"}


def test_add_ends_where_a_set_is_full() -> None:
    fit = prepared("two")
    assert Add().propose(node(fit, TWO), context(fit, effects=2)) == []


def test_add_ranks_an_effect_of_many_parameters_and_a_general_base_lower() -> None:
    fit = prepared("friction")
    one = node(fit, FRICTION)
    costly = {p.effects[1].name: p.costly for p in Add().propose(one, context(fit, price=0.5))}
    assert costly["quadratic_damping"] == 1.0
    assert costly["flexible_coupling"] > 1.4
    fit = prepared("stribeck")
    general = node(fit, {"stribeck_friction": EFFECTS["stribeck_friction"]})
    dear = {p.effects[1].name: p.costly for p in Add().propose(general, context(fit, costly=4.0))}
    assert dear["quadratic_damping"] == 4.0


def test_add_offers_a_general_law_where_it_promises_what_none_inside_it_does() -> None:
    hidden = {"presliding_hysteresis": {"level": 0.3, "distance": 2e-3}}
    fit = prepare(exact_campaign(hidden))
    root = node(fit)
    found = Add().propose(root, context(fit))
    sound(Add(), root, found)
    assert min(found, key=lambda p: p.left).effects[0].name == "presliding_hysteresis"
    inside = [p for p in found if p.effects[0].name == "coulomb_friction"]
    general = [p for p in found if p.effects[0].contains]
    assert all(2 * p.left < inside[0].left for p in general)


@pytest.mark.parametrize("along", [False, True])
def test_add_together_offers_pairs_whose_effects_both_take_a_share(along: bool) -> None:
    fit = prepared("two")
    root = node(fit)
    found = AddTogether(2, along).propose(root, context(fit))
    sound(AddTogether(2, along), root, found)
    assert all(len(p.effects) == 2 and not related(*p.effects) for p in found)
    order = sorted(found, key=lambda p: p.left * p.costly)
    assert {frozenset(e.name for e in p.effects) for p in order[:3]} & {frozenset(TWO)}
    fewer = AddTogether(2, along).propose(root, context(fit, worth=0.9))
    assert len(fewer) < len(found)
    assert AddTogether(2, along).propose(node(fit, FRICTION), context(fit)) == []
    assert AddTogether(3, along).propose(root, context(fit, effects=2)) == []


def test_scores_along_the_motion_are_kept_for_larger_sets() -> None:
    fit = prepared("two")
    AddTogether(2, along=True).propose(node(fit), context(fit))
    (kept,) = (score for (along, _), score in fit.joint.items() if along)
    AddTogether(3, along=True).propose(node(fit), context(fit))
    assert [score for (along, _), score in fit.joint.items() if along] == [kept]


def test_nothing_is_offered_along_a_motion_that_rests() -> None:
    fit = copy(prepared("two"))
    fit.joint, fit.motion = {}, fit.motion._replace(v=np.zeros_like(fit.motion.v))
    assert AddTogether(2, along=True).propose(node(fit), context(fit)) == []


def test_add_three_together_offers_what_promises_more_than_any_two_of_them() -> None:
    fit = prepared("two")
    root = node(fit)
    least = {p.key[0]: p.left for p in AddTogether(2).propose(root, context(fit))}
    found = AddTogether(3).propose(root, context(fit))
    assert all(len(p.effects) == 3 for p in found)
    for p in found:
        inside = [left for names, left in least.items() if names < p.key[0]]
        assert p.left < min(inside, default=np.inf)


def test_deviate_frees_each_condition_that_is_not_free() -> None:
    fit = prepared("gain")
    root = node(fit)
    found = Deviate().propose(root, context(fit))
    sound(Deviate(), root, found)
    assert [p.deviations for p in found] == [
        frozenset({"start_time"}),
        frozenset({"gain"}),
        frozenset({"damping"}),
        frozenset({"start_time", "gain", "damping"}),  # no friction there
    ]
    best = min(found, key=lambda p: p.rank)
    assert best.deviations == {"gain"}
    assert best.left < 0.1 * root.cost
    assert best.costly > 1
    again = Node(CandidateFit(fit, (), frozenset({"gain"})))
    again.fitted.best = fit.coarse_linear
    assert all(p.deviations > {"gain"} for p in Deviate().propose(again, context(fit)))


def test_a_linear_plant_promises_nothing() -> None:
    fit = prepared("linear")
    root = node(fit)
    for move in (Add(), Deviate()):
        for p in move.propose(root, context(fit)):
            assert root.cost - p.left < 0.1 * root.cost


def test_only_what_is_in_the_catalogue_is_proposed() -> None:
    fit = prepared("friction")
    some = resolve(["free_play", "cogging"])
    assert sorted(sets(Add().propose(node(fit), context(fit, some)))) == [("cogging",), ("free_play",)]
    assert Generalize().propose(node(fit, FRICTION), context(fit, some)) == []


def test_remain_frees_conditions_beside_the_effect_from_where_that_stands() -> None:
    fit = prepared("friction")
    one = node(fit, FRICTION)
    (found,) = Remain(frozenset({"gain"})).propose(one, context(fit))
    assert (found.effects, found.deviations, found.base, found.left) == (one.effects, {"gain"}, one.key, one.cost)
    (start,) = found.starts
    assert start.values == standing(one).values
    np.testing.assert_array_equal(start.linear, standing(one).linear)
