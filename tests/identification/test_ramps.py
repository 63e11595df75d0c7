"""Steps between samples, as an analog output that is joined by lines makes them: python-control is the oracle."""

from __future__ import annotations

import control
import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.errors import NoStepError
from stepid.identification.steps import find_steps

MASS, STIFFNESS, DAMPING, GAIN = 1.0, 400.0, 4.0, 2.0


def responding(
    added: float, sample_time: float, noise: float, between: str = "lines", duration: float = 6.0
) -> stepid.Experiment:
    time: Array = sample_time * np.arange(round(duration / sample_time))
    volts = np.where(np.arange(time.size) >= 50, 1.0, 0.0)
    plant = control.ss(control.tf([GAIN], [MASS + added, DAMPING, STIFFNESS]))
    if between == "held":
        plant = control.sample_system(plant, sample_time, method="zoh")
    position = control.forced_response(plant, time, volts).outputs  # joins the samples of a continuous one by lines
    position = position + np.random.default_rng(round(10 * added)).normal(0, noise, time.size) if noise else position
    return stepid.Experiment(
        name=f"{added} kg", time=time, position=position, input=volts, added_mass=added, spring="s", damper="d",
        input_between=between,
    )  # fmt: skip


def campaign(sample_time: float, noise: float = 2e-6, **given: float) -> stepid.Campaign:
    runs = tuple(responding(added, sample_time, noise) for added in (0.0, 0.5, 1.0))
    return stepid.Campaign(name="ramps", experiments=runs, **given)


@pytest.mark.parametrize("sample_time", [0.01, 0.02])
def test_a_ramp_of_one_sample_is_a_step_in_its_middle(sample_time: float) -> None:
    """Half a sample is 3 to 6 per cent of the peak time: all masses had been off by as much or more."""
    found = stepid.identify(campaign(sample_time, weight_uncertainty=0.0005))
    for value, spread, true in (
        (found.stiffness["s"], found.uncertainty.stiffness["s"], STIFFNESS),
        (found.base_mass["cart"], found.uncertainty.base_mass["cart"], MASS),
        (found.pooled_damping["d"], found.uncertainty.pooled_damping["d"], DAMPING),
    ):
        assert abs(value - true) < 3 * spread < 0.025 * true


def test_the_step_is_said_to_be_in_the_middle_of_its_ramp() -> None:
    read = stepid.characterize(responding(0.0, 0.01, 2e-6))
    held = stepid.characterize(responding(0.0, 0.01, 2e-6, "held"))
    assert (read.start, held.start) == pytest.approx((0.495, 0.5))
    assert read.peak_time == pytest.approx(held.peak_time, abs=1e-4)


def test_readings_without_noise_contradict_nothing() -> None:
    """What rounding leaves of them is no law that is missing; where they rest at the end that had been an error."""
    for duration in (3.0, 40.0):
        runs = tuple(responding(added, 0.005, 0.0, "held", duration) for added in (0.0, 0.5, 1.0))
        found = stepid.identify(stepid.Campaign(name="exact", experiments=runs))
        assert not any("noise" in note for note in found.notes)


@pytest.mark.parametrize("known", [0.0005, 0.05])
def test_the_base_mass_is_as_uncertain_as_the_weights_on_the_lightest_run(known: float) -> None:
    runs = tuple(responding(added, 0.005, 2e-6, "held") for added in (0.5, 1.5))
    found = stepid.identify(stepid.Campaign(name="heavy", experiments=runs, weight_uncertainty=known))
    lightest = found.uncertainty.masses["0.5 kg"]
    assert found.uncertainty.base_mass["cart"] == pytest.approx(np.hypot(lightest, known), rel=1e-6)


def test_a_notebook_shows_what_the_summary_says() -> None:
    found = stepid.identify(campaign(0.01))
    fields = found.model_dump() | {"uncertainty": found.uncertainty, "misfit": 7.0}
    wrong = stepid.IdentifiedParameters(**fields)
    said = "The runs contradict each other 7.0 times more"
    assert said in wrong.summary()
    assert said in wrong._repr_html_()
    alone = stepid.find_trends([stepid.characterize(responding(0.0, 0.01, 2e-6))])
    assert alone._repr_html_() == f"<p>{alone.summary()}</p>"


