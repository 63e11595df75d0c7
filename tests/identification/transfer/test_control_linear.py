"""Transfer functions and state spaces of identified, fitted and diagnosed plants."""

from __future__ import annotations

import control
import numpy as np
import pytest

import control_example as example
import diagnosis_example
import stepid
from stepid.effects import CATALOGUE
from stepid.errors import IdentificationError, InputError
from stepid.identification.transfer import free_responses
from stepid.identification.transfer.express import why_not_linear, why_not_nonlinear
from stepid.identification.transfer.linear import sampled

LINEAR = ("viscoelastic_spring", "flexible_coupling", "actuator_lag")
FREQUENCIES = np.geomspace(0.1, 1000.0, 60)


def response(system: control.LTI) -> np.ndarray:
    return np.asarray(system(1j * FREQUENCIES))


def test_which_effects_are_linear() -> None:
    assert {e.name for e in CATALOGUE if why_not_linear(e) is None} == set(LINEAR)
    for effect in CATALOGUE:  # what a linear system expresses, a nonlinear one does
        assert why_not_linear(effect) is not None or why_not_nonlinear(effect) is None


def test_a_model_gives_eq_11() -> None:
    run = example.step_run()
    g = stepid.transfer_function(example.model(), run)
    assert isinstance(g, control.TransferFunction)
    np.testing.assert_allclose(g.num_array[0, 0], [7.8 / 216.0], rtol=1e-12)
    np.testing.assert_allclose(g.den_array[0, 0], [1.5 / 216.0, 4.0 / 216.0, 1.0], rtol=1e-12)
    assert (g.name, g.input_labels, g.output_labels) == ("steps", ["voltage"], ["position"])


def test_a_state_space_has_displacement_and_velocity() -> None:
    g = stepid.state_space(example.model(), example.step_run())
    assert isinstance(g, control.StateSpace)
    assert g.state_labels == ["displacement", "velocity"]
    np.testing.assert_allclose(g.A, [[0, 1], [-216.0 / 1.5, -4.0 / 1.5]], rtol=1e-14)
    np.testing.assert_allclose(g.B, [[0], [7.8 / 1.5]], rtol=1e-14)
    np.testing.assert_array_equal(g.C, [[1, 0]])


def test_identified_parameters_give_the_same_system_both_ways() -> None:
    found = stepid.identify(diagnosis_example.campaign())
    for name in found.masses:
        g, s = stepid.transfer_function(found, name), stepid.state_space(found, name)
        np.testing.assert_allclose(response(s), response(g), rtol=1e-10)
        assert s.dcgain() == pytest.approx(found.static_gain[name], rel=1e-12)
    run = diagnosis_example.campaign()["case 4"]
    assert repr(stepid.transfer_function(found, run)) == repr(stepid.transfer_function(found, "case 4"))


def test_a_diagnosis_gives_its_linear_plant() -> None:
    d, campaign = diagnosis_example.named(), diagnosis_example.campaign()
    run = campaign["case 7"]
    g = stepid.transfer_function(d.linear_model, run)
    k = d.linear_parameters["stiffness[medium]"].value
    assert g.dcgain() == pytest.approx(d.linear_parameters["force_gain"].value / k, rel=1e-12)
    held = stepid.simulate_system(g, run)
    wanted = stepid.simulate(d.linear_model, campaign)["case 7"] - d.linear_model.runs["case 7"].rest
    np.testing.assert_allclose(held.outputs, wanted, atol=1e-9)


@pytest.mark.parametrize("name", LINEAR)
@pytest.mark.parametrize("run", [example.step_run(input_before=0.2), example.release_run()], ids=lambda r: r.name)
def test_linear_effects_are_reproduced(name: str, run: stepid.Experiment) -> None:
    model = example.model(name)
    s, g = stepid.state_space(model, run), stepid.transfer_function(model, run)
    got = stepid.simulate_system(s, run, initial_state=stepid.initial_state(model, run))
    wanted = example.simulated(model, run) - example.REST
    np.testing.assert_allclose(got.outputs, wanted, atol=1e-12)
    assert got.state_labels[:2] == ["displacement", "velocity"]
    np.testing.assert_allclose(response(g), response(s), rtol=1e-9)
    assert g.den_array[0, 0][-1] == 1.0
    assert len(g.den_array[0, 0]) == s.nstates + 1


