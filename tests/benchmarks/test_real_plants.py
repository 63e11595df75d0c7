"""Real recordings, made by others, where their folder is known: what is known of a plant is in the answer."""

import os
import sys
from pathlib import Path

import pytest

import stepid

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from real_sets import SETS

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        "STEPID_REAL_DATA" not in os.environ, reason="STEPID_REAL_DATA does not name the folder of real recordings"
    ),
]


@pytest.mark.parametrize("name", ["pendulum", "milan-releases-medium"])
def test_what_is_known_of_a_real_plant_is_in_the_answer(name: str) -> None:
    what = SETS[name]
    d = stepid.diagnose(what.build())
    assert what.right(d), (d.verdict, d.effects, d.reasons)
    assert what.unit[1] * d.gap.after <= what.most


@pytest.mark.parametrize("name", sorted(SETS))
def test_the_recordings_are_cut_as_told(name: str) -> None:
    campaign = SETS[name].build()
    assert len(campaign.experiments) >= 2
    if name.startswith(("roll", "silverbox", "pendulum")):
        assert all(run.starts == "motion" for run in campaign.experiments)
