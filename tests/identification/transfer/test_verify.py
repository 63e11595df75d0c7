"""Verification responses against the closed form of the second-order response."""

from __future__ import annotations

import math

import control
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stepid
from stepid.errors import IdentificationError, InputError
from stepid.identification.transfer.verify import fit_percent

Array = npt.NDArray[np.float64]
T = 0.0088542
GAIN = 0.036


def swing(t: Array, m: float, c: float, k: float) -> Array:
    """Underdamped unit step response, 0 before the step."""
    decay, after = c / (2 * m), np.maximum(t, 0.0)
    wd = math.sqrt(k / m - decay**2)
    return 1 - np.exp(-decay * after) * (np.cos(wd * after) + decay / wd * np.sin(wd * after))


def parameters(m: float, c: float, k: float, name: str = "case 4", **more: object) -> stepid.IdentifiedParameters:
    return stepid.IdentifiedParameters(
        masses={name: m}, damping={name: c}, stiffness={"medium": k}, static_gain={name: GAIN}, springs={name: "medium"}
        , **more,
    )  # fmt: skip


def experiment(position: Array, u: Array, *, before: float = 0.0, name: str = "case 4") -> stepid.Experiment:
    return stepid.Experiment(
        name=name,
        time=3.0 + T * np.arange(position.size),
        position=position,
        input=u,
        input_before=before,
        added_mass=0.0,
        spring="medium",
        damper="1/2 turn",
    )


def one_step(
    m: float, c: float, k: float, *, start: int = 5, size: float = 0.5, before: float = 0.0, rest: float = 0.0
) -> stepid.Experiment:
    n = 600
    u = np.where(np.arange(n) < start, before, before + size)
    return experiment(rest + GAIN * size * swing(T * (np.arange(n) - start), m, c, k), u, before=before)


def campaign(*experiments: stepid.Experiment) -> stepid.Campaign:
    return stepid.Campaign(name="closed form", experiments=experiments)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    m=st.floats(0.4, 3.5),
    ratio=st.floats(0.1, 0.6),
    k=st.floats(150.0, 800.0),
    start=st.integers(0, 30),
    size=st.sampled_from([-0.5, 0.5, 1.5]),
    before=st.sampled_from([-0.5, 0.0, 1.0]),
    rest=st.floats(-0.02, 0.02),
)
def test_linear_data_are_met_to_1e_9(
    m: float, ratio: float, k: float, start: int, size: float, before: float, rest: float
) -> None:
    c = 2 * ratio * math.sqrt(k * m)
    record = one_step(m, c, k, start=start, size=size, before=before, rest=rest)
    run = stepid.verify(parameters(m, c, k), campaign(record))["case 4"]
    np.testing.assert_allclose(run.simulated, record.position, rtol=0, atol=1e-9 * abs(size) * GAIN)
    assert run.fit_percent == pytest.approx(100.0, abs=1e-6)
    assert run.rms < 1e-9 * abs(size) * GAIN
    np.testing.assert_array_equal(run.measured, record.position)
    np.testing.assert_array_equal(run.time, record.time)


def test_python_control_answers_the_same() -> None:
    m, c, k = 0.9538, 14.01, 216.2
    identified = parameters(m, c, k)
    record = one_step(m, c, k, start=0)
    run = stepid.verify(identified, campaign(record))["case 4"]
    # a step that is there from time 0 is the one input that forced_response does not turn into a ramp
    system = stepid.transfer_function(identified, "case 4")
    oracle = control.forced_response(system, T=T * np.arange(600), U=np.full(600, 0.5)).outputs
    np.testing.assert_allclose(run.simulated, oracle, rtol=0, atol=1e-9 * 0.5 * GAIN)


def test_step_and_step_back() -> None:
    m, c, k, n = 1.5, 6.0, 300.0, 900
    index = np.arange(n)
    u = np.where((index >= 4) & (index < 450), 0.5, 0.0)
    position = GAIN * 0.5 * (swing(T * (index - 4), m, c, k) - swing(T * (index - 450), m, c, k))
    run = stepid.verify(parameters(m, c, k), campaign(experiment(position, u)))["case 4"]
    np.testing.assert_allclose(run.simulated, position, rtol=0, atol=1e-11)


def test_a_dead_stretch_before_the_first_answered_step_is_left_out() -> None:
    m, c, k, n = 1.5, 6.0, 300.0, 1300
    index = np.arange(n)
    u = np.where((index >= 5) & (index < 200), 0.5, 0.0) + np.where(index >= 500, 0.5, 0.0)
    position = 0.002 + GAIN * 0.5 * swing(T * (index - 500), m, c, k)  # the amplifier was off until sample 500
    record = experiment(position, u)
    run = stepid.verify(parameters(m, c, k), campaign(record))["case 4"]
    assert run.time[0] == record.time[480]
    np.testing.assert_allclose(run.simulated, position[480:], rtol=0, atol=1e-11)
    assert run.peak_time == record.time[np.argmax(position)]


