"""Small parts of the identification against values that can be written down."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import savgol_coeffs

import stepid
from closed_form import Plant, draw_plant, make_campaign, make_run
from made_up_runs import offset, run
from stepid.errors import IdentificationError
from stepid.identification import tightness
from stepid.identification.free_response import Extrema, constant_loss, logarithmic_decrement
from stepid.identification.peak import COARSE, FINE, fit_peak, polynomial
from stepid.identification.pooling import pool_steps
from stepid.identification.solvers import _constrained
from stepid.identification.steady_state import last_swing, settling_time_measured, steady_state
from turning_points import losing

PLANT = Plant(base_mass=0.954, stiffness=216.2, damping=14.0)


def extrema(sizes: list[float], spread: float) -> Extrema:
    """Turning points about zero, each with this uncertainty."""
    signs = np.resize([1.0, -1.0], len(sizes))
    same = np.full(len(sizes), spread)
    return Extrema(0.1 * np.arange(len(sizes)), signs * sizes, 1e-3 * same, same)


def test_decrement_of_three_turning_points() -> None:
    """δ = ln(D₀/D₁), each range D with the variance of two readings."""
    found, spread = logarithmic_decrement(extrema([8e-3, 5e-3, 3e-3], 1e-5))
    assert found == pytest.approx(math.log(13 / 8))
    assert spread == pytest.approx(math.sqrt(2) * 1e-5 * math.hypot(1 / 13e-3, 1 / 8e-3))


def test_constant_loss_needs_five_ranges() -> None:
    """D' = ρD − L."""
    _, sizes = losing(5)
    assert constant_loss(extrema(sizes, 1e-9)) == pytest.approx(1e-3, rel=1e-6)
    assert constant_loss(extrema(sizes[:-1], 1e-9)) is None


def test_last_swing_is_half_the_range_of_the_last_half_period() -> None:
    time = np.arange(101) / 64
    assert last_swing(time, 3.0 * time, 0.25) == 3.0 * 0.25 / 2


def test_white_noise_leaves_the_level_as_uncertain_as_a_mean() -> None:
    rng, level, decay, frequency = np.random.default_rng(2), 0.018, 5.0, 20.0
    time = 1e-3 * np.arange(3000)
    ringing = level * (1 - np.exp(-decay * time) * np.cos(frequency * time))
    read = [
        steady_state(
            time, ringing + 1e-5 * rng.standard_normal(time.size), peak_time=math.pi / frequency, noise=1e-5,
            damped_frequency=frequency, damping_ratio=decay / math.hypot(decay, frequency), overshoot=0.45,
        )
        for _ in range(40)
    ]  # fmt: skip
    tail = time.size - read[0].first
    assert read[0].uncertainty == pytest.approx(1e-5 / math.sqrt(tail), rel=0.1)
    off = np.array([one.level - level for one in read]) / read[0].uncertainty
    assert 0.7 < float(np.sqrt(np.mean(off**2))) < 1.3


def test_settling_is_told_up_to_the_noise_that_smoothing_over_the_window_leaves() -> None:
    """A cubic over ±0.15 half periods; two standard deviations of what it leaves may not fill the band."""
    made = make_run(PLANT, 1.5, steps=[(0, 0.5)], count=600)
    half, level = PLANT.peak(1.5)[0], 0.5 * PLANT.gain / PLANT.stiffness
    window = 2 * round(0.15 * half / made.sample_time) + 1
    most = 0.02 * level / 2 / float(np.linalg.norm(savgol_coeffs(window, 3)))
    for share, told in ((0.9, True), (1.1, False)):
        found = settling_time_measured(
            made.time, made.position, level=level, half_period=half, noise=share * most, spread=0.0
        )
        assert (found is not None) is told


def test_a_vague_peak_is_read_with_the_lower_degree() -> None:
    time = 0.002 * np.arange(-60, 61)
    swing = 0.02 * np.cos(12.0 * time) + 2e-3 * np.random.default_rng(3).standard_normal(time.size)
    fine = fit_peak(time, swing, 0.0, 0.06, noise=2e-3, by=FINE)
    by = polynomial(0.002, 0.06, noise=2e-3, curvature=0.02 * 12.0**2)
    assert by is COARSE
    assert polynomial(0.002, 0.06, noise=2e-6, curvature=0.02 * 12.0**2) is FINE
    found = fit_peak(time, swing, 0.0, 0.06, noise=2e-3, by=by)
    assert found.time_uncertainty < 0.8 * fine.time_uncertainty
    assert abs(found.time) < 3 * found.time_uncertainty