def test_why_a_run_is_left_out_names_it_once() -> None:
    made = campaign(0.01).experiments
    late = made[0].model_copy(update={"name": "uneven", "time": made[0].time ** 1.01})
    found = stepid.identify(stepid.Campaign(name="one uneven", experiments=(*made, late)))
    assert found.excluded["uneven"].startswith("its samples are uneven")


def rising(count: int, sample_time: float = 0.01, *, between: str = "held") -> stepid.Campaign:
    """Three runs with a step of 1 V that takes so many samples to rise, and one back at once."""
    runs = []
    for added in (0.0, 0.5, 1.0):
        one = responding(added, sample_time, 0.0, between, duration=8.0)
        volts = np.clip((np.arange(800) - 49) / count, 0.0, 1.0) * (np.arange(800) < 450)
        plant = control.ss(control.tf([GAIN], [MASS + added, DAMPING, STIFFNESS]))
        plant = control.sample_system(plant, sample_time, method="zoh") if between == "held" else plant
        position = control.forced_response(plant, one.time, volts).outputs
        noise = np.random.default_rng(round(10 * added)).normal(0, 2e-6, 800)
        runs.append(one.model_copy(update={"input": volts, "position": position + noise}))
    return stepid.Campaign(name="rising", experiments=tuple(runs), weight_uncertainty=0.0005)


@pytest.mark.parametrize("between", ["held", "lines"])
@pytest.mark.parametrize("count", [2, 3, 4])
def test_a_step_that_takes_some_samples_is_one_step_about_its_middle(count: int, between: str) -> None:
    """Each sample had been a step of its own: a static gain as many times too large, without a word."""
    campaign = rising(count, between=between)
    found = stepid.identify(campaign)
    assert not found.excluded
    assert all(gain == pytest.approx(GAIN / STIFFNESS, rel=2e-3) for gain in found.static_gain.values())
    for value, spread, true in (
        (found.stiffness["s"], found.uncertainty.stiffness["s"], STIFFNESS),
        (found.base_mass["cart"], found.uncertainty.base_mass["cart"], MASS),
        (found.pooled_damping["d"], found.uncertainty.pooled_damping["d"], DAMPING),
    ):
        assert abs(value - true) < 3 * spread < 0.03 * true
    first, back = find_steps(campaign.experiments[0])
    assert (first.began, first.start, first.size, first.total) == (50, 49 + count, 1.0, 2)
    assert first.lead == pytest.approx(0.01 * (count - (between == "held")) / 2)
    assert (back.began, back.start, back.size) == (450, 450, -1.0)
    assert back.lead == pytest.approx(0.005 * (between == "lines"))
    seen = stepid.verify(found, campaign)
    assert min(run.fit_percent for run in seen.runs) > 99


def test_a_rise_that_is_no_small_part_of_the_swing_is_no_step() -> None:
    read = stepid.characterize_each(rising(12).experiments[0])
    assert "the input takes some 0.12 s to change, of the 0.1" in str(read[0])
    assert isinstance(read[1], stepid.Characteristics)
    slow = rising(25).experiments[0].model_copy(update={"input": np.linspace(0.0, 1.0, 800)})
    with pytest.raises(NoStepError, match="changes slowly, by at most 5 % of its range a sample"):
        find_steps(slow)


def test_a_step_needs_the_one_before_to_have_been_held() -> None:
    volts = np.where(np.arange(600) < 50, 0.0, np.where(np.arange(600) < 55, 1.0, -1.0))
    run = responding(0.0, 0.01, 2e-6, "held").model_copy(update={"input": volts})
    read = stepid.characterize_each(run)
    assert "held for only" in str(read[0])
    assert "the step before it is held for only 6 samples" in str(read[1])