def test_measures_of_a_known_difference() -> None:
    m, c, k = 1.5, 6.0, 300.0
    clean = one_step(m, c, k)
    error = 1e-4 * np.sin(0.3 * np.arange(600.0))
    error[:6] = 0.0
    record = experiment(clean.position + error, clean.input)
    run = stepid.verify(parameters(m, c, k), campaign(record))["case 4"]
    y = record.position
    assert run.fit_percent == pytest.approx(
        100 * (1 - math.sqrt(np.sum(error**2)) / math.sqrt(np.sum((y - y.mean()) ** 2))), rel=1e-9
    )
    assert run.rms == pytest.approx(math.sqrt(np.mean(error**2)), rel=1e-9)
    peak = int(np.argmax(y))
    assert run.peak_time == record.time[peak]
    assert run.rms_before_peak == pytest.approx(math.sqrt(np.mean(error[: peak + 1] ** 2)), rel=1e-9)
    assert run.rms_after_peak == pytest.approx(math.sqrt(np.mean(error[peak + 1 :] ** 2)), rel=1e-9)
    assert run.rms_before_peak is not None
    assert run.rms_after_peak is not None
    parts = (peak + 1) * run.rms_before_peak**2 + (599 - peak) * run.rms_after_peak**2
    assert parts == pytest.approx(600 * run.rms**2, rel=1e-12)


@pytest.mark.parametrize("size", [0.5, -0.5])
def test_settling_times(size: float) -> None:
    m, k = 1.5, 300.0
    slow, fast = 6.0, 9.0
    record = one_step(m, fast, k, size=size)
    run = stepid.verify(parameters(m, slow, k), campaign(record))["case 4"]
    fine = np.linspace(0, 4, 400_001)
    for c, found in ((fast, run.settling_time_measured), (slow, run.settling_time_simulated)):
        last = fine[np.flatnonzero(np.abs(swing(fine, m, c, k) - 1) > 0.02)[-1]]
        assert found == pytest.approx(last, abs=0.05 * T + 1e-5)


def test_quicker_settling_shows() -> None:
    m, c, k = 3.0, 8.0, 216.0
    record = one_step(m, 1.3 * c, k)  # settles sooner than its model
    run = stepid.verify(parameters(m, c, k), campaign(record))["case 4"]
    assert run.settling_time_measured is not None
    assert run.settling_time_simulated is not None
    assert run.settling_time_measured < run.settling_time_simulated
    assert run.fit_percent < 95


def test_overdamped_model_has_no_peak() -> None:
    m, k = 1.0, 200.0
    c = 3 * math.sqrt(k * m)
    a, b = np.roots([m, c, k])
    t = T * np.arange(800)
    position = 0.5 * GAIN * (1 - (b * np.exp(a * t) - a * np.exp(b * t)) / (b - a))
    run = stepid.verify(parameters(m, c, k), campaign(experiment(position, np.full(800, 0.5))))["case 4"]
    np.testing.assert_allclose(run.simulated, position, rtol=0, atol=1e-12)
    assert run.peak_time is None
    assert run.rms_before_peak is None


@pytest.mark.parametrize("held", [0, 40])
def test_release_is_met(held: int) -> None:
    m, c, k, rest, n = 1.0, 1.5, 400.0, 0.003, 800
    decay = c / (2 * m)
    wd = math.sqrt(k / m - decay**2)
    t = np.maximum(T * (np.arange(n) - held), 0.0)
    position = rest + 0.02 * np.exp(-decay * t) * (np.cos(wd * t) + decay / wd * np.sin(wd * t))
    record = experiment(position, np.zeros(n))
    identified = stepid.IdentifiedParameters(
        masses={"case 4": m}, damping={"case 4": c}, stiffness={"medium": k}, springs={"case 4": "medium"}
    )
    run = stepid.verify(identified, campaign(record))["case 4"]
    assert run.time[0] >= record.time[held]
    np.testing.assert_allclose(run.simulated, run.measured, rtol=0, atol=1e-12)
    assert run.fit_percent == pytest.approx(100.0, abs=1e-6)
    assert run.rms_before_peak is None


def test_excluded_runs_are_left_out_and_unknown_ones_refused() -> None:
    m, c, k = 1.5, 6.0, 300.0
    record = one_step(m, c, k)
    other = experiment(record.position, record.input, name="case 2")
    left_out = parameters(m, c, k, excluded={"case 2": "no overshoot"})
    assert [run.name for run in stepid.verify(left_out, campaign(record, other)).runs] == ["case 4"]
    with pytest.raises(InputError, match=r"'case 2'.*'case 4'"):
        stepid.verify(parameters(m, c, k), campaign(record, other))
    with pytest.raises(IdentificationError, match="no run to verify"):
        stepid.verify(left_out, campaign(other))


def test_fit_percent_of_the_mean_is_zero() -> None:
    measured = np.array([0.0, 1.0, 2.0, 3.0])
    assert fit_percent(measured, np.full(4, 1.5)) == pytest.approx(0.0)
    assert fit_percent(measured, measured) == 100.0
    assert fit_percent(measured, -measured) < 0


def test_verification_goes_to_json_and_back() -> None:
    m, c, k = 1.5, 6.0, 300.0
    found = stepid.verify(parameters(m, c, k), campaign(one_step(m, c, k)))
    assert stepid.Verification.model_validate_json(found.model_dump_json()) == found
    assert "case 4" in found.summary()


def test_a_step_that_is_joined_by_lines_is_verified_as_one() -> None:
    m, c, k, n = 1.0, 4.0, 216.0, 600
    u, time = np.where(np.arange(n) < 5, 0.0, 0.5), T * np.arange(n)
    found = parameters(m, c, k)
    y = control.forced_response(stepid.transfer_function(found, "case 4"), T=time, U=u).outputs
    held = experiment(y, u)
    lines = held.model_copy(update={"input_between": "lines"})
    as_held, as_lines = (stepid.verify(found, campaign(e)).runs[0] for e in (held, lines))
    assert as_lines.rms < 1e-4 * as_held.rms