def step(name: str, peak: float, **known: float) -> stepid.Characteristics:
    told = stepid.CharacteristicsUncertainty(**known)
    return stepid.Characteristics(name=name, peak_time=peak, overshoot=0.3, uncertainty=told)


def test_steps_of_which_one_tells_no_uncertainty_count_alike() -> None:
    pooled = pool_steps([step("a", 0.20, peak_time=0.001), step("a", 0.21)], name="a")
    assert pooled.peak_time == pytest.approx(0.205)


def test_steps_that_scatter_more_than_they_may_count_alike() -> None:
    """Two readings d apart with uncertainties u and v scatter by d/√(u² + v²)."""
    u, v = 0.001, 0.002
    apart = 2.5 * math.hypot(u, v)
    pooled = pool_steps([step("a", 0.2, peak_time=u), step("a", 0.2 + apart, peak_time=v)], name="a")
    assert pooled.peak_time == pytest.approx(0.2 + apart / 2)
    assert pooled.uncertainty.peak_time == pytest.approx(apart / 2)
    near = pool_steps([step("a", 0.2, peak_time=u), step("a", 0.2 + 0.6 * apart, peak_time=v)], name="a")
    assert near.peak_time == pytest.approx(0.2 + 0.6 * apart / 5)  # weights 4 : 1


def test_uncertainty_of_the_natural_frequency_is_propagated() -> None:
    """ω_n = ω_d/√(1 − ζ²)."""
    told = stepid.CharacteristicsUncertainty(damped_frequency=0.1, damping_ratio=0.02)
    found = stepid.Characteristics(
        name="a", damped_frequency=12.0, damping_ratio=0.6, correlation=0.4, uncertainty=told
    )
    by_frequency, by_ratio = 0.1 / 0.8, 0.02 * 12.0 * 0.6 / 0.8**3
    cross = 2 * 0.4 * by_frequency * by_ratio
    assert found.uncertainty.natural_frequency == pytest.approx(math.sqrt(by_frequency**2 + by_ratio**2 + cross))


def test_a_constraint_alone_fixes_what_no_row_sees() -> None:
    found = _constrained(np.array([[2.0, 0.0]]), np.array([6.0]), np.array([[0.0, -1.0]]), np.array([-5.0]))
    assert found == pytest.approx([3.0, 5.0])


@pytest.mark.parametrize("solver", [stepid.OrdinaryLeastSquares(), stepid.WeightedLeastSquares()])
def test_more_mass_that_quickens_every_run_is_told(solver: stepid.Solver) -> None:
    runs = [run("light", 2.0), run("heavy", 1.0)]
    with pytest.raises(IdentificationError, match=r"contradict the known mass differences"):
        stepid.solve(stepid.assemble(runs, (offset("light", "heavy", 0.5),)), solver=solver)


def test_damping_is_pooled_by_inverse_variances_of_the_runs_of_a_damper() -> None:
    made = make_campaign(draw_plant(np.random.default_rng(5)), np.random.default_rng(5))
    spreads, dampers = np.array([0.05, 0.1, 0.1, 0.2]), ("open", "open", "shut", "shut")
    runs = []
    for e, spread, damper, off in zip(made.experiments, spreads, dampers, (1.0, 1.1, 0.9, 1.2), strict=True):
        read = stepid.characterize(e)
        frequency, ratio = read.damped_frequency, off * read.damping_ratio
        known = stepid.CharacteristicsUncertainty(damped_frequency=spread * frequency, damping_ratio=spread * ratio)
        own = {"name": e.name, "damped_frequency": frequency, "damping_ratio": ratio}
        labels = {"spring": e.spring, "damper": damper, "added_mass": e.added_mass}
        runs.append(stepid.Characteristics(**own, **labels, uncertainty=known))
    found = stepid.solve(stepid.assemble(runs, made.mass_offsets))
    each = np.array(list(found.damping.values()))
    assert np.ptp(each) > 0.1 * each[0]
    expected = {
        damper: float(np.average(each[part], weights=spreads[part] ** -2.0))
        for damper, part in (("open", slice(0, 2)), ("shut", slice(2, 4)))
    }
    assert found.pooled_damping == pytest.approx(expected, rel=1e-12)


