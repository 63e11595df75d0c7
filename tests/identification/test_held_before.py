"""Records that begin at rest under a level of the input that was held before them: steps back, in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.core.held_before import all_held_before, held_before

TIME = 0.005 * np.arange(900)
STIFFNESS, DAMPING, GAIN, VOLTS = 250.0, 4.0, 5.0, 0.6


def swing(added: float, since: np.ndarray) -> np.ndarray:
    """Step response of a damped plant, of its own size at the end."""
    mass = 1.0 + added
    decay = DAMPING / (2 * mass)
    rate = np.sqrt(STIFFNESS / mass - decay**2)
    since = np.maximum(since, 0.0)
    out: np.ndarray = 1.0 - np.exp(-decay * since) * (np.cos(rate * since) + decay / rate * np.sin(rate * since))
    return out


def back(added: float, lead: int, *, off: bool = False, seed: int = 0) -> stepid.Experiment:
    """A step back to nothing after so many samples; where the amplifier is `off`, nothing moves before a step up."""
    size = GAIN * VOLTS / STIFFNESS
    u = np.where(np.arange(TIME.size) < lead, VOLTS, 0.0)
    y = size * (1.0 - swing(added, TIME - TIME[lead]))
    if off:
        u[lead + 100 : lead + 300] = VOLTS
        y = size * (swing(added, TIME - TIME[lead + 100]) - swing(added, TIME - TIME[lead + 300]))
    noise = 2e-6 * np.random.default_rng(seed).standard_normal(TIME.size)
    return stepid.Experiment(
        name=f"{added:g} kg", time=TIME, position=y + noise, input=u, added_mass=added, spring="s", damper="d"
    )


def campaign(lead: int) -> stepid.Campaign:
    runs = [back(added, lead, seed=i) for i, added in enumerate((0.0, 0.5, 1.0))]
    return stepid.Campaign(name="back", experiments=runs)


@pytest.mark.parametrize("lead", [1, 4, 10, 20, 80])
def test_a_step_back_is_one_from_rest_under_the_level_before(lead: int) -> None:
    """However short that level is in the record: it had been a step of its own, 2 mm beside the readings."""
    whole = campaign(lead)
    found = stepid.fit(whole)
    assert found.rms == pytest.approx(2e-6, rel=0.1)
    for name, true in (("base_mass", 1.0), ("stiffness[s]", STIFFNESS), ("force_gain", GAIN)):
        assert abs(found.parameters[name].value - true) < 3 * found.parameters[name].uncertainty
    (note,) = (note for note in found.notes if "at rest under" in note)
    assert note == (
        "Runs '0 kg', '0.5 kg' and '1 kg' begin at rest under 0.6 V: their inputs had that level before the record."
    )
    assert not any("amplifier" in note for note in found.notes)


@pytest.mark.parametrize("lead", [10, 20, 80])
def test_the_peak_method_reads_it(lead: int) -> None:
    found = stepid.identify(campaign(lead))
    assert found.excluded == {}
    assert found.base_mass["cart"] == pytest.approx(1.0, rel=5e-3)
    assert found.stiffness["s"] == pytest.approx(STIFFNESS, rel=5e-3)
    assert all(gain == pytest.approx(GAIN / STIFFNESS, rel=1e-3) for gain in found.static_gain.values())
    assert sum("begin at rest under 0.6 V" in note for note in found.notes) == 1


@pytest.mark.parametrize("lead", [10, 80])
@pytest.mark.parametrize("zero", [0.0, -0.012])
def test_an_input_that_was_measured_was_held_before_too(lead: int, zero: float) -> None:
    """With noise of its own, a zero that is off, and a hum on the readings: 1.4 mm of 12 had been left."""
    runs = []
    for i, run in enumerate(campaign(lead).experiments):
        noise = 1e-4 * np.random.default_rng(9 + i).standard_normal(TIME.size)
        u = np.asarray(run.input) * (1 - zero / VOLTS) + zero + noise
        y = np.asarray(run.position) + 1e-5 * np.sin(2 * np.pi * 60 * TIME + i)
        runs.append(run.model_copy(update={"input": u, "position": y}))
    found = stepid.fit(stepid.Campaign(name="measured", experiments=runs))
    assert found.rms == pytest.approx(2e-6, rel=0.2)
    assert found.parameters["stiffness[s]"].value == pytest.approx(STIFFNESS, rel=1e-3)
    assert sum("begin at rest under 0.6 V" in note for note in found.notes) == 1


@pytest.mark.parametrize("zero", [0.02, -0.01])
def test_a_zero_of_the_input_that_is_off_is_no_step(zero: float) -> None:
    """An input that was read 20 mV too high had been a dead zone of 20 mV, with 95 %."""
    lead, runs = 60, []
    for i, added in enumerate((0.0, 0.5, 1.0)):
        u = np.where(np.arange(TIME.size) < lead, 0.0, VOLTS) + zero
        y = GAIN * VOLTS / STIFFNESS * swing(added, TIME - TIME[lead])
        noise = 2e-6 * np.random.default_rng(i).standard_normal(TIME.size)
        named = {"name": f"{added:g} kg", "spring": "s", "damper": "d"}
        runs.append(stepid.Experiment(time=TIME, position=y + noise, input=u, added_mass=added, **named))
    assert all(held_before(run).input_before == pytest.approx(zero) for run in runs)
    found = stepid.fit(stepid.Campaign(name="off", experiments=runs))
    assert found.rms == pytest.approx(2e-6, rel=0.1)
    assert found.parameters["force_gain"].value == pytest.approx(GAIN, rel=1e-3)


def test_an_amplifier_that_was_off_is_no_rest_under_its_level() -> None:
    """The cart is where it rests without an input."""
    run = back(0.0, 100, off=True)
    assert held_before(run) is run


def test_what_a_record_says_stays() -> None:
    run = back(0.0, 40)
    told = run.model_copy(update={"input_before": VOLTS})
    moving = run.model_copy(update={"starts": "motion"})
    assert held_before(told) is told
    assert held_before(moving) is moving
    assert held_before(run).input_before == VOLTS
    assert all_held_before([run, told])[1] == [
        "Run '0 kg' begins at rest under 0.6 V: its input had that level before the record."
    ]


@pytest.mark.parametrize("hold", [3, 40, 200])
def test_a_pulse_from_rest_returns(hold: int) -> None:
    """It ends where it began, under the input that it began under."""
    u = np.where(np.arange(TIME.size) < hold, VOLTS, 0.0)
    y = GAIN * VOLTS / STIFFNESS * (swing(0.5, TIME) - swing(0.5, TIME - TIME[hold]))
    run = stepid.Experiment(name="p", time=TIME, position=y, input=u, added_mass=0.5, spring="s", damper="d")
    assert held_before(run) is run


def test_a_record_that_ends_before_it_can_tell_stays() -> None:
    run = back(0.0, 40)
    cut = {name: getattr(run, name)[:60] for name in ("time", "position", "input")}
    short = run.model_copy(update=cut)
    assert held_before(short) is short


@pytest.mark.parametrize(("first", "then"), [(0.4, (1.0,)), (1.0, (-1.0,)), (0.4, (0.7, 1.0)), (0.3, (0.9, 0.3, 0.9))])
def test_a_step_from_one_level_to_another_was_held_at_the_first(first: float, then: tuple[float, ...]) -> None:
    """From 0.4 to 1 V had been a dead zone of 0.4 V, with a gain that was 29 per cent too small."""
    runs = [stairs(added, first, then) for added in (0.0, 0.5, 1.0)]
    assert all(held_before(run).input_before == first for run in runs)
    found = stepid.fit(stepid.Campaign(name="bias", experiments=runs))
    assert found.rms == pytest.approx(2e-6, rel=0.1)
    assert found.parameters["force_gain"].value == pytest.approx(GAIN, rel=2e-3)
    (note,) = (note for note in found.notes if f"begin at rest under {first:g} V" in note)
    assert ("friction" in note) == (then == (1.0,))  # what is stronger moves it once it has moved it back


@pytest.mark.parametrize("zone", [0.25, 0.35])
def test_a_first_level_too_weak_to_move_the_cart_was_not_held_before(zone: float) -> None:
    """It rests where neither level would hold it by what the later ones say."""
    run = stairs(0.5, 0.2, (0.6, 1.0), zone=zone)
    assert held_before(run) is run


def stairs(added: float, first: float, then: tuple[float, ...], *, zone: float = 0.0) -> stepid.Experiment:
    """At rest under a first level, or with a dead `zone` [V] without it, then 1.5 s at each of others."""
    lead, each = 40, 300
    time = 0.005 * np.arange(lead + each * len(then))
    levels = [first, *then]
    u = np.repeat(levels, [lead] + [each] * len(then))
    acts = np.array([np.sign(level) * max(abs(level) - zone, 0.0) for level in levels])
    starts = 0.005 * (lead + each * np.arange(len(then)))
    y = GAIN / STIFFNESS * sum(c * swing(added, time - at) for c, at in zip(np.diff(acts), starts, strict=True))
    noise = 2e-6 * np.random.default_rng(5).standard_normal(time.size)
    return stepid.Experiment(
        name=f"{added:g} kg", time=time, position=y + noise, input=u, added_mass=added, spring="s", damper="d"
    )


@pytest.mark.parametrize("edge", [0.1, 0.5, 0.9])
def test_a_record_that_is_triggered_by_the_edge_of_a_step_begins_under_nothing(edge: float) -> None:
    """The first sample lies on the edge, and the cart has moved by the next: no rest under it, with 43 mm off."""
    runs = []
    for added in (0.0, 0.5, 1.0):
        u = np.full(TIME.size, VOLTS)
        u[0] = edge * VOLTS
        y = GAIN / STIFFNESS * (u[0] * swing(added, TIME) + (VOLTS - u[0]) * swing(added, TIME - TIME[1]))
        noise = 2e-6 * np.random.default_rng(1).standard_normal(TIME.size)
        named = {"name": f"{added:g} kg", "spring": "s", "damper": "d"}
        runs.append(stepid.Experiment(time=TIME, position=y + noise, input=u, added_mass=added, **named))
    assert all(held_before(run) is run for run in runs)
    found = stepid.fit(stepid.Campaign(name="edge", experiments=runs))
    assert found.rms == pytest.approx(2e-6, rel=0.1)
    assert found.parameters["force_gain"].value == pytest.approx(GAIN, rel=1e-3)
