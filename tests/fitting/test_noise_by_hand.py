"""Parts of the noise floor, of hums and of colored noise, against values that can be written down."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

import stepid
from stepid.core.base import Array
from stepid.fitting import hum, noise_color, noise_floor
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.spectrum import resonances, sharp_line, strongest_period
from stepid.simulation.records import Records, lay_out


def records(*positions: Array, step: float = 0.01, volts: Array | None = None, **more: Any) -> Records:
    runs = []
    for i, position in enumerate(positions):
        time = step * np.arange(position.size)
        told = {"input": np.where(time < 0.05, 0.0, 1.0) if volts is None else volts, "added_mass": 0.0, **more}
        runs.append(stepid.Experiment(name=f"{i}", time=time, position=position, spring="s", damper="d", **told))
    return lay_out(stepid.Campaign(name="c", experiments=tuple(runs)))


def test_a_stretch_of_one_count_weighs_as_six_readings() -> None:
    y = 1e-4 * np.repeat([0.0, 1.0, 2.0, 3.0], [3, 6, 24, 7])
    expected = np.repeat([1.0, 1.0, math.sqrt(6 / 24), math.sqrt(6 / 7)], [3, 6, 24, 7])
    np.testing.assert_allclose(noise_floor.weights(records(y, counts_per_meter=1e4), 1e-5), expected)
    assert set(noise_floor.weights(records(y, counts_per_meter=1e4), 7e-5)) == {1.0}  # noise moves the counts
    np.testing.assert_allclose(noise_floor.weights(records(y), 1e-5), expected)  # as all readings lie on a grid
    assert set(noise_floor.weights(records(np.sqrt(y)), 1e-5)) == {1.0}


def test_white_noise_of_any_size_has_no_structure() -> None:
    rng = np.random.default_rng(1)
    made = records(*(np.zeros(1000) + 1e-3 * np.sin(np.arange(1000)) for _ in range(3)))
    noise = rng.standard_normal((60, made.size))
    for size in (1e-6, 1e-3):
        found = [noise_floor.block_mean_deviate(made, size * one, size, 0.5) for one in noise]
        assert abs(float(np.mean(found))) < 3.5 / math.sqrt(60)
        assert 0.75 < float(np.std(found)) < 1.3
    steady = noise_floor.block_mean_deviate(made, np.full(made.size, 1e-6), 1e-6, 0.5)  # means do not average out
    assert steady == pytest.approx((5 - 1) * 600 / math.sqrt(2 * 600))


def test_a_jump_of_the_input_is_no_noise() -> None:
    """Within nine samples before and three after it, differences are not looked at; elsewhere they are."""
    rng = np.random.default_rng(2)
    y = 1e-5 * rng.standard_normal(400)
    volts = np.where(np.arange(400) < 200, 0.0, 1.0)
    bent = y + 1e-2 * (np.arange(400) >= 200)
    made = records(bent, volts=volts)
    found = noise_floor._moving_differences(made.runs[0], 0)
    assert found.size == 400 - 8 - 12
    assert float(np.std(found)) == pytest.approx(1e-5, rel=0.15)
    busy = records(y, volts=rng.standard_normal(400))  # a new input at each sample: all of them are
    assert noise_floor._moving_differences(busy.runs[0], 0).size == 400 - 8
    early = records(y, volts=np.where(np.arange(400) < 1, 0.0, 1.0))
    assert noise_floor._moving_differences(early.runs[0], 0).size == 400 - 8 - 4


@pytest.mark.parametrize(("count", "told"), [(27, False), (28, True)])
def test_twenty_differences_tell_a_noise(count: int, told: bool) -> None:
    y = 1e-5 * np.random.default_rng(3).standard_normal(count)
    made = records(y, volts=np.ones(count), input_before=1.0)
    exact = 1e-8 * float(np.abs(made.centered(y)).max())  # of the displacement, which a simulation is exact to
    assert noise_floor.noise_floor(made) == pytest.approx(1e-5 if told else exact, rel=0.5 if told else 1e-9)


def test_two_runs_that_differ_from_their_mean_by_s_repeat_within_the_root_of_two_s() -> None:
    base, s = 1e-2 * np.sin(0.1 * np.arange(500)), 1e-5 * np.cos(0.7 * np.arange(500))
    rest: Any = {"starts": "rest"}
    made = records(base + s, base - s, **rest)
    rms = float(np.sqrt(np.mean((s - s.mean()) ** 2)))
    assert noise_floor.repeatability(made) == pytest.approx(math.sqrt(2) * rms)
    assert noise_floor.repeatability(made, np.zeros(made.size)) == 0.0  # a fit in which they differ leaves none of it
    assert noise_floor.repeatability(records(base, base, base + s, **rest)) == pytest.approx(rms / math.sqrt(3))
    assert noise_floor.repeatability(records(base, **rest)) is None
    assert noise_floor.repeatability(records(base, -base, **rest)) is None
    (note,) = noise_floor.repeat_notes(records(base, 0.5 * base, **rest))
    assert "Runs '0', '1' have the same labels and input but differ by" in note


def test_a_fit_that_leaves_plainly_less_lowers_the_floor() -> None:
    made = records(1e-2 * np.sin(0.1 * np.arange(400)))
    grown = math.sqrt(400 / 390)
    edge = (1 - 3 / math.sqrt(2 * 390)) / grown
    assert noise_floor.bounded_floor(made, 1e-5, 1.01 * edge * 1e-5, 10) == 1e-5
    assert noise_floor.bounded_floor(made, 1e-5, 0.99 * edge * 1e-5, 10) == pytest.approx(0.99 * edge * grown * 1e-5)
    counted = records(1e-2 * np.sin(0.1 * np.arange(400)), counts_per_meter=1e5)
    assert noise_floor.bounded_floor(counted, 1e-5, 1e-7, 10) == pytest.approx(1e-5 / math.sqrt(12))


def test_the_von_neumann_ratio_of_a_wave_is_that_of_its_slope() -> None:
    """2 ⟨r²⟩/⟨(Δr)²⟩ = 1/(1 − cos ωT), whatever the size."""
    made = records(1e-2 * np.sin(0.1 * np.arange(2000)))
    wave = 1e-6 * np.cos(0.5 * np.arange(2000))
    ratio, count = noise_floor.von_neumann_ratio(made, wave)
    assert ratio == pytest.approx(1 / (1 - math.cos(0.5)), rel=0.01)
    assert count == 2000 - 8
    assert noise_floor.von_neumann_ratio(made, np.ones(2000)) == (math.inf, count)


def test_amplitudes_of_a_line_and_of_what_is_beside() -> None:
    time = 0.001 * np.arange(4000)
    line = 3e-5 * np.cos(2 * np.pi * 50.0 * time + 0.4)
    (found,) = hum._amplitudes(time, line, np.array([50.0]))
    assert found == pytest.approx(3e-5 * np.exp(0.4j), rel=1e-3)
    beside = line + 1e-6 * sum(np.cos(2 * np.pi * (50.0 + k / 3.999) * time) for k in (-6, -5, -4, -3, 3, 4, 5, 6))
    amplitude, around = hum._with_background(time, beside, 50.0)
    assert abs(amplitude) == pytest.approx(3e-5, rel=0.02)
    flat = [abs(a) for a in hum._amplitudes(time, beside - line, 50.0 + np.array(hum._BESIDE) / 3.999)]
    assert around == pytest.approx(float(np.sqrt(np.mean(np.square(flat)))), rel=0.05)
    assert hum._line(time, line, 50.0)[2]
    assert not hum._line(time, np.where(time < 1.0, 0.0, line), 50.0)[2]  # it sets in late
    assert not hum._line(time, np.where(time < 1.3, -line, line), 50.0)[2]


def linear(masses: Array) -> Any:
    count = masses.size
    layout = SimpleNamespace(mass=lambda shared: masses, stiffness=slice(0, 1), damping=slice(1, 2))
    of_runs = SimpleNamespace(spring=np.zeros(count, int), damper=np.zeros(count, int))
    return SimpleNamespace(problem=SimpleNamespace(layout=layout, records=of_runs), shared=np.array([200.0, 8.0]))


def test_answers_to_a_force() -> None:
    masses, w = np.array([1.0, 3.0]), 2 * np.pi * 4.0
    expected = 1 / np.abs(200.0 - masses * w**2 + 8.0j * w)
    np.testing.assert_allclose(hum._answers(linear(masses), 4.0), expected)


def test_one_amplitude_in_all_runs_is_a_hum_and_answers_to_one_force_are_none() -> None:
    masses, spread = np.array([1.0, 1.5, 2.0, 3.0]), np.full(4, 1e-7)
    answers = hum._answers(linear(masses), 20.0)
    assert hum._is_hum(np.full(4, 1e-5), spread, answers, False)
    assert not hum._is_hum(1e-5 * answers / answers.mean(), spread, answers, False)
    assert not hum._is_hum(np.full(4, 3.9e-7), spread, answers, False)  # four times what is beside it
    assert hum._is_hum(np.full(4, 4.1e-7), spread, np.array([1.0, 3.0, 9.0, 27.0]), False)
    assert not hum._is_hum(np.array([1e-5, 1e-5, 1e-5, 2e-5]), spread, answers, False)
    vague = np.array([1e-7, 1e-7, 1e-7, 4e-6])  # a run that can hardly tell may be off by three times as much
    assert hum._is_hum(np.array([1e-5, 1e-5, 1e-5, 2.2e-5]), vague, answers, False)
    assert hum._is_hum(np.full(4, 1e-5), spread, np.array([1.0, 1.0, 1.0, 2.0]), False)
    same = np.full(4, 2e-7)  # masses alike: nothing tells, unless a force would have to be huge
    assert not hum._is_hum(np.full(4, 1e-5), spread, same, False)
    assert hum._is_hum(np.full(4, 1e-5), spread, same, True)


def test_a_hum_is_subtracted_with_its_phase() -> None:
    t = 0.002 * np.arange(500)
    clean = 1e-2 * np.sin(3.0 * t)
    lines = [a * np.cos(2 * np.pi * 40.0 * t + phase) for a, phase in ((1e-4, 0.3), (2e-4, -1.0))]
    made = records(*(clean + line for line in lines), step=0.002)
    told = RecordFault(run="all runs", kind="hum", size=1e-4, unit="m", words="a hum")
    found = hum.Hum(40.0, np.array([1e-4 * np.exp(0.3j), 2e-4 * np.exp(-1.0j)]), told)
    campaign = stepid.Campaign(name="c", experiments=made.runs)
    for run in hum.without_hum(campaign, (found,)).experiments:
        np.testing.assert_allclose(run.position, clean, atol=1e-12)


def test_colored_noise_tells_of_a_mean_as_much_as_fewer_samples() -> None:
    """Of first-order noise n (1 − ρ)/(1 + ρ), its correlation fading by e in −T/ln ρ."""
    made, rho = records(np.zeros(20_000) + 1e-3 * np.sin(np.arange(20_000))), 0.8
    found = noise_color._color(made, noise_color._Shape(1.0, rho), 2e-5)
    assert (found.kind, found.white, found.colored) == ("ar1", 0.0, 2e-5)
    assert found.correlation_time == pytest.approx(-0.01 / math.log(rho))
    assert found.effective_samples == pytest.approx(20_000 * (1 - rho) / (1 + rho), rel=2e-3)
    mixed = noise_color._color(made, noise_color._Shape(0.36, rho), 1e-5)
    assert (mixed.white, mixed.colored) == pytest.approx((0.8e-5, 0.6e-5))
    assert mixed.effective_samples == pytest.approx(20_000 / (1 + 2 * 0.36 * rho / (1 - rho)), rel=2e-3)
    slow = noise_color._color(made, noise_color._Shape(1.0, 1.0), 1e-5)
    assert (slow.kind, slow.correlation_time) == ("1/f", pytest.approx(10.0))


@pytest.mark.parametrize("width", [12, 32])
def test_contrasts_see_no_polynomial(width: int) -> None:
    basis = noise_color._contrasts(width)
    np.testing.assert_allclose(basis.T @ basis, np.eye(width - 6), atol=1e-12)
    np.testing.assert_allclose(np.vander(np.arange(width) / width, 6).T @ basis, 0.0, atol=1e-12)


def test_windows_overlap_by_half() -> None:
    assert noise_color._cut(np.arange(20), 8)[:, 0].tolist() == [0, 4, 8, 12]


def windows(values: Array, floor: float, length: float) -> noise_color._Windows:
    found = noise_color._windows(records(values), values, floor, length)
    assert found is not None
    return found


def test_white_noise_is_found_white_with_its_variance() -> None:
    y = 1e-5 * np.random.default_rng(5).standard_normal(4000)
    found = windows(y, 1e-5, 0.33)
    assert found.width == 32  # the widest that the length holds
    assert windows(y, 1e-5, 0.05).width == 12
    shapes = noise_color._covariances(32)[0]
    plain = shapes.index(noise_color._Shape(0.0, 0.2))
    assert found.scale[plain] == pytest.approx(np.trace(found.product) / len(found.product))
    assert found.scale[plain] == pytest.approx(1e-10, rel=0.05)
    assert found.number == pytest.approx(0.5 * (4000 // 16 - 1), abs=2)
    best = noise_color._best(found, 0.9)
    assert best.gain < 9
    assert best.odd < 3.3


def test_colored_noise_is_found_with_its_correlation() -> None:
    drive = 1e-5 * np.sqrt(1 - 0.75**2) * np.random.default_rng(6).standard_normal(8200)
    y = lfilter([1.0], [1.0, -0.75], drive)[200:]
    found = noise_color._best(windows(y, 1e-5, 0.33), 0.97)
    assert found.gain > 100
    assert found.shape.share >= 0.8
    assert 0.6 < found.shape.correlation < 0.9
    assert found.variance == pytest.approx(1e-10, rel=0.3)
    assert noise_color._best(windows(y, 1e-5, 0.33), 0.3).gain < found.gain  # what is slower is a misfit


def test_what_is_exactly_as_the_model_says_is_not_odd() -> None:
    """χ² over its freedom is one in each direction: by Wilson and Hilferty √(2/9n) standard deviations."""
    shape, number, scale = 7, 40.0, 3e-10
    values, vectors = noise_color._directions(16, shape)
    covariance = (vectors / values) @ vectors.T
    one = noise_color._Windows(scale * covariance, number, 16, np.empty(0), np.empty(0))
    assert noise_color._oddest(one, shape, scale) == pytest.approx(math.sqrt(2 / 9 / number), rel=1e-6)
    loud = one._replace(product=8.0 * one.product)
    error = 2 / 9 / number
    assert noise_color._oddest(loud, shape, scale) == pytest.approx((2.0 - 1 + error) / math.sqrt(error), rel=1e-6)


def test_windows_look_where_the_reading_moves_by_more_than_its_counts() -> None:
    rng = np.random.default_rng(7)
    moving = 1e-2 * np.sin(0.05 * np.arange(4000)) + 1e-5 * rng.standard_normal(4000)
    still = np.concatenate([moving[:2000], np.full(2000, moving[2000])])
    half = [noise_color._windows(records(np.round(y, 5), counts_per_meter=1e5), y, 1e-5, 0.33) for y in (moving, still)]
    assert half[0] is not None
    assert half[1] is not None
    assert half[1].number == pytest.approx(0.5 * half[0].number, rel=0.1)
    for size in (40, 80):
        assert noise_color._windows(records(moving[:size]), moving[:size], 1e-5, 0.33) is None
    coarse = records(np.round(moving, 3), counts_per_meter=1e3)  # where counts hide the noise, a window spans many
    assert noise_color._windows(coarse, moving, 1e-4, 0.33) is None
    assert noise_color._windows(coarse, moving, 1e-3, 0.33) is not None


def test_runs_of_one_window_are_looked_at() -> None:
    parts = 1e-5 * np.random.default_rng(4).standard_normal((10, 32))
    held: dict[str, Any] = {"volts": np.ones(32), "input_before": 1.0}
    assert noise_color._windows(records(*parts, **held), parts.ravel(), 1e-5, 0.33) is not None
    short = parts[:, :31]
    held["volts"] = np.ones(31)
    assert noise_color._windows(records(*short, **held), short.ravel(), 1e-5, 0.33) is None


def test_periods_resonances_and_lines_are_found_where_they_are() -> None:
    rng, t = np.random.default_rng(9), 0.01 * np.arange(3000)
    made = records(1e-2 * np.sin(2 * np.pi * 1.7 * t) + 1e-6 * rng.standard_normal(3000))
    assert strongest_period(made) == pytest.approx(1 / 1.7, rel=0.01)
    slow = 1e-3 * np.exp(-0.5 * t) * np.sin(2 * np.pi * 2.0 * t) + 6e-4 * np.exp(-0.5 * t) * np.sin(2 * np.pi * 2.6 * t)
    noise = 1e-6 * rng.standard_normal(3000)
    found = resonances(made, slow + noise, count=2)
    assert found[:2] == pytest.approx((2.0, 2.6), abs=0.05)
    near = 1e-3 * np.exp(-0.05 * t) * (np.sin(2 * np.pi * 2.0 * t) + 0.5 * np.sin(2 * np.pi * 2.2 * t))
    assert abs(resonances(made, near + noise, count=2)[1] - 2.0) > 0.15 * 2.0  # what is nearer is the same
    assert sharp_line(made, noise, above=3.0) is None
    line = 2e-6 * np.cos(2 * np.pi * 21.3 * t)
    assert sharp_line(made, slow + noise + line, above=6.0) == pytest.approx(21.3, abs=0.01)
    assert resonances(made, slow + noise + line, count=2)[2] == pytest.approx(21.3, abs=0.01)


def test_a_jump_near_the_beginning_is_no_noise() -> None:
    y = 1e-5 * np.random.default_rng(9).standard_normal(400)
    for at in (2, 5, 9):
        volts = np.where(np.arange(400) < at, 0.0, 1.0)
        made = records(y + 1e-2 * (np.arange(400) >= at), volts=volts)
        found = noise_floor._moving_differences(made.runs[0], 0)
        assert found.size == 400 - 8 - (at + 3)
        assert np.abs(found).max() < 6e-5
        assert noise_floor._moving_differences(made.runs[0], 20).size == 400 - 20 - 8  # it was before these


@pytest.mark.parametrize(("frequency", "found"), [(14.0, False), (20.0, True)])
def test_a_line_is_a_hum_where_a_force_would_have_to_be_huge(frequency: float, found: bool) -> None:
    """Of masses alike nothing else tells: beyond eight times the plant's own frequency, here 2 Hz."""
    t, rng = 0.01 * np.arange(800), np.random.default_rng(10)
    line = 1e-4 * np.cos(2 * np.pi * frequency * t)
    made = records(*(line + 1e-6 * rng.standard_normal(800) for _ in range(3)))
    plant = linear(np.full(3, 200.0 / (4 * np.pi) ** 2))
    hums = hum._hum(made, plant, made.position, frequency, 2.0)
    assert (hums is not None) is found
    assert hums is None or hums.frequency == pytest.approx(frequency, abs=0.01)
