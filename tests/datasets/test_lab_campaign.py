"""The made-up lab campaign: it is what its script makes, and it shows what the paper's plant shows."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

import stepid
from hidden.linear_fit import linear_fit

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "make_lab_campaign.py"


def test_the_script_makes_the_data_that_ship() -> None:
    if not SCRIPT.exists():
        pytest.skip("the benchmarks are not beside the tests")
    made = runpy.run_path(str(SCRIPT))["make"]()
    shipped = stepid.datasets.lab_campaign()
    assert [e.name for e in made.experiments] == [e.name for e in shipped.experiments]
    for one, two in zip(made.experiments, shipped.experiments, strict=True):
        np.testing.assert_array_equal(one.input, two.input)
        # an integrator's last digit may turn a count over, no more
        assert np.max(np.abs(one.position - two.position)) < 1.5 / 226600
        assert np.mean(one.position != two.position) < 0.01


def test_table_1_and_the_limits_of_the_plant() -> None:
    campaign = stepid.datasets.lab_campaign()
    names = [e.name for e in campaign.experiments]
    assert names == ["case 1", "case 2", "case 3", "case 3b", *(f"case {i}" for i in range(4, 10))]
    assert [campaign[f"case {i}"].added_mass for i in (4, 5, 6, 7)] == [0.0, 0.5, 1.5, 2.0]
    assert {e.spring for e in campaign.experiments} == {"light", "medium", "stiff"}
    assert campaign["case 3"].base != campaign["case 3b"].base
    for e in campaign.experiments:
        assert np.max(np.abs(e.position)) < 0.03  # the plant's travel
        assert e.sample_time == pytest.approx(0.0088542, rel=1e-9)
        assert e.counts_per_meter == 226600


def test_a_linear_plant_does_not_explain_it() -> None:
    campaign, truth = stepid.datasets.lab_campaign(), stepid.datasets.lab_truth()
    found = linear_fit(
        campaign.experiments, base_mass=truth.base_mass, stiffness=truth.stiffness, damping=truth.damping
    )
    assert found.rms > 20 * truth.noise_rms
    # friction passes for damping: the paper's Table 2 shows the same
    assert found.damping["1/2 turn"] > 1.2 * truth.damping["1/2 turn"]
    before_the_step = [e.position[: np.flatnonzero(e.input)[0]] for e in campaign.experiments]
    assert np.std(np.concatenate([x - x.mean() for x in before_the_step])) == pytest.approx(truth.noise_rms, rel=0.3)
