"""Effects as python-control nonlinear systems: each reproduces `stepid.simulate`, or is refused with the reason."""

from __future__ import annotations

from typing import ClassVar

import control
import numpy as np
import pytest

import control_example as example
import stepid
from stepid.effects import CATALOGUE, Effect, Moment, Parameter
from stepid.errors import ConvergenceError, InputError
from stepid.identification.transfer.express import why_not_nonlinear

DRY = {"coulomb_friction", "load_proportional_friction", "stribeck_friction", "asymmetric_friction"}
EXPRESSED = [effect.name for effect in CATALOGUE if why_not_nonlinear(effect) is None]
CLOSE = 1e-6  # of full scale


def off(model: stepid.PlantModel, run: stepid.Experiment) -> float:
    """Largest difference between the exported system and `stepid.simulate`, over the full scale."""
    wanted = example.simulated(model, run)
    system = stepid.nonlinear_system(model, run)
    got = stepid.simulate_system(system, run, initial_state=stepid.initial_state(model, run))
    np.testing.assert_allclose(got.time, run.time - run.time[0], atol=1e-12)
    assert np.ptp(wanted) > 0.02
    return float(np.abs(got.outputs - wanted).max() / np.ptp(wanted))


def test_every_effect_is_either_expressed_or_refused() -> None:
    refused = {effect.name for effect in CATALOGUE} - set(EXPRESSED)
    assert refused == DRY | {"input_delay", "actuator_rate_limit"}
    assert len(EXPRESSED) == 17
    assert set(example.VALUES) == {effect.name for effect in CATALOGUE}


def test_the_plain_plant_is_reproduced() -> None:
    run = example.step_run(input_before=0.2)
    assert off(example.model(), run) < 1e-12


@pytest.mark.parametrize("name", EXPRESSED)
def test_an_effect_is_reproduced(name: str, record_property: pytest.RecordProperty) -> None:
    model, run = example.model(name), example.step_run(input_before=0.0 if name == "free_play" else 0.2)
    plain = example.simulated(example.model(), run)
    assert np.abs(example.simulated(model, run) - plain).max() > 1e-3 * np.ptp(plain)  # strong enough to be missed
    figure = off(model, run)
    record_property("off", figure)
    assert figure < CLOSE


@pytest.mark.parametrize("name", ["viscoelastic_spring", "presliding_hysteresis", "cogging", "periodic_disturbance"])
def test_a_release_is_reproduced(name: str) -> None:
    assert off(example.model(name), example.release_run()) < CLOSE


def test_effects_together_are_reproduced() -> None:
    model = example.model("cubic_stiffness", "actuator_saturation", "actuator_lag", "presliding_hysteresis")
    assert off(model, example.step_run()) < CLOSE
    assert stepid.nonlinear_system(model, example.step_run()).state_labels == [
        "displacement",
        "velocity",
        "actuator_lag.1",
        "presliding_hysteresis.1",
    ]


def test_a_release_that_a_hand_holds_begins_where_it_is_free() -> None:
    model, run = example.model("quadratic_damping"), example.release_run(held=20)
    wanted = example.simulated(model, run)
    system = stepid.nonlinear_system(model, run)
    got = stepid.simulate_system(system, run, initial_state=stepid.initial_state(model, run))
    assert got.time[0] > 19 * example.PERIOD
    np.testing.assert_allclose(got.outputs, wanted[-got.time.size :], atol=CLOSE * np.ptp(wanted))


def test_an_oracle_written_out_by_hand() -> None:
    run, name = example.step_run(), "cubic_stiffness"
    m, c, k, gain, cubic = 1.5, 4.0, 216.0, 7.8, example.VALUES[name][0]
    by_hand = control.nlsys(
        lambda t, x, u, params: [x[1], (gain * u[0] - k * x[0] - c * x[1] - cubic * x[0] ** 3) / m],
        lambda t, x, u, params: [x[0] + example.REST],
        inputs=1,
        outputs=1,
        states=2,
    )
    wanted = stepid.simulate_system(by_hand, run).outputs
    got = stepid.simulate_system(stepid.nonlinear_system(example.model(name), run), run).outputs
    np.testing.assert_allclose(got, wanted, atol=1e-9 * np.ptp(wanted))


def test_controls_own_simulation_from_change_to_change() -> None:
    """Without the helper: `control.input_output_response` where the input is constant."""
    model, run = example.model("cubic_stiffness"), example.step_run()
    system = stepid.nonlinear_system(model, run)
    first, last = 5, 79
    time = run.time[first : last + 1] - run.time[0]
    got = control.input_output_response(
        system, time, np.ones(time.size), [0.0, 0.0], solve_ivp_kwargs={"rtol": 1e-10, "atol": 1e-13}
    )
    wanted = example.simulated(model, run)[first : last + 1]
    np.testing.assert_allclose(got.outputs, wanted, atol=CLOSE * np.ptp(wanted))


