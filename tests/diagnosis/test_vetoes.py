"""What must not be named: what a linear parameter can imitate, and what the data do not determine."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stepid
from broken_campaigns import FRICTION, campaign, changed
from stepid.diagnosis import vetoes
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.explore import linear_candidate
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.vetoes import barred, imitators, open_parameters, swing, undetermined
from stepid.effects import CATALOGUE, resolve
from stepid.effects.base import Effect
from stepid.effects.swing import Swing
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects

SWING = Swing(
    rates=(10.0, 14.0),
    decays=(2.0, 3.0),
    masses=(2.0, 1.0),
    displacement=0.02,
    duration=4.0,
    resolution=0.1,
    pitch=1.0,
    fast=0.05,
    slow=20.0,
    swings=1.0,
)
OWN = "the plant's own oscillation"
CASES: dict[str, list[tuple[tuple[float, ...], str]]] = {
    "periodic_disturbance": [
        ((0.1, 10.5 / (2 * math.pi), 0.0), OWN),
        ((0.1, 12.0 / (2 * math.pi), 0.0), ""),
    ],
    "viscoelastic_spring": [
        ((10.0, 30.0), "the stiffness of the spring"),
        ((1000.0, 2.0), "the damper"),
        ((100.0, 10.0), ""),
    ],
    "power_damping": [((4.0, 1.1), "the damper"), ((4.0, 0.5), ""), ((4.0, 1.5), "")],
    "flexible_coupling": [
        ((0.005, 0.005 * 14.5**2, 0.1), OWN),  # of 0.005 of the mass the rates are 7 % apart
        ((0.02, 0.02 * 14.0**2, 0.1), ""),  # and 14 %
        ((0.005, 0.005 * 30.0**2, 0.1), ""),
    ],
}


def turned(damper: str) -> stepid.Campaign:
    """A campaign with friction whose damper has this label."""
    made = campaign(1, FRICTION, masses=(0.0, 0.5, 1.5))
    for run in range(len(made.experiments)):
        made = changed(made, run, damper=damper)
    return made


def test_every_effect_that_imitates_has_its_cases() -> None:
    assert {e.name for e in CATALOGUE if type(e).imitates is not Effect.imitates} == set(CASES)
    assert resolve(["coulomb_friction"])[0].imitates((0.1,), SWING) == ""


@pytest.mark.parametrize(("name", "values", "what"), [(n, v, w) for n, cases in CASES.items() for v, w in cases])
def test_what_an_effect_imitates(name: str, values: tuple[float, ...], what: str) -> None:
    assert resolve([name])[0].imitates(values, SWING) == what


@pytest.mark.parametrize(
    ("rate", "decay", "seen"),
    [
        (10.5, 0.1, False),  # a third of a beat in 4 s
        (11.7, 0.1, True),  # more than one
        (10.0, 1.5, False),
        (10.0, 1.6, True),  # what lasts longer than the plant's own oscillation is not it
    ],
)
def test_a_disturbance_has_to_beat_with_the_plants_own_oscillation_or_to_outlast_it(
    rate: float, decay: float, seen: bool
) -> None:
    values = 0.1, rate / (2 * math.pi), 0.0
    (shaker,) = resolve(["periodic_disturbance"])
    assert shaker.unseen(values, SWING._replace(rates=(10.0, 10.2), decays=(decay, decay))) == ("" if seen else OWN)
    assert shaker.unseen(values, SWING._replace(decays=(decay, decay))) == ""  # no plant of two masses swings as one


@pytest.mark.parametrize(("pitch", "what"), [(0.021, "a spring that bends"), (0.019, "")])
def test_a_pitch_has_to_repeat_on_a_side_of_rest(pitch: float, what: str) -> None:
    """However well it fits: two springs, of which one slackens, had been a pitch of three times the travel."""
    (cogging,) = resolve(["cogging"])
    assert cogging.unseen((0.1, pitch, 0.0), SWING) == what


@pytest.mark.parametrize(
    ("rate", "decay", "over"),
    [
        (20.3, 0.05, True),  # 0.19 of a period late after 4 s
        (29.8, 0.05, True),
        (20.5, 0.05, False),
        (20.1, 0.2, False),  # an overtone of what decays is not steady
        (40.0, 0.05, False),
    ],
)
def test_a_steady_line_in_step_with_a_steady_swing_is_its_overtone(rate: float, decay: float, over: bool) -> None:
    """Of a ball on a gas spring, which the gas keeps swinging, 5.137 Hz had been named: twice its own 2.568."""
    (shaker,) = resolve(["periodic_disturbance"])
    steady = SWING._replace(rates=(10.0, 10.0), decays=(decay, decay))
    said = shaker.unseen((0.1, rate / (2 * math.pi), 0.0), steady)
    assert said == ("an overtone of the plant's own oscillation" if over else "")
    assert shaker.unseen((0.1, rate / (2 * math.pi), 0.0), steady._replace(rates=(10.0, 14.0))) == ""


def test_parts_of_one_recording_tell_rates_apart_as_the_whole_does() -> None:
    """33 s of 3.33 rad/s each: two periods had been 11 per cent of a part, and are 4 of the whole."""
    fit = prepare(pohls_wheel(seed=0))
    assert vetoes.swing(fit, stepid.Criteria(), linear_candidate(fit)).resolution == stepid.Criteria().resolution


def test_friction_and_a_bent_spring_are_no_shaker() -> None:
    """Three parts of 33 s: a sine 0.6 per cent off the plant's own rate had left as little."""
    d = stepid.diagnose(pohls_wheel(seed=0))
    found = [set(names) for names in (d.effects, *d.alternatives)]
    assert {"coulomb_friction", "cubic_stiffness"} in found
    assert not any("periodic_disturbance" in names for names in found)