def test_slopes_by_the_force_gain_are_the_response_over_it() -> None:
    rng = np.random.default_rng(6)
    made = make_campaign(PLANT, rng)
    found = stepid.identify(made)
    for e in made.experiments:
        slopes = tightness._slopes(e, found, PLANT.gain)
        assert slopes is not None
        np.testing.assert_allclose(PLANT.gain * slopes[3], e.position, atol=2e-3 * np.abs(e.position).max())


@pytest.mark.parametrize(("changes", "told"), [(40, True), (41, False)])
def test_up_to_forty_changes_of_the_input_are_looked_at(changes: int, told: bool) -> None:
    made = make_campaign(PLANT, np.random.default_rng(7))
    found, e = stepid.identify(made), made.experiments[0]
    waves = 0.5 * (np.minimum(np.arange(e.time.size), changes) % 2)
    run_ = e.model_copy(update={"input": waves, "input_before": 0.0})
    assert (tightness._slopes(run_, found, PLANT.gain) is not None) is told


def test_correlations_lie_within_one() -> None:
    found = stepid.IdentifiedParameters(
        masses={"a": 1.0}, damping={"a": 10.0}, stiffness={"s": 200.0}, static_gain={"a": 0.04}, springs={"a": "s"},
        covariance=np.array([[1.0, 1.0 + 1e-13], [1.0 + 1e-13, 1.0]]),
        covariance_labels=("masses[a]", "stiffness[s]"),
    )  # fmt: skip
    assert found.correlation("masses[a]", "stiffness[s]") == 1.0


def test_the_most_likely_answer_does_not_hang_on_where_its_search_begins() -> None:
    rng = np.random.default_rng(3)
    made = make_campaign(draw_plant(rng), rng, noise=300e-6, weight_spread=0.005)
    system = stepid.assemble([stepid.characterize(e) for e in made.experiments], made.mass_offsets)
    solver = stepid.ErrorsInVariables()
    known = solver.readings(system.characteristics), np.array([o.difference for o in made.mass_offsets])
    best = solver.unknowns(system, *known)
    for times in (0.2, 5.0, 1000.0):
        np.testing.assert_allclose(solver.unknowns(system, *known, start=times * best), best, rtol=1e-8)


def test_what_a_fit_would_give_is_not_told_where_the_input_is_beyond_all_numbers() -> None:
    made = make_campaign(PLANT, np.random.default_rng(8), noise=2e-5)
    found = stepid.identify(made)
    assert tightness.tighter_by_fit(made.experiments, found, 1e-7) is not None
    huge = [e.model_copy(update={"input": 1e200 * e.input}) for e in made.experiments]
    assert tightness.tighter_by_fit(huge, found, 1e-7) is None


def test_a_run_that_moves_from_its_first_sample_on_rests_there() -> None:
    """Of an input by lines from its value before the record: what it was at rest is the first reading."""
    masses = {"a": 1.0}
    found = stepid.IdentifiedParameters(
        masses=masses, damping={"a": 10.0}, stiffness={"s": 200.0}, static_gain={"a": 0.04}, springs={"a": "s"}
    )
    time = 0.01 * np.arange(300)
    decay, frequency = 5.0, math.sqrt(200.0 - 25.0)
    ring = np.cos(frequency * time) + decay / frequency * np.sin(frequency * time)
    step = stepid.Experiment(
        name="a", time=time, position=0.004 + 0.02 * (1 - np.exp(-decay * time) * ring), input=np.full(300, 0.5),
        input_before=0.0, input_between="lines", added_mass=0.0, spring="s", damper="d",
    )  # fmt: skip
    (run_,) = stepid.verify(found, stepid.Campaign(name="c", experiments=(step,))).runs
    assert run_.simulated[0] == pytest.approx(0.004, abs=1e-9)
