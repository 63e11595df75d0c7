"""Parts of what is read off a step, against values that can be written down."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stepid
from closed_form import Plant, make_run
from stepid.errors import NotSettledError
from stepid.identification.errors_in_variables import _unbiased
from stepid.identification.free_response import Extrema, _free_part, constant_loss, find_extrema
from stepid.identification.peak import FINE, InterpolatedPeak, SampledPeak, fit_peak
from stepid.identification.pooling import pool_steps
from stepid.identification.steady_state import steady_state
from stepid.identification.step_response import _read, _response, _rest, _spreads
from stepid.identification.steps import find_steps
from stepid.identification.trends import Trend
from turning_points import losing

PLANT = Plant(base_mass=0.954, stiffness=216.2, damping=14.0)


def reading(name: str, peak: float, **known: float) -> stepid.Characteristics:
    told = stepid.CharacteristicsUncertainty(**known)
    return stepid.Characteristics(name=name, peak_time=peak, overshoot=0.3, uncertainty=told)


def test_one_step_goes_by_the_name_of_its_run() -> None:
    one = reading("case 4, step 2", 0.2, peak_time=1e-3)
    renamed = pool_steps([one], name="case 4")
    assert renamed.name == "case 4"
    assert renamed.model_copy(update={"name": one.name}) == one
    assert pool_steps([one], name=one.name) is one


def test_a_trend_goes_from_the_first_run_to_the_last() -> None:
    runs = (reading("a", 0.20, peak_time=1e-3), reading("b", 0.30, peak_time=0.1), reading("c", 0.21, peak_time=1e-3))
    trend = Trend(varies="mass", held="all else", runs=runs)
    assert trend.change("peak_time") == "rises"
    assert Trend(varies="mass", held="all else", runs=runs[::-1]).change("peak_time") == "falls"
    for u, v in ((1e-3, 4e-3), (4e-3, 1e-3)):
        for times, said in ((1.9, "no clear change"), (2.1, "rises")):  # of two standard uncertainties
            last = reading("b", 0.2 + times * math.hypot(u, v), peak_time=v)
            near = Trend(varies="mass", held="all else", runs=(reading("a", 0.2, peak_time=u), last))
            assert near.change("peak_time") == said
    vague = (*runs[:2], reading("c", 0.21, peak_time=0.01))
    assert Trend(varies="mass", held="all else", runs=vague).change("peak_time") == "no clear change"


def test_an_eighth_of_the_samples_may_be_steps() -> None:
    for count, many in ((10, False), (11, True)):
        volts = 0.5 * (np.minimum(np.arange(80) // 7, count) % 2)
        run = make_run(PLANT, 1.5, count=80).model_copy(update={"input": volts})
        if many:
            with pytest.raises(stepid.errors.NoStepError, match=f"changes at {count} of 80 samples"):
                find_steps(run)
        else:
            assert [step.total for step in find_steps(run)] == [count] * count


def test_a_level_is_read_off_all_its_samples_not_off_the_last() -> None:
    """Of a flicker of 4 % of the step, too little to be a step of its own, the median stays."""
    run = make_run(PLANT, 1.5, count=300)
    volts = np.repeat([0.2, 1.2, 0.7], 100)
    volts[[99, 199]] += 0.04
    steps = find_steps(run.model_copy(update={"input": volts, "input_before": 0.2}))
    assert [(step.start, round(step.size, 12)) for step in steps] == [(100, 1.0), (200, -0.5)]


def test_what_slowly_wanders_counts_by_half_periods() -> None:
    """A sine of three times the frequency, over whole periods of it: rms a/√2, as many readings as half periods."""
    decay, frequency, a = 5.0, 20.0, 1e-4
    time = np.linspace(0.0, 4.0, 2001)
    position = 0.018 * (1 - np.exp(-decay * time) * np.cos(frequency * time)) + a * np.sin(3 * frequency * time)
    found = steady_state(
        time, position, peak_time=math.pi / frequency, noise=1e-9, damped_frequency=frequency,
        damping_ratio=decay / math.hypot(decay, frequency), overshoot=0.45,
    )  # fmt: skip
    halves = (time[-1] - time[found.first]) / (math.pi / frequency)
    assert found.uncertainty == pytest.approx(a / math.sqrt(2) / math.sqrt(halves), rel=0.03)


def test_a_loss_is_clear_only_beyond_what_the_turning_points_leave_open() -> None:
    ranges, sizes = losing(6)
    position = np.resize([1.0, -1.0], len(sizes)) * sizes
    time, clear, last, first = 0.1 * np.arange(len(sizes)), *np.full((3, len(sizes)), 1e-9)
    assert constant_loss(Extrema(time, position, clear, clear)) == pytest.approx(1e-3)
    basis = np.column_stack([ranges[:-1], -np.ones(5)])
    most = 1e-3 / 5 / float(np.linalg.norm(np.linalg.pinv(basis)[1]))  # of the spread of a range
    first[0] = last[-1] = math.sqrt(6) * most
    for part in (first, last):  # one vague turning point of six
        assert constant_loss(Extrema(time, position, clear, 0.9 * part)) == pytest.approx(1e-3)
        assert constant_loss(Extrema(time, position, clear, 1.1 * part)) is None


def test_uncertainty_of_an_exact_peak_is_what_the_polynomial_cuts_off() -> None:
    time = 0.002 * np.arange(-60, 61)
    found = fit_peak(time, 0.02 * np.cos(12.0 * time), 0.0, 0.06, noise=1e-12)
    _, cut_time, cut_height = FINE
    assert found.time == pytest.approx(0.0, abs=1e-6)
    assert found.height_uncertainty == pytest.approx(cut_height * 0.02, rel=0.02)
    assert found.time_uncertainty == pytest.approx(cut_time * 0.06, rel=0.02)


def test_a_ring_from_before_adds_with_any_phase() -> None:
    """A swing r of the level moves the overshoot by r·M_p and the peak time by r·t_p/π, each times a cosine."""
    run = make_run(PLANT, 1.5, noise=1e-6)
    response = _response(run, find_steps(run)[0])
    read = _read(response, InterpolatedPeak())
    still, ringing = (_spreads(response, read, ring) for ring in (0.0, 0.02))
    time, excess = 0.02 * read.peak.time / math.pi / math.sqrt(2), 0.02 * read.excess / math.sqrt(2)
    assert math.sqrt(ringing.time**2 - still.time**2) == pytest.approx(time, rel=1e-6)
    assert math.sqrt(ringing.excess**2 - still.excess**2) == pytest.approx(excess, rel=0.05)


def test_counts_leave_their_width_over_the_root_of_twelve() -> None:
    run = make_run(PLANT, 1.5, noise=1e-6)
    step, grid = find_steps(run)[0], 1e-4
    flat = run.model_copy(update={"position": np.where(np.arange(run.time.size) < 13, 0.0, run.position)})
    assert _rest(flat, step, "run", 0.0, grid) == pytest.approx((0.0, grid / math.sqrt(12)), rel=1e-12)
    response = _response(run, step)
    read = _read(response, InterpolatedPeak())
    fine, coarse = (_spreads(response._replace(grid=size), read, 0.0).tail for size in (0.0, grid))
    assert math.sqrt(coarse**2 - fine**2) == pytest.approx(grid / math.sqrt(12), rel=1e-9)


def test_a_bias_is_taken_off_of_what_was_read_only() -> None:
    bare = stepid.Characteristics(name="a", damped_frequency=12.0, damping_ratio=0.4, peak_time_bias=1e-3)
    assert _unbiased(bare) == (12.0, 0.4)
    late = stepid.Characteristics(name="a", peak_time=0.251, overshoot=0.3, peak_time_bias=1e-3)
    assert _unbiased(late)[0] == pytest.approx(math.pi / 0.25)


def test_what_rings_long_before_a_later_step_does_not_count() -> None:
    """The rest before it is read off the last twenty samples."""
    light = Plant(base_mass=0.954, stiffness=216.2, damping=8.0)
    run = make_run(light, 2.0, steps=[(10, 0.5), (230, -0.5)], count=900)
    moved = np.abs(run.position - run.position[228])
    assert moved[60:200].max() > 0.1 * run.position[228]
    assert moved[210:231].max() < 0.03 * run.position[228]
    back = stepid.characterize_each(run)[1]
    assert isinstance(back, stepid.Characteristics)
    assert abs(back.peak_time - light.peak(2.0)[0]) < 3 * back.uncertainty.peak_time


def test_a_short_tail_counts_by_what_the_fit_leaves_free() -> None:
    """Of n samples a level and a swing of known frequency take three."""
    decay, frequency, rng = 5.0, 20.0, np.random.default_rng(4)
    time = np.arange(0.0, 0.6, 0.05)
    position = 0.018 * (1 - np.exp(-decay * time) * np.cos(frequency * time)) + 1e-4 * rng.standard_normal(time.size)
    found = steady_state(
        time, position, peak_time=math.pi / frequency, noise=1e-9, damped_frequency=frequency,
        damping_ratio=decay / math.hypot(decay, frequency), overshoot=0.45,
    )  # fmt: skip
    free = time.size - found.first - 3
    halves = (time[-1] - time[found.first]) / (math.pi / frequency)
    assert 0 < free < 6
    square = float(found.residual @ found.residual) / free / halves
    assert found.uncertainty == pytest.approx(math.sqrt(square), rel=1e-6)


def test_a_swing_that_goes_on_for_ever_is_told_with_its_size() -> None:
    free = Plant(base_mass=0.954, stiffness=216.2, damping=0.0)
    with pytest.raises(NotSettledError, match=r"still swings ±(9\d|10\d)\.\d % of its steady displacement"):
        stepid.characterize(make_run(free, 0.0, count=500))


def test_a_turning_point_needs_a_quarter_of_a_half_period_on_either_side() -> None:
    """And a sample: of half periods of 40 samples eleven."""
    for before, after, told in ((11, 11, 3), (11, 10, 2), (10, 11, 2)):
        place = np.arange(-before, 80 + after + 1) + 2000
        position = np.cos(math.pi / 40 * (place - 2000))
        position[0] = 0.0  # else the hand might hold the plant there
        found = find_extrema(0.01 * place, position, rest=0.0, noise=0.0, peak=SampledPeak())
        assert found.time.size == told


def test_whether_it_was_let_go_from_afar_is_read_off_the_first_sample() -> None:
    turning = np.array([-1.0, 0.8, -0.6, 0.4])
    found = Extrema(0.1 + 0.2 * np.arange(4), 0.3 + turning, *np.full((2, 4), 1e-6))
    for first, kept in (([0.6, 0.4], 4), ([0.4, 0.6], 3)):  # of the largest swing, from rest; a half decides
        part, start = _free_part(found, 0.3 + np.array(first), 0.3)
        assert part.time.size == kept
        assert start == found.time[4 - kept]
