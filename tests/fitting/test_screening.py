"""What of a campaign a joint fit can use."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from hidden.sets import one
from stepid.fitting.fit import prepare
from stepid.fitting.screening import _still


@pytest.mark.parametrize(("step", "drift", "still"), [(0.0, 0.0, True), (0.0, 1e-4, True), (0.7e-3, 0.0, False)])
@pytest.mark.parametrize("hum", [0.0, 1e-3])
def test_a_cart_moves_behind_a_fast_hum(step: float, drift: float, still: bool, hum: float) -> None:
    """Differences of high order take a hum of 0.4 of the sampling frequency for more than it is."""
    rng = np.random.default_rng(11)
    time = np.arange(800) * 5e-3
    moves = np.where(time > 1.0, step * (1 - np.cos(9 * (time - 1.0)) * np.exp(-(time - 1.0))), 0.0)
    y = moves + hum * np.sin(0.8 * np.pi * np.arange(800)) + 1e-4 * rng.standard_normal(800)
    run = stepid.Experiment(
        name="hum",
        time=time,
        input=np.where(time > 1.0, 1.0, 0.0),
        position=y + drift * time / 4.0,  # of the sensor, where the drive is off
        added_mass=0.0,
        spring="s",
        damper="d",
    )
    assert _still(run) is still


def test_a_driven_record_whose_input_never_changes_is_used() -> None:
    """What is cut off behind the last step has no change of the input to look behind."""
    campaign, _ = one("single-all", 2, "a" * 40)
    whole = campaign.experiments[0]
    rest = whole.slice(whole.time.size // 2, None, name="the second half")
    assert np.all(rest.input == rest.input_before)
    assert rest.input_before != 0
    assert prepare(campaign + rest).records.runs[-1].name == "the second half"