def test_parameters_can_be_changed_at_the_simulation() -> None:
    run = example.step_run()
    system = stepid.nonlinear_system(example.model("cubic_stiffness"), run)
    assert system.params["mass"] == 1.5
    assert system.params["cubic_stiffness.coefficient"] == 4e4
    time, volts = np.linspace(0, 0.5, 100), np.ones(100)
    options = {"solve_ivp_kwargs": {"rtol": 1e-9, "atol": 1e-12}}
    without = control.input_output_response(
        system, time, volts, params={"cubic_stiffness.coefficient": 0.0, "rest": 0.0}, **options
    )
    linear = control.forced_response(stepid.state_space(example.model(), run), time, volts)
    np.testing.assert_allclose(without.outputs, linear.outputs, atol=1e-8)


def test_a_linearization_is_the_linear_plant() -> None:
    run = example.step_run()
    system = stepid.nonlinear_system(example.model("cubic_stiffness"), run)
    near = control.linearize(system, [0.0, 0.0], [0.0])
    np.testing.assert_allclose(near.A, stepid.state_space(example.model(), run).A, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("name", sorted(DRY | {"input_delay", "actuator_rate_limit"}))
def test_what_cannot_be_expressed_is_refused_with_the_reason(name: str) -> None:
    others = {
        "input_delay": "a delay needs the input's past",
        "actuator_rate_limit": "its state is known in closed form",
    }
    reason = others.get(name, "dry friction holds the cart at rest")
    with pytest.raises(InputError, match=rf"cannot express {name} \({reason}.*stepid.simulate expresses every effect"):
        stepid.nonlinear_system(example.model("cubic_stiffness", name), example.step_run())


class _Outside(Effect):
    """Not in the catalogue: damping that grows with the cube of the velocity."""

    name = "cubic_damping"
    parameters = (Parameter("coefficient", "N·s³/m³"),)

    @staticmethod
    def force(p: tuple[float, ...], m: Moment) -> float:
        return -p[0] * m.v**3


class _Remembers(_Outside):
    name = "remembers"
    n_memory: ClassVar[int] = 1


def test_an_effect_from_outside_is_expressed() -> None:
    catalogue = (*CATALOGUE, _Outside())
    run = example.step_run()
    model = example.model().model_copy(
        update={"effects": (stepid.EffectModel(name="cubic_damping", values={"coefficient": 100.0}),)}
    )
    wanted = stepid.simulate(model, stepid.Campaign(name="one", experiments=(run,)), catalogue=catalogue)["steps"]
    system = stepid.nonlinear_system(model, run, catalogue=catalogue)
    np.testing.assert_allclose(stepid.simulate_system(system, run).outputs, wanted, atol=CLOSE * np.ptp(wanted))


def test_a_memory_without_rates_is_refused() -> None:
    model = example.model().model_copy(
        update={"effects": (stepid.EffectModel(name="remembers", values={"coefficient": 1.0}),)}
    )
    with pytest.raises(InputError, match="its memory follows the path"):
        stepid.nonlinear_system(model, example.step_run(), catalogue=(*CATALOGUE, _Remembers()))


def test_a_runaway_is_said_to_be_one() -> None:
    model = example.model().model_copy(
        update={"effects": (stepid.EffectModel(name="cubic_stiffness", values={"coefficient": -3e6}),)}
    )
    run = example.step_run()
    with pytest.raises(ConvergenceError, match="'steps' runs away"):
        stepid.simulate_system(stepid.nonlinear_system(model, run), run)


def test_a_name_is_not_enough_for_a_model() -> None:
    with pytest.raises(InputError, match=r"does not know the labels.*campaign\['steps'\]"):
        stepid.nonlinear_system(example.model(), "steps")  # type: ignore[arg-type]


def test_a_missing_label_is_named() -> None:
    run = stepid.Experiment.from_dict(example.step_run().to_dict() | {"spring": "stiff"})
    with pytest.raises(InputError, match="no stiffness for the label 'stiff'"):
        stepid.nonlinear_system(example.model(), run)


def test_what_does_not_fit_the_run_is_refused() -> None:
    run = example.step_run(input_before=0.2)
    system = stepid.nonlinear_system(example.model(), run)
    with pytest.raises(InputError, match=r"rests under 0\.2 V.*initial_state"):
        stepid.simulate_system(system, run)
    with pytest.raises(InputError, match=r"has 3 values, system 'steps' has 2 states.*displacement, velocity"):
        stepid.simulate_system(system, run, initial_state=[0.0, 0.0, 0.0])
    with pytest.raises(InputError, match=r"initial_state is no array of numbers"):
        stepid.simulate_system(system, run, initial_state=["a", "b"])
    with pytest.raises(InputError, match=r"initial_state has values that are not finite"):
        stepid.simulate_system(system, run, initial_state=[np.nan, 0.0])
    with pytest.raises(InputError, match=r"transfer function, which has no states.*state_space"):
        stepid.simulate_system(stepid.transfer_function(example.model(), run), run, initial_state=[0.0, 0.0])
    with pytest.raises(InputError, match="has 2 inputs, a run has one"):
        stepid.simulate_system(control.ss([[-1.0]], [[1.0, 1.0]], [[1.0]], [[0.0, 0.0]]), run)
    with pytest.raises(InputError, match=r"sample time 0\.5 s"):
        stepid.simulate_system(control.tf([1.0], [1.0, 0.5], dt=0.5), run)
