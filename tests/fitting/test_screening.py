"""What of a campaign a joint fit can use."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from hidden.sets import one
from stepid.fitting.fit import prepare
from stepid.fitting.screening import _still, screen


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


@pytest.mark.parametrize(("free", "kept"), [(5, False), (120, True)])
def test_a_release_that_ends_as_the_hand_lets_go_is_left_out_and_told(free: int, kept: bool) -> None:
    since = np.maximum(np.arange(400) - 200, 0) * 0.01
    y = 0.02 * np.exp(-0.4 * since) * np.cos(14.0 * since) + 5e-6 * np.random.default_rng(1).standard_normal(400)
    runs = [
        stepid.Experiment(
            name=name,
            time=0.01 * np.arange(end),
            position=y[:end],
            input=np.zeros(end),
            added_mass=0.0,
            spring="s",
            damper="d",
        )
        for name, end in (("whole", 400), ("cut", 200 + free))
    ]
    screened = screen(stepid.Campaign(name="c", experiments=tuple(runs)))
    assert [run.name for run in screened.campaign.experiments] == ["whole", "cut"][: 1 + kept]
    out = "Run 'cut' is left out: a hand held or moved the cart until it ends, but for a few samples."
    assert (out in screened.notes) is not kept
    if not kept:
        with pytest.raises(stepid.errors.InputError, match=r"no run can be used.*until it ends"):
            screen(stepid.Campaign(name="c", experiments=(runs[1],)))
