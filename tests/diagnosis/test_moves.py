"""Each move, from one small node: what it proposes, from where, and in which order. Nothing is searched."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest

import stepid
from broken_campaigns import campaign
from exact_plants import EFFECTS, exact_campaign
from scattered_campaigns import scattered
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.moves import CONFIRMING, EXPLORING, MOVES, TOGETHER
from stepid.diagnosis.selection.moves.add import Add
from stepid.diagnosis.selection.moves.add_together import AddTogether
from stepid.diagnosis.selection.moves.deviate import Deviate
from stepid.diagnosis.selection.moves.drop import Drop
from stepid.diagnosis.selection.moves.exchange import Exchange
from stepid.diagnosis.selection.moves.generalize import Generalize
from stepid.diagnosis.selection.moves.specialize import Specialize, level_within
from stepid.diagnosis.selection.moves.split import Split
from stepid.diagnosis.selection.proposal import Move, Node, Proposal, SearchContext, related, standing
from stepid.effects import CATALOGUE, Effect, resolve
from stepid.fitting.deviations import SCATTER
from stepid.fitting.fit import prepare
from stepid.fitting.multistart import CandidateFit, FitContext, Start

Values = Mapping[str, Mapping[str, float]]
FRICTION = {"coulomb_friction": {"level": 0.2}}
TWO = FRICTION | {"free_play": {"gap": 5e-4}}
GENERAL = [e for e in CATALOGUE if e.contains]
SIMPLE = [e for e in CATALOGUE if not e.contains]


def noisy(effects: Values) -> stepid.Campaign:
    return campaign(1, effects, masses=(0.0, 0.5, 1.5))


@cache
def prepared(which: str) -> FitContext:
    """Fit contexts of campaigns: none, one or two effects, runs that differ."""
    made = {
        "linear": lambda: noisy({}),
        "friction": lambda: noisy(FRICTION),
        "two": lambda: noisy(TWO),
        "stribeck": lambda: exact_campaign({"stribeck_friction": EFFECTS["stribeck_friction"]}),
        "power": lambda: noisy({"coulomb_friction": {"level": 0.3}, "quadratic_damping": {"coefficient": 40.0}}),
        "gain": lambda: scattered(1, gain=(0.02, -0.02, 0.01, 0.0, -0.01, 0.0)),
    }
    return prepare(made[which]())


def node(fit: FitContext, effects: Values | None = None) -> Node:
    """A node at these values, a few steps on; without effects the linear plant."""
    if not effects:
        root = CandidateFit(fit, ())
        root.best, root.polished = fit.coarse_linear, fit.linear
        return Node(root)
    fitted = CandidateFit(fit, resolve(tuple(effects)))
    values = tuple(tuple(own.values()) for own in effects.values())
    fitted.begin([Start(fit.coarse_linear.shared, values)], like=fit.coarse_linear, laps=10)
    return Node(fitted)


def context(fit: FitContext, catalogue: tuple[Effect, ...] = CATALOGUE, **effort: float) -> SearchContext:
    return SearchContext(fit, catalogue, Effort(**effort))


def sets(proposals: list[Proposal]) -> list[tuple[str, ...]]:
    return [tuple(e.name for e in p.effects) for p in proposals]


def sound(move: Move, from_: Node, proposals: list[Proposal]) -> None:
    """What holds for the proposals of every move."""
    assert proposals
    assert len({p.key for p in proposals}) == len(proposals)
    for p in proposals:
        assert (p.move, p.base, p.like) == (move.name, from_.key, from_.best)
        assert p.key != from_.key
        assert p.starts
        assert p.left >= 0
        assert p.costly >= 1
        for start in p.starts:
            assert start.linear.shape == from_.best.shared[from_.best.problem.layout.linear].shape
            assert [len(v) for v in start.values] == [len(e.parameters) for e in p.effects]


def test_each_move_has_a_name_of_its_own() -> None:
    kinds = {type(m) for m in (*EXPLORING, *CONFIRMING)}
    assert len({m.name for m in MOVES}) == len(MOVES) == len(kinds) + len(TOGETHER), "two moves have one name"


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


def test_add_together_offers_pairs_whose_effects_both_take_a_share() -> None:
    fit = prepared("two")
    root = node(fit)
    found = AddTogether(2).propose(root, context(fit))
    sound(AddTogether(2), root, found)
    assert all(len(p.effects) == 2 and not related(*p.effects) for p in found)
    order = sorted(found, key=lambda p: p.left * p.costly)
    assert {frozenset(e.name for e in p.effects) for p in order[:3]} & {frozenset(TWO)}
    fewer = AddTogether(2).propose(root, context(fit, worth=0.9))
    assert len(fewer) < len(found)
    assert AddTogether(2).propose(node(fit, FRICTION), context(fit)) == []
    assert AddTogether(3).propose(root, context(fit, effects=2)) == []


def test_add_three_together_offers_what_promises_more_than_any_two_of_them() -> None:
    fit = prepared("two")
    root = node(fit)
    least = {p.key[0]: p.left for p in AddTogether(2).propose(root, context(fit))}
    found = AddTogether(3).propose(root, context(fit))
    assert all(len(p.effects) == 3 for p in found)
    for p in found:
        inside = [left for names, left in least.items() if names < p.key[0]]
        assert p.left < min(inside, default=np.inf)


def test_generalize_offers_what_contains_an_effect_from_where_it_stands() -> None:
    fit = prepared("friction")
    one = node(fit, FRICTION)
    found = Generalize().propose(one, context(fit))
    sound(Generalize(), one, found)
    assert set(sets(found)) == {(e.name,) for e in GENERAL if "coulomb_friction" in e.contains}
    assert all(p.left <= one.cost for p in found)
    assert Generalize().propose(node(fit), context(fit)) == []


def test_specialize_offers_what_is_inside_at_the_same_level() -> None:
    fit = prepared("friction")
    uneven = node(fit, {"asymmetric_friction": {"level_forward": 0.15, "level_backward": 0.25}})
    found = Specialize().propose(uneven, context(fit))
    sound(Specialize(), uneven, found)
    assert sets(found) == [("coulomb_friction",)]
    (level,) = found[0].starts[0].values[0]
    assert level == pytest.approx(np.mean(standing(uneven).values[0]))
    assert Specialize().propose(node(fit, FRICTION), context(fit)) == []


def test_a_level_inside_is_the_mean_of_those_in_its_unit() -> None:
    uneven, coulomb, pair = resolve(["asymmetric_friction", "coulomb_friction", "free_play"])
    assert level_within(uneven, np.array([0.1, 0.3]), coulomb) == pytest.approx(0.2)
    assert level_within(uneven, np.array([0.1, 0.3]), pair) is None
    assert level_within(uneven, np.array([0.1, 0.3]), uneven) is None


def test_exchange_puts_every_other_simple_effect_in_each_place() -> None:
    fit = prepared("friction")
    wrong = node(fit, {"quadratic_damping": {"coefficient": 10.0}})
    found = Exchange().propose(wrong, context(fit))
    sound(Exchange(), wrong, found)
    assert set(sets(found)) <= {(e.name,) for e in SIMPLE} - {("quadratic_damping",)}
    assert min(found, key=lambda p: p.left).effects[0].dry
    two = node(fit, {"coulomb_friction": {"level": 0.2}, "quadratic_damping": {"coefficient": 10.0}})
    kept = sets(Exchange().propose(two, context(fit)))
    assert all(("coulomb_friction" in names) != ("quadratic_damping" in names) for names in kept)
    assert Exchange().propose(node(fit), context(fit)) == []


def test_drop_takes_each_effect_away() -> None:
    fit = prepared("friction")
    two = node(fit, {"coulomb_friction": {"level": 0.2}, "quadratic_damping": {"coefficient": 1.0}})
    found = Drop().propose(two, context(fit))
    sound(Drop(), two, found)
    assert sorted(sets(found)) == [("coulomb_friction",), ("quadratic_damping",)]
    left = {p.effects[0].name: p.left for p in found}
    assert left["coulomb_friction"] < 0.2 * left["quadratic_damping"]
    assert Drop().propose(node(fit, FRICTION), context(fit)) == []


def test_drop_takes_conditions_away_too() -> None:
    fit = prepared("gain")
    both = Node(CandidateFit(fit, (), frozenset({"gain", "start_time"})))
    both.fitted.best = fit.coarse_linear
    found = Drop().propose(both, context(fit))
    sound(Drop(), both, found)
    assert [p.deviations for p in found] == [frozenset({"start_time"}), frozenset({"gain"})]
    one = Node(CandidateFit(fit, (), frozenset({"gain"})))
    one.fitted.best = fit.coarse_linear
    assert Drop().propose(one, context(fit)) == []  # the linear plant is at its optimum


def test_exchange_tries_runs_that_differ_for_an_effect_that_is_free_in_every_run() -> None:
    fit = prepared("gain")
    sine = node(fit, {"periodic_disturbance": {"amplitude": 0.05, "frequency": 3.0}})
    found = Exchange().propose(sine, context(fit))
    assert [(p.effects, p.deviations) for p in found if p.deviations] == [((), frozenset(SCATTER))]


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


def test_split_offers_two_laws_for_a_curved_one() -> None:
    fit = prepared("power")
    power = node(fit, {"power_damping": {"coefficient": 2.0, "exponent": 1.5}})
    found = Split().propose(power, context(fit, alike=1.0))
    for p in found:
        assert len(p.effects) == 2
        assert p.effects[0].name in power.effects[0].contains
        assert not related(*p.effects)
    assert len(found) <= 2
    assert Split().propose(power, context(fit, alike=1e-9)) == []
    assert Split().propose(power, context(fit, effects=1)) == []
    assert Split().propose(node(fit, FRICTION), context(fit)) == []
    assert Split().propose(node(fit), context(fit)) == []


def test_split_knows_friction_and_damping_in_stribeck_friction() -> None:
    fit = prepared("stribeck")
    general = node(fit, {"stribeck_friction": EFFECTS["stribeck_friction"]})
    found = Split().propose(general, context(fit, alike=1.0))
    sound(Split(), general, found)
    assert all(names[0] == "coulomb_friction" for names in sets(found))


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
