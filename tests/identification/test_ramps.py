"""Steps between samples, as an analog output that is joined by lines makes them: python-control is the oracle."""

from __future__ import annotations

import control
import numpy as np
import pytest

import stepid
from stepid.core.base import Array

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
