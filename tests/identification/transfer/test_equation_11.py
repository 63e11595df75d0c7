"""Eq. 11 through python-control, against the closed form of the second-order response."""

from __future__ import annotations

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

import stepid
from stepid.errors import IdentificationError, InputError
from stepid.identification.parameters import IdentifiedParameters
from stepid.identification.transfer import free_responses, held_response, transfer_function


def plant(m: float, c: float, k: float, gain: float | None = 0.03618) -> IdentifiedParameters:
    return IdentifiedParameters(
        masses={"run": m},
        stiffness={"medium": k},
        damping={"run": c},
        static_gain={} if gain is None else {"run": gain},
        springs={"run": "medium"},
    )


def step_closed_form(t: np.ndarray, m: float, c: float, k: float) -> np.ndarray:
    """Unit step response of 1/((m/k)s² + (c/k)s + 1) in every damping regime, 0 before the step."""
    t = np.maximum(t, 0.0)
    roots = np.roots([m, c, k]).astype(complex)
    if abs(roots[0] - roots[1]) < 1e-9 * abs(roots[0]):
        r = roots[0].real
        return 1 - np.exp(r * t) * (1 - r * t)
    a, b = roots
    return (1 - (b * np.exp(a * t) - a * np.exp(b * t)) / (b - a)).real


def test_coefficients_are_those_of_eq_11() -> None:
    system = transfer_function(plant(0.9538, 14.01, 216.2), "run")
    assert isinstance(system, control.TransferFunction)
    np.testing.assert_allclose(system.num_array[0, 0], [0.03618])
    np.testing.assert_allclose(system.den_array[0, 0], [0.9538 / 216.2, 14.01 / 216.2, 1.0])
    assert system.dcgain() == pytest.approx(0.03618, rel=1e-12)


def test_unknown_run_is_named() -> None:
    with pytest.raises(InputError, match=r"'case 9'.*'run'"):
        transfer_function(plant(1, 1, 100), "case 9")


def test_release_has_no_transfer_function() -> None:
    with pytest.raises(IdentificationError, match=r"'run' has no static gain.*voltage step"):
        transfer_function(plant(1, 1, 100, gain=None), "run")


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    m=st.floats(0.3, 4.0),
    ratio=st.floats(0.02, 2.0),
    k=st.floats(100.0, 900.0),
    level=st.sampled_from([-1.0, -0.5, 0.5, 3.0]),
    before=st.sampled_from([-0.5, 0.0, 0.5]),
    start=st.integers(0, 20),
)
def test_held_steps_match_the_closed_form(
    m: float, ratio: float, k: float, level: float, before: float, start: int
) -> None:
    c = 2 * ratio * np.sqrt(k * m)
    dt, n, back = 0.0088542, 300, 150
    t = dt * np.arange(n)
    u = np.where(np.arange(n) < start, before, level)
    u[back:] = before
    got = held_response(plant(m, c, k), "run", input=u, sample_time=dt, input_before=before)
    size = 0.03618 * (level - before)
    want = size * (step_closed_form(t - start * dt, m, c, k) - step_closed_form(t - back * dt, m, c, k))
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-9 * max(abs(size), 1e-3))


def test_held_input_is_not_drawn_as_a_ramp() -> None:
    dt, u = 0.0088542, np.full(100, 0.5)
    u[:10] = 0.0
    parameters = plant(0.9538, 14.01, 216.2)
    held = held_response(parameters, "run", input=u, sample_time=dt, input_before=0.0)
    ramped = control.forced_response(transfer_function(parameters, "run"), T=dt * np.arange(100), U=u).outputs
    assert held[10] == 0.0
    assert np.max(np.abs(held - ramped)) > 1e-4  # half a sample late: a third of a millimeter


