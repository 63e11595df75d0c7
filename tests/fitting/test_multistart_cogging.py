"""A motor whose ripple has wells: released carts come to rest in different ones, and the search knows which."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from hidden import Run, fast, sets
from hidden.campaigns import make_campaign
from stepid.diagnosis.diagnose import prepare
from stepid.effects import resolve
from stepid.fitting.multistart_cogging import well_starts

COUNTS = 226600
BASE, STIFFNESS, DAMPING = 2.44, 328.0, 23.8
NOISE = 4e-6  # m
BEGUN = (0.0134, 0.0145, 0.0116, 0.0103)
RIPPLE = {"amplitude": 1.3, "pitch": 5.4e-3, "phase": 2.4}


def released(ripple: dict[str, float] | None) -> stepid.Campaign:
    rng = np.random.default_rng(3)
    added = (0.0, 1.0, 3.0, 4.0)
    runs = [
        Run(
            mass=BASE + m,
            stiffness=STIFFNESS,
            damping=DAMPING,
            gain=1.0,
            sample_time=0.005,
            inputs=np.zeros(400),
            effects={} if ripple is None else {"cogging": ripple},
            position=x,
        )
        for m, x in zip(added, BEGUN, strict=True)
    ]
    return stepid.Campaign(
        name="released",
        experiments=tuple(
            stepid.Experiment(
                name=f"case {i}",
                time=0.005 * np.arange(x.size),
                position=np.round((x - x[-1] + NOISE * rng.standard_normal(x.size)) * COUNTS) / COUNTS,
                input=np.zeros(x.size),
                added_mass=m,
                spring="medium",
                damper="half",
                counts_per_meter=COUNTS,
            )
            for i, (m, x) in enumerate(zip(added, fast(runs), strict=True))
        ),
    )


def test_starts_know_each_runs_well() -> None:
    campaign = released(RIPPLE)
    context = prepare(campaign)
    start = well_starts(context, *resolve(["cogging"]))[0]
    amplitude, pitch, phase = start.values[0]
    assert amplitude == pytest.approx(RIPPLE["amplitude"], rel=0.1)
    assert pitch == pytest.approx(RIPPLE["pitch"], rel=0.03)
    assert np.cos(phase - RIPPLE["phase"]) > 0.9
    np.testing.assert_allclose(start.linear[:3], [BASE, STIFFNESS, DAMPING], rtol=0.1)
    assert start.displacement is not None
    np.testing.assert_allclose(start.displacement, BEGUN, atol=5e-4)
    ends = start.displacement - [run.position[0] for run in campaign.experiments]
    assert np.ptp(ends) > 0.5 * RIPPLE["pitch"]  # not all in one well: else the test is of nothing


@pytest.mark.slow
def test_the_fit_of_released_carts_reaches_the_noise() -> None:
    found = stepid.fit(released(RIPPLE), effects=["cogging"])
    assert found.rms < 1.05 * np.hypot(NOISE, 1 / COUNTS / np.sqrt(12))
    assert found.parameters["cogging.pitch"].value == pytest.approx(RIPPLE["pitch"], rel=1e-3)


def test_driven_carts_begin_at_the_springs_rest() -> None:
    context = prepare(stepid.datasets.lab_campaign())
    assert well_starts(context, *resolve(["cogging"])) == []
    context = prepare(released(None))
    assert well_starts(context, *resolve(["coulomb_friction"])) == []


@pytest.mark.slow
def test_wells_that_hide_the_spring() -> None:
    campaign, truth = sets.one("single", 158)
    found = stepid.diagnose(campaign)
    assert truth["effects"] == found.effects == ("cogging",)


def test_a_pitch_of_a_twentieth_of_the_travel_is_found_in_driven_runs() -> None:
    campaign, truth = make_campaign(7029, ("cogging",), kind="nine", r0=30.0)
    found = stepid.fit(campaign, effects="cogging")
    assert found.rms < 1.05 * found.noise
    pitch = found.parameters["cogging.pitch"]
    assert pitch.uncertainty is not None
    assert abs(pitch.value - truth["parameters"]["cogging.pitch"]) < 4 * pitch.uncertainty