def pohls_wheel(seed: int) -> stepid.Campaign:
    """A wheel on a spring that hardens, with dry friction, let go and read at 10 Hz to 0.01."""
    time = 0.1 * np.arange(1001)

    def moved(_: float, state: np.ndarray) -> list[float]:
        x, v = state
        return [v, -11.08 * x - 0.0104 * x**3 - 0.0016 * v - 0.0412 * math.tanh(v / 0.01)]

    solved = solve_ivp(moved, (0.0, 100.0), (2.49, 0.0), t_eval=time, rtol=1e-8, atol=1e-10, max_step=0.02)
    read = np.round(solved.y[0] + 3e-3 * np.random.default_rng(seed).standard_normal(time.size), 2)
    whole = stepid.Experiment(
        name="wheel",
        time=time,
        position=read,
        input=np.zeros(time.size),
        added_mass=0.0,
        spring="coil",
        damper="air",
        starts="motion",
    )
    parts = tuple(whole.slice(a, b, name=f"part {a}") for a, b in ((0, 334), (334, 667), (667, 1001)))
    return stepid.Campaign(name="wheel", experiments=parts)


def test_less_than_a_period_is_no_disturbance_however_well_it_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    """A linear parameter is no other answer at the floor; a rest position that shifts is one there, too."""
    slow, own = (0.1, 0.2, 0.0), (0.1, 10.5 / (2 * math.pi), 0.0)
    effects = resolve(["periodic_disturbance"])
    assert effects[0].unseen(slow, SWING) == "a slow shift of the rest position"
    assert effects[0].unseen(own, SWING) == ""
    monkeypatch.setattr(vetoes, "swing", lambda *_: SWING)
    monkeypatch.setattr(vetoes, "undetermined", lambda *_: ())
    for noise in (True, False):
        monkeypatch.setattr(vetoes, "_leaves_noise", lambda *_, noise=noise: noise)
        said = [set(imitators(None, Criteria(), at(effects, values)).values()) for values in (slow, own)]  # type: ignore[arg-type]
        assert said == [{"a slow shift of the rest position"}, set() if noise else {OWN}]


def test_two_masses_on_springs_have_the_rates_of_their_matrices() -> None:
    """However near their rates alone are; told apart where they differ by a tenth of the plant's own."""
    for mass, of, rate, alone in ((1.0, 1.0, 10.0, 10.0), (0.01, 1.0, 10.0, 10.05), (0.3, 2.0, 14.0, 5.0)):
        springs = np.array([[of * rate**2 + mass * alone**2, -mass * alone**2], [-mass * alone**2, mass * alone**2]])
        low, high = np.sqrt(np.linalg.eigvals(np.diag([1 / of, 1 / mass]) @ springs).real[[0, 1]])
        apart = float(abs(high - low) / rate)
        swing = SWING._replace(rates=(rate,), masses=(of,))
        for share, told in ((0.999, True), (1.001, False)):
            assert swing._replace(resolution=share * apart).splits(mass, mass * alone**2) is told


def test_a_mode_that_does_not_swing_once_within_the_records_is_none() -> None:
    effect = resolve(["flexible_coupling"])[0]
    for swings, words in ((0.9, "a slow shift of the rest position"), (1.1, "")):
        rate = 2 * math.pi * swings / SWING.duration
        assert effect.unseen((0.3, 0.3 * rate**2, 0.1), SWING) == words


