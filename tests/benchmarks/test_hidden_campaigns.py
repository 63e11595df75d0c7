"""The maker of hidden campaigns: repeatable, at the wanted visibility, and judged by a linear fit of its own."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from hidden import NAMES, Run, reference
from hidden.campaigns import Request, make_campaign, make_campaigns
from hidden.linear_fit import linear_fit, unit_response
from hidden.outside import OUTSIDE
from hidden.sets import PAIRS, requests

CHEAP = ("coulomb_friction", "quadratic_damping", "cubic_stiffness", "actuator_lag", "sensor_drift", "free_play")


@pytest.mark.parametrize("damping", [0.0, 4.0, 2 * np.sqrt(216 * 1.2), 60.0])
def test_unit_response_is_the_reference_without_effects(damping: float) -> None:
    u = np.repeat([0.0, 0.7, -0.2, 0.0], [4, 80, 70, 60])
    run = Run(1.2, 216.0, damping, 7.8, 0.0088542, u)
    ours = 7.8 * unit_response(1.2, 216.0, damping, u, 0.0088542)
    np.testing.assert_allclose(ours, reference(run), atol=2e-9)


def test_the_linear_fit_finds_a_linear_plant() -> None:
    campaign, truth = make_campaign(5, kind="nine")
    off = {k: 1.1 * v for k, v in truth["stiffness"].items()}
    found = linear_fit(
        campaign.experiments,
        base_mass={"cart": 0.8 * truth["base_mass"]},
        stiffness=off,
        damping=truth["damping"],
        positions=truth["exact"],
    )
    assert found.base_mass["cart"] == pytest.approx(truth["base_mass"], rel=1e-5)
    assert found.force_gain == pytest.approx(truth["force_gain"], rel=1e-5)
    assert found.stiffness == pytest.approx(truth["stiffness"], rel=1e-5)
    assert found.damping == pytest.approx(truth["damping"], rel=1e-5)
    assert found.rms < 1e-9


def test_a_request_gives_the_same_campaign_alone_and_in_company() -> None:
    wanted = [Request(50 + i, (name,), r0=6.0) for i, name in enumerate(CHEAP[:3])]
    together = make_campaigns(wanted)
    alone, truth = make_campaign(51, (CHEAP[1],), r0=6.0)
    assert alone == together[1][0]
    assert truth["parameters"] == together[1][1]["parameters"]


@pytest.mark.parametrize("name", CHEAP[::2])
def test_visibility_comes_out_as_asked(name: str) -> None:
    _, truth = make_campaign(7, (name,), r0=8.0)
    assert truth["r0"] == pytest.approx(8.0, rel=0.12)
    assert {p.split(".")[0] for p in truth["parameters"]} == {name}


def test_records_are_counts_of_the_plant_plus_the_noise_that_the_truth_tells() -> None:
    campaign, truth = make_campaign(9, ("coulomb_friction",), r0=5.0)
    for e, exact, rest in zip(campaign.experiments, truth["exact"], truth["rests"], strict=True):
        assert isinstance(e, stepid.Experiment)
        counts = e.position * e.counts_per_meter
        np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
        noise = np.sqrt(np.mean((e.position - exact - rest) ** 2))
        assert noise == pytest.approx(truth["noise_rms"], rel=0.2)


def test_nothing_hidden_leaves_the_noise() -> None:
    for _, truth in make_campaigns(requests("none", 8)):
        assert truth["r0"] == pytest.approx(1.0, abs=0.12)
        assert truth["effects"] == ()


def test_the_sets_cover_the_catalogue() -> None:
    single = requests("single", 400)
    assert {r.effects[0] for r in single} == set(NAMES)
    visibility = [r.r0 for r in single if r.r0 is not None]
    assert min(visibility) < 1.02
    assert max(visibility) > 90
    assert {r.effects for r in requests("pairs", len(PAIRS))} == set(PAIRS)
    assert {r.outside for r in requests("outside", len(OUTSIDE))} == set(OUTSIDE)


@pytest.mark.parametrize("name", [n for n in OUTSIDE if n != "sticky_spot"])
def test_what_is_outside_the_catalogue_shows(name: str) -> None:
    _, truth = make_campaign(11, outside=name, r0=12.0, kind="five")
    assert truth["r0"] > 5
    assert truth["outside"] == name
