"""`stepid.simulate`: what it refuses, and an effect defined outside the package."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stepid
from stepid.effects import CATALOGUE, Effect, Moment, Parameter, Scales
from stepid.effects.base import Values
from stepid.errors import ConvergenceError, InputError

PERIOD, MASS, STIFFNESS, DAMPING, GAIN, DRAG = 0.01, 1.0, 216.0, 4.0, 7.8, 300.0


class CubicDamping(Effect):
    """Damping that grows with the cube of the velocity: not in the catalogue."""

    name = "cubic_damping"
    parameters = (Parameter("coefficient", "N·s³/m³"),)
    law = "−c₃ v³"
    seen: ClassVar[str] = "the first swing shrinks far more than the second"
    advice: ClassVar[str] = "take smaller steps"

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.damping / scales.velocity**2,) for share in (0.1, 1.0)]

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * m.v**3


def run_of(added: float, volts: float, *, noise: np.ndarray | None = None, drag: float = DRAG) -> stepid.Experiment:
    """A step up and back with cubic damping, integrated by scipy."""
    inputs = np.repeat([0.0, volts, 0.0], [5, 120, 95])
    time = PERIOD * np.arange(inputs.size)
    state, position = np.zeros(2), np.zeros(inputs.size)
    for i in range(inputs.size - 1):

        def rates(_: float, y: np.ndarray, u: float = float(inputs[i])) -> list[float]:
            return [y[1], (GAIN * u - STIFFNESS * y[0] - DAMPING * y[1] - drag * y[1] ** 3) / (MASS + added)]

        state = solve_ivp(rates, (0, PERIOD), state, rtol=1e-10, atol=1e-13).y[:, -1]
        position[i + 1] = state[0]
    return stepid.Experiment(
        name=f"{added:g} kg, {volts:g} V",
        time=time,
        position=position if noise is None else position + noise[: time.size],
        input=inputs,
        added_mass=added,
        spring="medium",
        damper="plug",
    )


def model_of(*effects: stepid.EffectModel, **changes: object) -> stepid.PlantModel:
    plain = stepid.PlantModel(
        base_mass={"cart": MASS}, stiffness={"medium": STIFFNESS}, damping={"plug": DAMPING}, force_gain=GAIN
    )
    return plain.model_copy(update={"effects": effects, **changes})


@pytest.fixture(scope="module")
def damped() -> stepid.Campaign:
    rng = np.random.default_rng(11)
    cases = ((0.0, 0.5), (0.5, 0.5), (1.5, -0.5), (1.0, 0.25))
    runs = [run_of(added, volts, noise=2e-5 * rng.standard_normal(220)) for added, volts in cases]
    return stepid.Campaign(name="cubic damping", experiments=tuple(runs))


def test_an_effect_from_outside_is_simulated() -> None:
    one = stepid.Campaign(name="one", experiments=(run_of(0.5, 0.5),))
    model = model_of(stepid.EffectModel(name="cubic_damping", values={"coefficient": DRAG}))
    ours = stepid.simulate(model, one, catalogue=(*CATALOGUE, CubicDamping()))
    exact = one.experiments[0].position
    plain = stepid.simulate(model_of(), one)["0.5 kg, 0.5 V"]
    assert np.abs(plain - exact).max() > 1e-4
    # the model has no state of the run: its rest position is read off the record
    np.testing.assert_allclose(ours["0.5 kg, 0.5 V"], exact, rtol=0, atol=2e-8)


@pytest.mark.parametrize("by_name", [True, False])
def test_an_effect_from_outside_is_fitted(damped: stepid.Campaign, by_name: bool) -> None:
    wanted = "cubic_damping" if by_name else CubicDamping()
    found = stepid.fit(damped, effects=(wanted,), catalogue=(*CATALOGUE, CubicDamping()))
    estimate = found.parameters["cubic_damping.coefficient"]
    assert estimate.unit == "N·s³/m³"
    assert estimate.uncertainty is not None
    assert abs(estimate.value - DRAG) < 4 * estimate.uncertainty
    assert found.rms == pytest.approx(2e-5, rel=0.1)
    assert stepid.fit(damped).rms > 3 * found.rms


def test_an_effect_from_outside_is_named(damped: stepid.Campaign) -> None:
    found = stepid.diagnose(damped, catalogue=(*CATALOGUE, CubicDamping()))
    assert found.verdict == "named"
    assert found.effects == ("cubic_damping",)
    assert found.gap.after < 1.1 * found.gap.noise
    assert "cubic damping" in found.summary()
    assert "cubic damping: take smaller steps." in found.summary()


def test_an_effect_that_is_not_in_the_catalogue_is_refused(damped: stepid.Campaign) -> None:
    model = model_of(stepid.EffectModel(name="cubic_damping", values={"coefficient": DRAG}))
    with pytest.raises(InputError, match=r"no effect called 'cubic_damping'.*The catalogue has"):
        stepid.simulate(model, damped)


@pytest.mark.parametrize(
    ("field", "what"), [("base_mass", "base mass"), ("stiffness", "stiffness"), ("damping", "damping")]
)
def test_a_missing_label_is_named(damped: stepid.Campaign, field: str, what: str) -> None:
    with pytest.raises(InputError, match=rf"no {what} for the label .*It knows: other"):
        stepid.simulate(model_of(**{field: {"other": 1.0}}), damped)


def test_a_missing_parameter_is_named(damped: stepid.Campaign) -> None:
    model = model_of(stepid.EffectModel(name="stribeck_friction", values={"level": 0.2, "velocity": 0.01}))
    with pytest.raises(InputError, match=r"stribeck_friction has no breakaway.*in N"):
        stepid.simulate(model, damped)


def test_a_softening_spring_that_runs_away_is_said_to(damped: stepid.Campaign) -> None:
    model = model_of(stepid.EffectModel(name="cubic_stiffness", values={"coefficient": -3e6}))
    with pytest.raises(ConvergenceError, match=r"'cubic damping' runs away.*softening spring"):
        stepid.simulate(model, damped)


def test_models_go_to_json_and_back() -> None:
    model = model_of(
        stepid.EffectModel(name="periodic_disturbance", values={"amplitude": 0.1, "frequency": 5.0}),
        runs={"a": stepid.RunState(rest=1e-3, velocity=0.1, phases={"periodic_disturbance.phase": 0.5})},
    )
    assert stepid.PlantModel.model_validate_json(model.model_dump_json()) == model


def test_play_under_a_held_input_rests_against_the_spring() -> None:
    """The spring pulls only beyond the gap: x = K_f u/k + gap, whose search starts where nothing pulls at all."""
    gap, level, rest = 0.002, 0.2, 0.01
    volts = np.full(40, level)
    run = stepid.Experiment(
        name="held",
        time=np.arange(40) * PERIOD,
        position=np.zeros(40),
        input=volts,
        input_before=level,
        added_mass=0.0,
        spring="medium",
        damper="plug",
    )
    model = stepid.PlantModel(
        base_mass={run.base: MASS},
        stiffness={"medium": STIFFNESS},
        damping={"plug": DAMPING},
        force_gain=GAIN,
        effects=(stepid.EffectModel(name="free_play", values={"gap": gap}),),
        runs={"held": stepid.RunState(rest=rest)},
    )
    moved = stepid.simulate(model, stepid.Campaign(name="held", experiments=(run,)))["held"]
    np.testing.assert_allclose(moved, rest + GAIN * level / STIFFNESS + gap, atol=1e-12)


class RisingFriction(Effect):
    """Dry friction that grows with speed; it does not say where Coulomb friction inside it leads."""

    name = "rising_friction"
    parameters = (Parameter("level", "N"), Parameter("rise", "N·s²/m²"))
    law = "−(F_c + r v²) sign(v)"
    contains = ("coulomb_friction",)
    dry: ClassVar[bool] = True
    reverses: ClassVar[bool] = True
    rests_anywhere: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.02 * scales.force, share * scales.force / scales.velocity**2) for share in (0.01, 0.1)]

    @staticmethod
    def friction(p: Values, m: Moment) -> float:
        return p[0] + p[1] * m.v**2


def test_a_general_law_from_outside_need_not_say_where_it_grows_from() -> None:
    found = stepid.diagnose(stepid.datasets.lab_campaign(), catalogue=(*CATALOGUE, RisingFriction()))
    assert found.effects == ("coulomb_friction",)


class PowerDamping(CubicDamping):
    """Damping by any power of the velocity; the simpler law inside it need not be in the catalogue."""

    name = "power_damping"
    parameters = (Parameter("coefficient", "N·s³/m³"), Parameter("power", "", 1.0))
    law = "−c |v|^(p−1) v"
    contains = ("cubic_damping",)

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(share * scales.damping / scales.velocity**2, 2.8) for share in (0.1, 1.0)]

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * abs(m.v) ** (p[1] - 1) * m.v


@pytest.mark.parametrize("inner", [(), (CubicDamping(),)])
def test_a_law_from_outside_may_contain_another(damped: stepid.Campaign, inner: tuple[Effect, ...]) -> None:
    found = stepid.diagnose(damped, catalogue=(*CATALOGUE, *inner, PowerDamping()))
    assert found.verdict == "named"
    assert found.effects == (("cubic_damping",) if inner else ("power_damping",))
