"""A law of any shape: it takes what a hidden law of its state leaves, and nothing of noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hidden.campaigns import Request, make_campaigns
from stepid.diagnosis.free_forces import memories
from stepid.diagnosis.free_law import FreeLaw, free_laws
from stepid.diagnosis.states import states_of
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext


def hidden(effects: tuple[str, ...], outside: str | None = None, seed: int = 3) -> FitContext:
    made = make_campaigns([Request(seed, effects, outside, 8.0 if effects else None, "four")])
    return prepare(made[0][0])


def free_law(context: FitContext, optimum: Optimum) -> FreeLaw:
    """The law that takes most."""
    return max(free_laws(context, optimum), key=lambda law: law.power)


@pytest.mark.parametrize(
    ("effect", "state"),
    [
        ("cubic_stiffness", "position"),
        ("quadratic_damping", "velocity"),
        ("coulomb_friction", "velocity"),
        ("position_dependent_damping", "position and velocity"),
    ],
)
def test_it_takes_what_a_law_of_its_state_makes(effect: str, state: str) -> None:
    context = hidden((effect,))
    every = free_laws(context, context.linear)  # of input or time one is alike in steps of a size
    alone = [law for law in every if not {"input", "time"} & law.states]
    law = max(alone, key=lambda one: one.power)
    assert law.state == state
    assert law.share > 0.6  # one linearized step
    assert law.power == pytest.approx(law.share * (context.coarse_linear.cost - context.noise_cost), rel=0.1)


def test_nothing_is_left_to_it_beside_the_true_law() -> None:
    context = hidden(("cubic_stiffness",))
    fitted = fit_effects(context, resolve(["cubic_stiffness"]))
    assert fitted is not None
    law = free_law(context, fitted)
    assert law.power < 1e-3 * (context.coarse_linear.cost - context.noise_cost)


def test_of_noise_it_takes_what_chance_takes() -> None:
    """Over many campaigns the deviates are those of a standard normal variable."""
    made = make_campaigns([Request(seed, (), None, None, "four") for seed in range(40, 60)])
    found = []
    for campaign, _ in made:
        context = prepare(campaign)
        found += [law.beyond for law in free_laws(context, context.linear)]
    assert abs(np.mean(found)) < 0.5
    assert 0.7 < np.std(found) < 1.4
    assert np.max(found) < 4.0


def test_a_wrong_law_as_small_as_the_noise_is_seen() -> None:
    made = make_campaigns([Request(4, (), "viscous_pad", 2.5, "four")])
    context = prepare(made[0][0])
    fitted = fit_effects(context, resolve(["position_dependent_damping"]))
    assert fitted is not None
    assert fitted.rms < 1.15 * context.floor
    law = max(free_laws(context, fitted), key=lambda one: one.beyond)
    assert (law.states, law.beyond > 5) == ({"position", "velocity"}, True)


@pytest.mark.parametrize(
    ("effect", "state"), [("viscoelastic_spring", "the position's past"), ("actuator_lag", "the input's past")]
)
def test_a_memory_takes_what_a_law_of_the_past_makes(effect: str, state: str) -> None:
    context = hidden((effect,))
    every = free_laws(context, context.linear)
    law = next(law for law in every if law.state == state)
    assert law.share > 0.8
    assert law.beyond > 5
    fitted = fit_effects(context, resolve([effect]))
    assert fitted is not None
    assert next(law for law in free_laws(context, fitted) if law.state == state).beyond < 3


def test_a_memory_follows_changes_and_forgets_them() -> None:
    """After a step each force fades at its own rate, the fastest within samples, the slowest hardly."""
    context = hidden(("cubic_stiffness",))
    records = context.records
    forces = memories(records, records.volts)
    piece = next(p for p in records.pieces() if np.ptp(records.volts[p]) > 0)
    step = int(np.argmax(np.abs(np.diff(records.volts[piece])))) + 1
    size = np.diff(records.volts[piece])[step - 1]
    for force in forces:
        assert np.all(force[piece][:step] == 0)
        assert force[piece][step] == pytest.approx(size)
    after = [abs(force[piece][step + 20] / size) for force in forces]
    assert np.all(np.diff(after) > 0)
    assert after[0] == pytest.approx(np.exp(-20 / 2.0), rel=0.02)


@pytest.mark.parametrize(("outside", "seen"), [("square_wave", True), (None, False)])
def test_overtones_tell_a_wave_of_another_shape(outside: str | None, seen: bool) -> None:
    effects = () if outside else ("periodic_disturbance",)
    made = make_campaigns([Request(4, effects, outside, 5.0, "four")])
    context = prepare(made[0][0])
    fitted = fit_effects(context, resolve(["periodic_disturbance"]))
    assert fitted is not None
    assert fitted.rms < 1.05 * context.floor
    law = next(law for law in free_laws(context, fitted) if law.own)
    assert (law.state, law.beyond > 5) == ("time", seen)


def test_a_force_of_time_is_no_law_of_a_state() -> None:
    context = hidden(("periodic_disturbance",))
    assert free_law(context, context.linear).share < 0.5


def test_it_sees_that_a_spring_has_another_shape() -> None:
    context = hidden((), "log_spring")
    fitted = fit_effects(context, resolve(["cubic_stiffness"]))
    assert fitted is not None
    law = free_law(context, fitted)
    assert (law.state, law.share > 0.5) == ("position", True)


def test_beside_the_law_that_is_there_nothing_is_left_of_what_stood_in_for_it() -> None:
    context = hidden((), "fringe_field")
    fitted = fit_effects(context, resolve(["cubic_stiffness"]))
    assert fitted is not None
    law = free_law(context, fitted)
    assert law.states == {"position", "input"}
    assert law.share > 0.9
    assert law.changes == pytest.approx((-1.0,), abs=0.2)


def test_beside_a_law_that_is_there_an_effect_that_is_there_stays() -> None:
    made = make_campaigns([Request(5, ("coulomb_friction",), "log_spring", 20.0, "four")])
    context = prepare(made[0][0])
    fitted = fit_effects(context, resolve(["coulomb_friction"]))
    assert fitted is not None
    law = next(law for law in free_laws(context, fitted) if law.state == "position")
    assert law.beyond > 5
    assert law.changes == pytest.approx((0.0,), abs=0.3)


@pytest.mark.parametrize(
    ("outside", "states"),
    [
        ("thermal_spring", {"position", "time"}),
        ("fading_drive", {"input", "time"}),
        ("damper_warming", {"velocity", "time"}),
    ],
)
def test_it_sees_what_changes_in_time(outside: str, states: set[str]) -> None:
    context = hidden((), outside)
    law = free_law(context, context.linear)
    assert (law.states, law.share > 0.8) == (states, True)


def test_it_sees_that_a_damping_changes_otherwise_along_the_way() -> None:
    context = hidden((), "bowl_damping", seed=1)
    fitted = fit_effects(context, resolve(["position_dependent_damping"]))
    assert fitted is not None
    law = free_law(context, fitted)
    assert (law.states, law.share > 0.5) == ({"position", "velocity"}, True)


@pytest.mark.parametrize(
    ("effect", "states"),
    [
        ("end_stop", {"position"}),
        ("free_play", {"position"}),
        ("cogging", {"position"}),
        ("stribeck_friction", {"velocity"}),
        ("load_proportional_friction", {"velocity"}),
        ("position_dependent_damping", {"position", "velocity"}),
        ("presliding_hysteresis", set()),  # of the way there
        ("periodic_disturbance", set()),
        ("actuator_dead_zone", set()),
    ],
)
def test_the_states_that_an_effect_is_a_law_of(effect: str, states: set[str]) -> None:
    context = hidden(("cubic_stiffness",))
    (one,) = resolve([effect])
    for values in one.starts(context.scales):
        assert states_of(context, one, tuple(values)) == states


def test_a_plant_that_runs_away_leaves_nothing() -> None:
    context = hidden(("cubic_stiffness",))
    fitted = fit_effects(context, resolve(["cubic_stiffness"]))
    assert fitted is not None
    away = fitted.shared.copy()
    away[-1] = -1e12 * np.abs(away[-1])
    assert free_law(context, replace(fitted, shared=away)).power == 0.0


def test_the_laws_of_a_fit_are_asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    context = hidden(("cubic_stiffness",))
    found = free_laws(context, context.linear)
    monkeypatch.setattr("stepid.diagnosis.free_law.responses_along", None)
    assert free_laws(context, context.linear) is found
    with pytest.raises(TypeError):
        free_laws(context, replace(context.linear))
