"""Verification of real recordings, where their folder is known."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import stepid

FOLDER = os.environ.get("STEPID_REAL_DATA")
pytestmark = pytest.mark.skipif(FOLDER is None, reason="STEPID_REAL_DATA does not name the folder of real recordings")


def releases(spring: str) -> stepid.Campaign:
    """Six hand releases of one spring: three without weights, three with two weights of 493 g."""
    root = Path(FOLDER or "") / "ecp210-milan" / "free-release"
    runs = [
        stepid.read_table(
            sorted(folder.glob("data*.txt")),
            position=0,
            position_scale=0.01,
            sample_time=0.005,
            name=folder.name,
            added_mass=0.986 if "2mass" in folder.name else 0.0,
            spring=spring,
            damper="none",
        )
        for folder in sorted(root.glob(f"K{spring}_hand_*"))
    ]
    return stepid.Campaign(name=spring, experiments=tuple(runs))


@pytest.mark.parametrize("spring", ["high", "med"])
def test_linear_models_meet_the_first_swings_and_miss_the_stop(spring: str) -> None:
    campaign = releases(spring)
    verified = stepid.verify(stepid.identify(campaign), campaign)
    assert len(verified.runs) == 6
    for run in verified.runs:
        assert 80 < run.fit_percent < 95  # dry friction is left over
        error = run.measured - run.simulated
        early = run.time < run.time[0] + 0.2 * (run.time[-1] - run.time[0])
        swing = float(np.ptp(run.measured))
        assert np.max(np.abs(error[early])) < 0.05 * swing
        # in the last 0.3 s the plant stands still or nearly, the linear model does not
        late = run.time > run.time[-1] - 0.3
        assert np.ptp(run.simulated[late]) > 3 * np.ptp(run.measured[late])
