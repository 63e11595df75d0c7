"""A general law whose further parameters are open stands beside the simple one, however long the records rest."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stepid
from hidden.sets import one

SALT, NUMBER = "a" * 40, 49  # friction that differs by direction, under steps one way


def rested(campaign: stepid.Campaign, truth: dict[str, Any], seconds: float) -> stepid.Campaign:
    """The campaign with so long a rest before each of its records."""
    rng, runs = np.random.default_rng(1), []
    for run, exact, rest in zip(campaign.experiments, truth["exact"], truth["rests"], strict=True):
        assert run.counts_per_meter is not None
        count, own = 1 / abs(run.counts_per_meter), round(seconds / run.sample_time)
        spread = np.sqrt(max(truth["noise_rms"] ** 2 - count**2 / 12, 0.0))
        before = np.round((exact[0] + rest + spread * rng.standard_normal(own)) / count) * count
        change = {
            "time": run.sample_time * np.arange(own + run.time.size),
            "position": np.concatenate([before, run.position]),
            "input": np.concatenate([np.full(own, run.input_before), run.input]),
        }
        runs.append(run.model_copy(update=change))
    return campaign.model_copy(update={"experiments": tuple(runs)})


@pytest.mark.parametrize("seconds", [0.0, 0.7, 2.0])
def test_friction_that_differs_by_direction_stands_beside_coulomb_friction(seconds: float) -> None:
    campaign, truth = one("single-all", NUMBER, SALT)
    d = stepid.diagnose(rested(campaign, truth, seconds) if seconds else campaign)
    assert d.effects == ("coulomb_friction",)
    assert ("asymmetric_friction",) in d.alternatives