def test_all_linear_effects_together() -> None:
    run, model = example.step_run(), example.model(*LINEAR)
    s, g = stepid.state_space(model, run), stepid.transfer_function(model, run)
    assert s.nstates == 6
    np.testing.assert_allclose(response(g), response(s), rtol=1e-8)
    got = stepid.simulate_system(s, run)
    np.testing.assert_allclose(got.outputs + example.REST, example.simulated(model, run), atol=1e-12)


def test_the_hold_is_exact_where_controls_own_interpolation_is_not() -> None:
    run, model = example.step_run(), example.model()
    g = stepid.transfer_function(model, run)
    wanted = example.simulated(model, run) - example.REST
    np.testing.assert_allclose(stepid.simulate_system(g, run).outputs, wanted, atol=1e-12)
    ramped = control.forced_response(g, run.time - run.time[0], run.input).outputs
    assert np.abs(ramped - wanted).max() > 1e-3
    sampled = control.sample_system(control.ss(g), run.sample_time, method="zoh")
    np.testing.assert_allclose(stepid.simulate_system(sampled, run).outputs, wanted, atol=1e-12)


@pytest.mark.parametrize("name", [e.name for e in CATALOGUE if e.name not in LINEAR])
def test_what_is_not_linear_is_refused_with_the_reason(name: str) -> None:
    effect = next(e for e in CATALOGUE if e.name == name)
    reason = why_not_linear(effect)
    assert reason
    for make in (stepid.transfer_function, stepid.state_space):
        with pytest.raises(InputError, match="a linear system cannot express") as caught:
            make(example.model(name), example.step_run())
        assert f"{name} ({reason})" in str(caught.value)


def test_a_run_without_a_step_has_no_gain() -> None:
    found = stepid.IdentifiedParameters(
        masses={"run": 1.0}, stiffness={"m": 200.0}, damping={"run": 4.0}, springs={"run": "m"}
    )
    for make in (stepid.transfer_function, stepid.state_space):
        with pytest.raises(IdentificationError, match="'run' has no static gain"):
            make(found, "run")
    with pytest.raises(InputError, match=r"campaign\['steps'\]"):
        stepid.state_space(example.model(), "steps")


def test_sampling_keeps_what_passes_straight_through() -> None:
    """Of an input that is a polynomial, what passes through at a sample is its value there: the first coefficient."""
    plant = control.ss([[-2.0]], [[3.0]], [[1.0]], [[5.0]])
    found = sampled(plant, 0.1, 2)
    np.testing.assert_allclose(found.D, [[5.0, 0.0]])
    np.testing.assert_allclose(found.A, [[np.exp(-0.2)]])
    held = 1.5 * (1 - np.exp(-0.2))  # ∫ 3 e^(−2s) ds, and of a slope of one ∫ 3 (0.1 − s) e^(−2s) ds
    np.testing.assert_allclose(found.B, [[held, 1.5 * 0.1 - held / 2]])


def test_free_responses_are_the_closed_form() -> None:
    m, c, k = 2.0, 6.0, 300.0
    given = stepid.IdentifiedParameters(
        masses={"a": m}, damping={"a": c}, stiffness={"s": k}, static_gain={"a": 0.03}, springs={"a": "s"}
    )
    t, decay = 0.01 * np.arange(100), c / (2 * m)
    w = np.sqrt(k / m - decay**2)
    found = free_responses(given, "a", samples=100, sample_time=0.01)
    moved = np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    np.testing.assert_allclose(found, np.column_stack([moved, np.exp(-decay * t) * np.sin(w * t) / w]), atol=1e-12)
