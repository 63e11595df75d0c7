"""Moves to sets that may explain as much, from one small node: what they propose. Nothing is searched."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from exact_plants import EFFECTS
from search_nodes import FRICTION, GENERAL, SIMPLE, context, node, noisy, prepared, sets, sound
from stepid.diagnosis.selection.moves import drop
from stepid.diagnosis.selection.moves.drop import Drop
from stepid.diagnosis.selection.moves.exchange import Exchange
from stepid.diagnosis.selection.moves.generalize import Generalize
from stepid.diagnosis.selection.moves.likeness import ForceAlong, is_force
from stepid.diagnosis.selection.moves.regeneralize import Regeneralize
from stepid.diagnosis.selection.moves.resemble import Resemble
from stepid.diagnosis.selection.moves.specialize import Specialize, level_within
from stepid.diagnosis.selection.moves.split import Split
from stepid.diagnosis.selection.moves.twin import Twin
from stepid.diagnosis.selection.proposal import Node, related, standing
from stepid.effects import resolve
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.deviations import SCATTER
from stepid.fitting.fit import prepare
from stepid.fitting.multistart import FitContext, Start
from sticking_carts import campaign


def test_generalize_offers_what_contains_an_effect_from_where_it_stands() -> None:
    fit = prepared("friction")
    one = node(fit, FRICTION)
    found = Generalize().propose(one, context(fit))
    sound(Generalize(), one, found)
    assert set(sets(found)) == {(e.name,) for e in GENERAL if "coulomb_friction" in e.contains}
    assert all(p.left <= one.cost for p in found)
    assert Generalize().propose(node(fit), context(fit)) == []


def test_what_contains_a_lone_effect_starts_from_the_weak_form_too() -> None:
    """Grown from a level it keeps the damper that was fitted beside that, whose part it may take."""
    fit = prepared("friction")
    found = Generalize().propose(node(fit, FRICTION), context(fit))
    assert any(fit.weak_starts(proposal.effects[0], 3) for proposal in found)
    for proposal in found:
        (general,), known = proposal.effects, [start.values for start in proposal.starts]
        assert all(start.values in known for start in fit.weak_starts(general, 3))
    beside = node(fit, FRICTION | {"free_play": {"gap": 1e-4}})
    for proposal in Generalize().propose(beside, context(fit)):
        weak = [start.values for start in fit.weak_starts(proposal.effects[0], 3)]
        assert not any(start.values[:1] in weak for start in proposal.starts)


def test_specialize_offers_what_is_inside_at_the_same_level() -> None:
    fit = prepared("friction")
    uneven = node(fit, {"asymmetric_friction": {"level_forward": 0.15, "level_backward": 0.25}})
    found = Specialize().propose(uneven, context(fit))
    sound(Specialize(), uneven, found)
    assert sets(found) == [("coulomb_friction",)]
    (level,) = found[0].starts[0].values[0]
    assert level == pytest.approx(np.mean(standing(uneven).values[0]), rel=0.1)
    assert Specialize().propose(node(fit, FRICTION), context(fit)) == []


def test_specialize_starts_runs_where_the_plant_rests_without_what_the_simple_law_does_not() -> None:
    """Of two levels half the difference is a constant force, and moves every rest position by that over the spring."""
    fit = prepared("friction")
    uneven = node(fit, {"asymmetric_friction": {"level_forward": 0.15, "level_backward": 0.25}})
    forward, backward = standing(uneven).values[0]
    _, beside = Specialize().propose(uneven, context(fit))[0].starts
    assert beside.values[0][0] == pytest.approx((forward + backward) / 2, rel=0.1)
    stiffness = standing(uneven).linear[uneven.best.problem.layout.stiffness][fit.records.spring]
    assert beside.displacement is not None
    moved = beside.displacement - uneven.best.local[0]
    np.testing.assert_allclose(moved, (forward - backward) / 2 / stiffness, rtol=1e-6)


def test_a_power_of_the_speed_is_a_simple_law_where_their_forces_are_nearly_the_same() -> None:
    fit = prepared("power")  # 0.3 N and 40 N·s²/m²
    square = resolve(["quadratic_damping"])[0]
    near = at_power(fit, 40.0, 2.05)
    found = Specialize().propose(near, context(fit))
    sound(Specialize(), near, found)
    assert sets(found) == [(square.name,)]
    speed = np.abs(near.best.solved.states[1])
    expected = 40.0 * np.sum(speed**4.05) / np.sum(speed**4)
    assert found[0].starts[0].values[0][0] == pytest.approx(expected, rel=0.02)
    assert sets(Specialize().propose(at_power(fit, 0.4, 0.2), context(fit))) == [("coulomb_friction",)]
    assert Specialize().propose(at_power(fit, 2.0, 0.7), context(fit, alike=0.01)) == []


def at_power(fit: FitContext, coefficient: float, exponent: float) -> Node:
    """A node at these values as they are."""
    fitted = CandidateFit(fit, resolve(["power_damping"]))
    fitted.begin([Start(fit.coarse_linear.shared, ((coefficient, exponent),))], like=fit.coarse_linear, iterations=0)
    return Node(fitted)


def test_regeneralize_offers_the_other_general_laws_of_the_same_kin() -> None:
    fit = prepared("friction")
    stribeck = node(fit, {"stribeck_friction": EFFECTS["stribeck_friction"]})
    found = Regeneralize().propose(stribeck, context(fit))
    sound(Regeneralize(), stribeck, found)
    kin = {(e.name,) for e in GENERAL if "coulomb_friction" in e.contains}
    assert set(sets(found)) == kin - {("stribeck_friction",)}
    assert Regeneralize().propose(node(fit, FRICTION), context(fit)) == []


def test_a_level_inside_is_that_of_the_nearest_force_along_the_motion() -> None:
    fit = prepared("friction")
    uneven, coulomb, pair, own = resolve(
        ["asymmetric_friction", "coulomb_friction", "free_play", "presliding_hysteresis"]
    )
    there = node(fit, {uneven.name: {"level_forward": 0.15, "level_backward": 0.25}})
    assert level_within(there, 0, coulomb, context(fit)) == pytest.approx(np.mean(standing(there).values[0]), rel=0.1)
    falls = node(fit, {"stribeck_friction": {"level": 0.2, "breakaway": 0.0, "velocity": 0.01}})
    level, breakaway, _ = standing(falls).values[0]
    assert level_within(falls, 0, coulomb, context(fit)) == pytest.approx(level, rel=0.1)
    assert breakaway < 0.5 * level
    assert level_within(there, 0, pair, context(fit)) is None
    assert level_within(there, 0, uneven, context(fit)) is None
    built = node(fit, {own.name: {"level": 0.2, "distance": 1e-3}})  # with a memory
    assert level_within(built, 0, coulomb, context(fit)) == standing(built).values[0][0]


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
    assert sorted(sets(found)) == [("coulomb_friction",), ("quadratic_damping",), ("quadratic_damping",)]
    left = {p.effects[0].name: p.left for p in found}
    assert left["coulomb_friction"] < 0.2 * left["quadratic_damping"]


def test_friction_is_taken_away_with_the_starts_that_it_frees_and_without() -> None:
    fit = prepared("friction")
    two = node(fit, {"coulomb_friction": {"level": 0.2}, "quadratic_damping": {"coefficient": 1.0}})
    kept = {p.deviations for p in Drop().propose(two, context(fit)) if p.effects[0].name == "quadratic_damping"}
    assert kept == {frozenset(), frozenset({"start_offset"})}
    (alone,) = Drop().propose(node(fit, FRICTION), context(fit))
    assert alone.key == (frozenset(), frozenset({"start_offset"}))
    assert Drop().propose(node(fit, {"quadratic_damping": {"coefficient": 1.0}}), context(fit)) == []


def test_a_start_that_is_free_anyway_makes_no_second_set() -> None:
    fit = prepared("friction")
    fitted = CandidateFit(fit, resolve(("coulomb_friction", "quadratic_damping")), frozenset({"start_offset"}))
    fitted.begin([Start(fit.coarse_linear.shared, ((0.2,), (1.0,)))], like=fit.coarse_linear)
    sound(Drop(), Node(fitted), Drop().propose(Node(fitted), context(fit)))


def test_what_cannot_be_foreseen_without_an_effect_may_cost_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """An effect that the data leave open had kept the others at an end that no plant without it has."""
    fit = prepared("friction")
    two = node(fit, {"coulomb_friction": {"level": 0.2}, "quadratic_damping": {"coefficient": 1.0}})
    monkeypatch.setattr(drop, "without", lambda base, own, values: (base.shared, np.inf))
    assert {p.left for p in Drop().propose(two, context(fit))} == {two.cost}


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


def test_resemble_offers_a_sine_for_a_spring_that_softens_with_the_cube() -> None:
    """k (sin(a x)/a − x) = −k a² x³/6 + …: where a x stays small, a cubic with k₃ = −k a²/6 is the same force."""
    softens = {"coulomb_friction": {"level": 0.2}, "cubic_stiffness": {"coefficient": -3e4}}
    fit = prepare(noisy(softens))
    pair = node(fit, softens)
    found = Resemble().propose(pair, context(fit))
    sound(Resemble(), pair, found)
    assert sets(found)[0] == ("coulomb_friction", "sine_stiffness")
    stiffness = pair.best.shared[pair.best.problem.layout.stiffness][0]
    (level,), (curvature,) = found[0].starts[0].values
    assert level == pytest.approx(pair.best.shared[-2])
    assert curvature == pytest.approx(np.sqrt(-6 * pair.best.shared[-1] / stiffness), rel=0.2)
    assert Resemble().propose(pair, context(fit, alike=1e-9)) == []
    hardens = {"cubic_stiffness": {"coefficient": 1e5}}
    fit = prepare(noisy(hardens))
    assert ("sine_stiffness",) not in sets(Resemble().propose(node(fit, hardens), context(fit)))
    assert Resemble().propose(node(fit), context(fit)) == []


def test_what_is_no_force_on_a_known_motion_resembles_nothing() -> None:
    told = {e.name for e in (*SIMPLE, *GENERAL) if not is_force(e)}
    assert told == {
        "actuator_lag", "actuator_rate_limit", "actuator_dead_zone", "actuator_saturation", "input_delay",
        "sensor_drift", "viscoelastic_spring", "flexible_coupling", "presliding_hysteresis", "periodic_disturbance",
    }  # fmt: skip


def test_an_effect_is_wholly_like_itself() -> None:
    fit = prepared("two")
    cubic = node(fit, {"cubic_stiffness": {"coefficient": 2e4}})
    force = ForceAlong(cubic, 0, context(fit))
    found = force.by(cubic.effects[0].regressors(fit.scales, force.motion))
    assert found is not None
    assert found.left < 1e-12
    assert found.values[0] == pytest.approx((cubic.best.shared[-1],))
    np.testing.assert_allclose(force.beside(found)[0], standing(cubic).linear, rtol=1e-6)


def test_friction_of_two_laws_is_alike_where_runs_move_one_way() -> None:
    """Each is a force of its own in each run, and so is the spring's at each run's rest position."""
    fit = prepare(campaign(0))
    by_weight = node(fit, {"load_proportional_friction": {"coefficient": 0.01}})
    proposals = Resemble().propose(by_weight, context(fit))
    assert [p.effects[0].name for p in proposals] == ["coulomb_friction"]


def test_a_law_that_resembles_another_says_where_runs_begin() -> None:
    """Friction by weight holds each run at a place of its own: with one friction in all runs these places move."""
    fit = prepare(campaign(0))
    by_weight = node(fit, {"load_proportional_friction": {"coefficient": 0.01}})
    (proposal,) = Resemble().propose(by_weight, context(fit))
    start = proposal.starts[0]
    assert start.displacement is not None
    stiffness, ((level,),) = float(start.linear[1]), start.values
    gain = float(start.linear[by_weight.best.problem.layout.force_gain] - standing(by_weight).linear[-1])
    moved = stiffness * (start.displacement - by_weight.best.local[0])
    weight = 9.81 * by_weight.best.problem.layout.mass(by_weight.best.shared)
    volts = np.array([0.5 for _ in fit.records.runs])
    coefficient = standing(by_weight).values[0][0]
    pushed = level - coefficient * weight + moved - volts * gain  # the same force after the step, in each run
    assert np.ptp(pushed) < 0.05 * np.ptp(coefficient * weight)


def test_a_twin_is_a_law_that_no_motion_tells_apart() -> None:
    friction = prepared("friction")
    coulomb = node(friction, FRICTION)
    assert Twin().propose(coulomb, context(friction)) == []
    alike = [run.model_copy(update={"added_mass": 0.0}) for run in campaign(0).experiments]
    fit = prepare(stepid.Campaign(name="one mass", experiments=alike))
    found = Twin().propose(node(fit, FRICTION), context(fit))
    assert [p.effects[0].name for p in found] == ["load_proportional_friction"]


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


def test_split_keeps_what_stands_beside() -> None:
    fit = prepared("power")
    pair = node(fit, {"cubic_stiffness": {"coefficient": 1.0}, "power_damping": {"coefficient": 2.0, "exponent": 1.5}})
    found = Split().propose(pair, context(fit, alike=1.0))
    sound(Split(), pair, found)
    kept = standing(pair).values[0]
    for p in found:
        assert [p.effects[0].name, len(p.effects)] == ["cubic_stiffness", 3]
        assert p.effects[1].name in pair.effects[1].contains
        assert [start.values[0] for start in p.starts] == [kept]
    assert Split().propose(pair, context(fit, effects=2)) == []


def test_split_knows_friction_and_damping_in_stribeck_friction() -> None:
    fit = prepared("stribeck")
    general = node(fit, {"stribeck_friction": EFFECTS["stribeck_friction"]})
    found = Split().propose(general, context(fit, alike=1.0))
    sound(Split(), general, found)
    assert all(names[0] == "coulomb_friction" for names in sets(found))
