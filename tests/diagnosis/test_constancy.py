"""An effect is the same in all conditions, or it is not that effect: what repeats differ by is none of its."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy.linalg import expm

import stepid
from broken_campaigns import COUNTS, MASSES, NOISE, SAMPLE_TIME, inputs
from hidden.campaigns import Request, make_campaigns
from scattered_campaigns import scattered
from stepid.diagnosis.constancy import CONDITIONS, conditions_of
from stepid.diagnosis.free_law import FreeLaw, free_laws
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.multistart import FitContext

TABLE, BENCH, DASHPOT = 6.0, 6.0 * (2 * np.pi * 9.0) ** 2, 6.0  # of a rail on a table: kg, N/m, N·s/m


def on_a_table(mass: float, volts: float, rng: np.random.Generator) -> stepid.Experiment:
    """A cart that pushes its own rail, which stands on a springy table; the encoder rides on the rail. Exact."""
    k, c, gain, base = 216.0, 4.0, 7.8, 0.95
    m = base + mass
    # relative to the rail: m (y + z)″ = f, M z″ = −f − K z − C z′, f = gain u − k y − c y′
    a = np.zeros((4, 4))
    a[0, 2] = a[1, 3] = 1.0
    a[3] = np.array([k, -BENCH, c, -DASHPOT]) / TABLE
    a[2] = np.array([-k, 0.0, -c, 0.0]) / m - a[3]
    b = np.array([0.0, 0.0, gain / m + gain / TABLE, -gain / TABLE])
    whole = np.zeros((5, 5))
    whole[:4, :4], whole[:4, 4] = a, b
    step = expm(whole * SAMPLE_TIME)
    u, state, x = inputs(volts), np.zeros(4), []
    for value in u:
        x.append(state[0])
        state = step[:4, :4] @ state + step[:4, 4] * value
    y = np.array(x) + NOISE * rng.standard_normal(u.size)
    return stepid.Experiment(
        name=f"{mass} kg, {volts} V",
        time=SAMPLE_TIME * np.arange(u.size),
        position=np.round(y * COUNTS) / COUNTS,
        input=u,
        added_mass=mass,
        spring="medium",
        damper="half",
        counts_per_meter=COUNTS,
    )


def law_of(context: FitContext, *names: str) -> FreeLaw:
    fitted = fit_effects(context, resolve(names))
    assert fitted is not None
    return next(law for law in free_laws(context, fitted) if law.state == CONDITIONS)


@functools.cache
def table() -> FitContext:
    rng = np.random.default_rng(1)
    runs = tuple(on_a_table(mass, volts, rng) for mass in MASSES for volts in (0.5, 0.3))
    return prepare(stepid.Campaign(name="on a table", experiments=runs))


def test_a_mode_that_moves_with_the_added_mass_is_no_second_mass_on_the_cart() -> None:
    law = law_of(table(), "flexible_coupling")
    assert law.own
    assert law.beyond > 5
    assert law.share > 0.5


def test_with_two_runs_of_one_mass_and_input_there_is_one_condition_for_each_pair() -> None:
    made = make_campaigns([Request(3, ("cubic_stiffness",), None, 8.0, "four")])
    first, *others = made[0][0].experiments
    again = first.model_copy(update={"name": "again", "position": first.position + 1e-9})
    context = prepare(stepid.Campaign(name="twice", experiments=(first, *others, again)))
    found = conditions_of(context.records)
    assert found[0] == found[-1]
    assert np.unique(found).size == len(others) + 1


def test_releases_of_one_mass_are_one_condition_however_long() -> None:
    made = make_campaigns([Request(3, ("coulomb_friction",), None, 8.0, "release")])
    records = prepare(made[0][0]).records
    assert not records.driven.any()
    for i, number in enumerate(conditions_of(records)):
        alike = np.flatnonzero(conditions_of(records) == number)
        assert set(alike) == set(np.flatnonzero(records.added_mass == records.added_mass[i]))


@pytest.mark.parametrize("effect", ["cubic_stiffness", "flexible_coupling", "quadratic_damping"])
def test_true_effects_are_the_same_in_all_conditions(effect: str) -> None:
    """Over some campaigns the deviates are those of a standard normal variable."""
    made = make_campaigns([Request(seed, (effect,), None, 8.0, "four") for seed in range(60, 70)])
    found = np.array([law_of(prepare(campaign), effect).beyond for campaign, _ in made])
    assert abs(found.mean()) < 0.9
    assert 0.4 < found.std() < 1.7
    assert found.max() < 3.5


def test_gains_that_scatter_are_no_change_of_an_effect() -> None:
    """Runs of other masses differ in gain, as repeats would."""
    campaign = scattered(3, gain=(0.03, -0.02, 0.015, -0.03, 0.02, -0.015), level=0.4)
    fitted = fit_effects(context := prepare(campaign), resolve(["coulomb_friction"]))
    assert fitted is not None
    assert fitted.rms > 1.5 * context.floor
    law = next(law for law in free_laws(context, fitted) if law.state == CONDITIONS)
    assert law.power == 0.0  # nothing is left to a level of friction of each run


def test_runs_of_one_condition_ask_nothing() -> None:
    made = make_campaigns([Request(3, ("cubic_stiffness",), None, 8.0, "four")])
    first = made[0][0].experiments[0]
    rng = np.random.default_rng(2)
    repeats = [
        first.model_copy(
            update={"name": f"repeat {i}", "position": first.position + 1e-5 * rng.standard_normal(first.time.size)}
        )
        for i in range(3)
    ]
    context = prepare(stepid.Campaign(name="repeats", experiments=tuple(repeats)))
    assert all(law.state != CONDITIONS for law in free_laws(context, context.linear))


def test_inputs_that_are_measured_make_no_conditions_of_their_own() -> None:
    """What is read of one step differs by a thousandth: with that each run had been free in all of an effect."""
    made = make_campaigns([Request(3, ("cubic_stiffness",), None, 8.0, "four")])
    first, *others = made[0][0].experiments
    read = first.input + 1e-3 * np.ptp(first.input) * np.random.default_rng(3).standard_normal(first.input.size)
    again = first.model_copy(update={"name": "again", "position": first.position + 1e-9, "input": read})
    larger = first.model_copy(update={"name": "larger", "position": first.position * 1.1, "input": 1.1 * first.input})
    records = prepare(stepid.Campaign(name="read", experiments=(first, *others, again, larger))).records
    number = {run.name: n for run, n in zip(records.runs, conditions_of(records), strict=True)}
    assert number[first.name] == number["again"] != number["larger"]