def test_a_run_whose_name_has_a_dot_is_a_system_too() -> None:
    lab = stepid.datasets.lab_campaign()
    runs = [stepid.Experiment(**lab[name].model_dump() | {"name": f"{name}, 1.5 kg"}) for name in ("case 4", "case 5")]
    campaign = stepid.Campaign(name="dots", experiments=tuple(runs))
    found = stepid.identify(campaign)
    assert stepid.transfer_function(found, "case 4, 1.5 kg").name == "case 4, 1,5 kg"
    assert [run.name for run in stepid.verify(found, campaign).runs] == ["case 4, 1.5 kg", "case 5, 1.5 kg"]


def test_free_responses_of_a_run_that_was_not_identified_are_refused() -> None:
    with pytest.raises(InputError, match="'other'"):
        free_responses(plant(1.5, 4.0, 300.0), "other", samples=40, sample_time=0.005)


def test_free_responses_match_the_closed_form() -> None:
    m, c, k, dt = 1.5, 4.0, 300.0, 0.005
    t = dt * np.arange(400)
    decay = c / (2 * m)
    wd = np.sqrt(k / m - decay**2)
    got = free_responses(plant(m, c, k), "run", samples=400, sample_time=dt)
    envelope = np.exp(-decay * t)
    np.testing.assert_allclose(got[:, 0], envelope * (np.cos(wd * t) + decay / wd * np.sin(wd * t)), atol=1e-12)
    np.testing.assert_allclose(got[:, 1], envelope * np.sin(wd * t) / wd, atol=1e-12)


@pytest.mark.parametrize("way", ["held", "lines", "smooth"])
def test_the_response_is_exact_for_what_the_input_does_between_its_samples(way: str) -> None:
    dt, n = 0.0088542, 200
    t = dt * np.arange(n)
    u = 0.2 + 0.3 * np.sin(7 * t) + 0.1 * np.random.default_rng(2).standard_normal(n)
    found = plant(0.9538, 14.01, 216.2)
    got = held_response(found, "run", input=u, sample_time=dt, input_before=0.2, input_between=way)
    between = {
        "held": lambda s: u[np.minimum((s / dt + 1e-9).astype(int), n - 1)],
        "lines": lambda s: np.interp(s, t, u),
        "smooth": CubicSpline(t, u),
    }[way]
    parts = 1 if way == "lines" else 64
    fine = dt / parts * np.arange((n - 1) * parts + 1)
    if way == "held":
        system = control.sample_system(control.ss(transfer_function(found, "run")), dt / parts, method="zoh")
        want = control.forced_response(system, U=between(fine) - 0.2).outputs
    else:
        want = control.forced_response(transfer_function(found, "run"), T=fine, U=between(fine) - 0.2).outputs
    np.testing.assert_allclose(got, want[::parts], rtol=0, atol=1e-6 if way == "smooth" else 1e-12)


@pytest.mark.parametrize("way", ["lines", "smooth"])
def test_any_system_follows_an_input_that_is_not_held(way: str) -> None:
    rng = np.random.default_rng(4)
    lab = stepid.datasets.lab_campaign()["case 4"]
    fields = {"input": np.cumsum(0.02 * rng.standard_normal(lab.time.size)), "input_between": way}
    run = stepid.Experiment(**lab.model_dump() | fields)
    model = stepid.PlantModel(
        base_mass={run.base: 1.0}, stiffness={run.spring: 216.0}, damping={run.damper: 6.0}, force_gain=7.8
    )
    wanted = stepid.simulate(model, stepid.Campaign(name="one", experiments=(run,)))[run.name]
    linear = stepid.simulate_system(stepid.state_space(model, run), run).outputs
    assert np.ptp(linear - wanted) < 1e-7 * np.ptp(wanted)
    sampled = control.sample_system(stepid.state_space(model, run), run.sample_time, method="zoh")
    with pytest.raises(InputError, match="is not held"):
        stepid.simulate_system(sampled, run)
    system = stepid.nonlinear_system(model, run)
    if way == "smooth":
        with pytest.raises(InputError, match="is smooth"):
            stepid.simulate_system(system, run)
    else:
        assert np.ptp(stepid.simulate_system(system, run).outputs - wanted) < 1e-6 * np.ptp(wanted)
