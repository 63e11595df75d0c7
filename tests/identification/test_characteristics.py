"""Characteristics against the closed form of the step response."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from closed_form import SAMPLE_TIME, Plant, make_run
from stepid import characteristics as ch
from stepid.identification.second_order import damping_ratio_slope, settling_time

PLANT = Plant(base_mass=0.954, stiffness=216.2, damping=14.0)
ADDED = (0.0, 0.5, 1.5, 2.0)


@pytest.mark.parametrize("added", ADDED)
@pytest.mark.parametrize("size", [0.5, -0.5])
def test_step_of_a_linear_plant(added: float, size: float) -> None:
    found = stepid.characterize(make_run(PLANT, added, steps=[(12, size)], rest=-0.01))
    time, overshoot = PLANT.peak(added)
    decay, frequency = PLANT.rates(added)
    assert found.peak_time == pytest.approx(time, rel=1e-4)
    assert found.overshoot == pytest.approx(overshoot, rel=2e-4)
    assert found.damped_frequency == pytest.approx(frequency, rel=1e-4)
    assert found.damping_ratio == pytest.approx(PLANT.damping_ratio(added), rel=2e-4)
    assert found.natural_frequency == pytest.approx(np.hypot(decay, frequency), rel=2e-4)
    assert found.steady_state == pytest.approx(7.8 / 216.2 * size, rel=1e-5)
    assert found.static_gain == pytest.approx(7.8 / 216.2, rel=1e-5)
    ideal = settling_time(found.natural_frequency, found.damping_ratio)
    assert found.settling_time == pytest.approx(ideal, abs=0.1 * SAMPLE_TIME)
    assert (found.start, found.step) == pytest.approx((12 * SAMPLE_TIME, size))


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.5, 0.8])
def test_settling_time_is_the_last_entry_into_the_band(ratio: float) -> None:
    plant = Plant(base_mass=1.0, stiffness=100.0, damping=20 * ratio, gain=100.0)
    time = np.linspace(0, 60, 600_001)
    outside = np.abs(plant.response(time, 0.0, [(0.0, 1.0)]) - 1) > 0.02
    assert settling_time(10.0, ratio) == pytest.approx(time[np.flatnonzero(outside)[-1]], abs=2e-4)


def test_formulas_are_inverse_to_each_other() -> None:
    for ratio in (0.01, 0.3, 0.48781, 0.9):
        assert ch.damping_ratio(ch.overshoot_of(ratio)) == pytest.approx(ratio, rel=1e-12)
    assert ch.overshoot_of(0.48781) == pytest.approx(0.17281, abs=1e-5)  # reading notes, case 4
    assert ch.damped_frequency(0.23903) == pytest.approx(np.pi / 0.23903)
    for overshoot in (0.01, 0.17, 0.6):  # the closed derivative against a central difference
        difference = (ch.damping_ratio(overshoot + 1e-6) - ch.damping_ratio(overshoot - 1e-6)) / 2e-6
        assert damping_ratio_slope(overshoot, ch.damping_ratio(overshoot)) == pytest.approx(difference, rel=1e-6)
    assert ch.overshoot(1.25, 1.0) == 0.25
    assert ch.static_gain(-0.018, -0.5) == pytest.approx(0.036)


def test_step_at_the_first_sample_and_from_an_input_before() -> None:
    at_once = make_run(PLANT, 0.5, steps=[(0, 0.5)])
    assert stepid.characterize(at_once).peak_time == pytest.approx(PLANT.peak(0.5)[0], rel=1e-4)
    shifted = at_once.model_copy(update={"input": at_once.input + 1.0, "input_before": 1.0})
    assert stepid.characterize(shifted) == stepid.characterize(at_once)
    to_zero = make_run(PLANT, 0.5, steps=[(0, -0.5)], rest=0.018)
    down = to_zero.model_copy(update={"input": to_zero.input + 0.5, "input_before": 0.5})
    assert not np.any(down.input)
    found = stepid.characterize(down)
    assert found.step == -0.5
    assert found.damping_ratio == pytest.approx(PLANT.damping_ratio(0.5), rel=3e-4)


def test_every_step_up_back_and_the_other_way() -> None:
    steps = [(10, 0.5), (410, -0.5), (810, -0.3)]
    found = stepid.characterize_all(make_run(PLANT, 1.5, steps=steps, count=1210))
    assert [c.name for c in found] == ["case 5", "case 5, step 2", "case 5, step 3"]
    for one, (_, size) in zip(found, steps, strict=True):
        assert one.step == pytest.approx(size)
        assert one.peak_time == pytest.approx(PLANT.peak(1.5)[0], rel=1e-3)
        assert one.static_gain == pytest.approx(7.8 / 216.2, rel=1e-3)
        assert abs(one.peak_time - PLANT.peak(1.5)[0]) < 3 * one.uncertainty.peak_time


def test_each_step_has_a_result_or_its_error() -> None:
    run = make_run(PLANT, 1.5, steps=[(10, 0.5), (410, -0.5)], count=440)
    good, bad = stepid.characterize_each(run)
    assert isinstance(good, stepid.Characteristics)
    assert isinstance(bad, stepid.errors.NotSettledError)
    assert "step 2 of 2" in str(bad)
    with pytest.raises(stepid.errors.NotSettledError, match="step 2 of 2"):
        stepid.characterize_all(run)


def test_sampled_peak_is_the_largest_sample() -> None:
    run = make_run(PLANT, 0.5, counts_per_meter=226600)
    found = stepid.characterize(run, peak=stepid.SampledPeak())
    top = int(np.argmax(run.position))
    assert found.peak_time == run.time[top] - run.time[12]
    assert found.uncertainty.peak_time == pytest.approx(SAMPLE_TIME / np.sqrt(12), rel=0.01)
    assert abs(found.peak_time - PLANT.peak(0.5)[0]) < 0.5 * SAMPLE_TIME


@pytest.mark.parametrize("noise", [20e-6, 200e-6])
def test_uncertainties_are_those_of_repeats(noise: float) -> None:
    rng = np.random.default_rng(5)
    repeats = [stepid.characterize(make_run(PLANT, 1.5, noise=noise, rng=rng)) for _ in range(60)]
    truth = {"peak_time": PLANT.peak(1.5)[0], "overshoot": PLANT.peak(1.5)[1], "steady_state": 0.5 * 7.8 / 216.2}
    for quantity, true in truth.items():
        z = [(getattr(c, quantity) - true) / getattr(c.uncertainty, quantity) for c in repeats]
        assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.4, quantity


def test_settling_time_under_noise() -> None:
    rng = np.random.default_rng(5)
    repeats = [stepid.characterize(make_run(PLANT, 0.5, noise=20e-6, rng=rng)) for _ in range(40)]
    truth = settling_time(np.sqrt(216.2 / 1.454), PLANT.damping_ratio(0.5))
    z = [(c.settling_time - truth) / c.uncertainty.settling_time for c in repeats]
    assert 0.4 < np.sqrt(np.mean(np.square(z))) < 1.4
    loud = stepid.characterize(make_run(PLANT, 0.5, noise=500e-6, rng=rng))
    assert loud.settling_time is None  # noise fills the band


def test_a_record_that_ends_while_ringing_is_used_with_a_note_or_refused() -> None:
    light = Plant(base_mass=0.954, stiffness=216.2, damping=5.0)
    decay, _ = light.rates(1.5)
    count = 12 + int(np.log(1 / 0.035) / decay / SAMPLE_TIME)
    found = stepid.characterize(make_run(light, 1.5, count=count))
    assert "fitted tail" in found.notes[0]
    assert found.damping_ratio == pytest.approx(light.damping_ratio(1.5), rel=1e-3)
    assert abs(found.overshoot - light.peak(1.5)[1]) < 2 * found.uncertainty.overshoot
    with pytest.raises(stepid.errors.NotSettledError, match=r"case 5.*still swings.*Record longer"):
        stepid.characterize(make_run(light, 1.5, count=count // 2))


def test_constructible_by_hand() -> None:
    known = stepid.CharacteristicsUncertainty(peak_time=0.002, overshoot=0.001)
    one = stepid.Characteristics(name="case 4", peak_time=0.239, overshoot=0.1728, uncertainty=known)
    assert one.damped_frequency == pytest.approx(np.pi / 0.239)
    assert one.uncertainty.damped_frequency == pytest.approx(np.pi / 0.239**2 * 0.002)
    step = 1e-6
    slope = (ch.damping_ratio(0.1728 + step) - ch.damping_ratio(0.1728 - step)) / (2 * step)
    assert one.uncertainty.damping_ratio == pytest.approx(abs(slope) * 0.001, rel=1e-6)
    assert one.uncertainty.natural_frequency > one.uncertainty.damped_frequency
    assert "0.2390 ± 0.0020" in one.summary()
    assert "<table>" in one._repr_html_()
    for wrong in ({"damping_ratio": 1.2}, {"damped_frequency": 20.0}, {"correlation": 2.0}):
        with pytest.raises(stepid.errors.InputError, match="case 4"):
            stepid.Characteristics(**{"name": "case 4", "peak_time": 0.239, "overshoot": 0.1728} | wrong)