def at(effects: tuple[Effect, ...], values: tuple[float, ...]) -> Candidate:
    """A candidate of one effect at these values."""
    layout = SimpleNamespace(values=(slice(0, len(values)),))
    optimum: Any = SimpleNamespace(problem=SimpleNamespace(layout=layout), shared=np.array(values))
    return Candidate(effects, frozenset(), optimum, 0.0)


def test_a_campaigns_swing() -> None:
    context = prepare(campaign(1, masses=(0.0, 0.5, 1.5)))
    how = swing(context, Criteria(), linear_candidate(context))
    assert how.rates == pytest.approx([math.sqrt(216 / (0.95 + m)) for m in (0.0, 0.5, 1.5)], rel=0.01)
    assert how.displacement == pytest.approx(0.03, rel=0.3)
    assert how.resolution == pytest.approx(4 * math.pi / (how.duration * min(how.rates)), rel=0.01)
    assert how.near(how.rates[0])
    assert not how.near(10 * how.rates[0])


def test_a_record_of_less_than_two_periods_tells_no_rate_unless_all_are_as_short() -> None:
    whole = campaign(1, masses=(0.0, 0.5, 1.5))
    context = prepare(whole)
    how = swing(context, Criteria(), linear_candidate(context))

    def cut(periods: float, runs: int) -> float:
        end = periods * 2 * math.pi / how.rates[0] + 0.2
        some = []
        for i, run in enumerate(whole.experiments):
            part = slice(int(np.searchsorted(run.time, end)) if i < runs else None)
            own = {name: getattr(run, name)[part] for name in ("time", "position", "input")}
            some.append(run.model_copy(update=own))
        fit = prepare(stepid.Campaign(name="cut", experiments=tuple(some)))
        return swing(fit, Criteria(), linear_candidate(fit)).resolution

    assert cut(1.5, 1) == pytest.approx(how.resolution, rel=0.05)
    assert cut(2.5, 1) > 1.1 * how.resolution
    assert cut(1.2, 3) > 1


def test_a_fitted_friction_imitates_nothing_and_is_determined() -> None:
    context = prepare(campaign(1, FRICTION, masses=(0.0, 0.5, 1.5)))
    effects = resolve(["coulomb_friction"])
    optimum = fit_effects(context, effects)
    assert optimum is not None
    found = Candidate(effects, frozenset(), optimum, 0.0)
    assert imitators(context, Criteria(), found) == {}
    assert undetermined(context, Criteria(), found) == ()
    assert undetermined(context, Criteria(open=1e-6), found) == ("coulomb_friction.level",)
    assert open_parameters(context, Criteria(), found) == ()
    assert not barred(context, Criteria(), found)


def test_what_is_open_or_imitated_is_barred(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vetoes, "at_floor", lambda *_: False)  # beside a rest curvature alone tells
    for open_ in ((), ("coulomb_friction.level",)):
        for imitated in ({}, {"coulomb_friction": "the damper"}):
            monkeypatch.setattr(vetoes, "undetermined", lambda *_, names=open_: names)
            monkeypatch.setattr(vetoes, "imitators", lambda *_, said=imitated: said)
            found = Candidate(resolve(["coulomb_friction"]), frozenset(), None, 0.0)  # type: ignore[arg-type]
            assert open_parameters(None, Criteria(), found) == open_  # type: ignore[arg-type]
            assert barred(None, Criteria(), found) is bool(open_ or imitated)  # type: ignore[arg-type]


def test_a_damper_that_is_not_determined_is_no_effect_whatever_its_label() -> None:
    context = prepare(turned("0.5 turn"))
    effects = resolve(["coulomb_friction"])
    optimum = fit_effects(context, effects)
    assert optimum is not None
    found = Candidate(effects, frozenset(), optimum, 0.0)
    assert undetermined(context, Criteria(open=1e-6), found) == ("coulomb_friction.level",)


def test_an_effect_that_is_not_there_is_open_and_its_angles_do_not_count() -> None:
    context = prepare(campaign(1, masses=(0.0, 0.5, 1.5)))
    effects = resolve(["cogging"])
    optimum = fit_effects(context, effects)
    assert optimum is not None
    open_ = undetermined(context, Criteria(open=0.01), Candidate(effects, frozenset(), optimum, 0.0))
    assert "cogging.amplitude" in open_
    assert "cogging.phase" not in open_
    assert np.isfinite(optimum.cost)
