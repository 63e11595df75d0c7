"""Readings that jump: samples that were lost under an even clock, and what only looks alike."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stepid
from stepid.core.jumps import jumps, split_at
from stepid.fitting.screening import split_campaign

STEP, SAMPLES = 0.01, 400
TIME = STEP * np.arange(SAMPLES)


def record(position: np.ndarray, volts: np.ndarray | None = None, time: np.ndarray = TIME) -> stepid.Experiment:
    noise = 5e-6 * np.random.default_rng(1).standard_normal(SAMPLES)
    volts = np.zeros(SAMPLES) if volts is None else volts
    named = {"name": "a", "spring": "s", "damper": "d"}
    return stepid.Experiment(
        **named, time=time, position=position + noise, input=volts, added_mass=0.0, starts="motion"
    )


def swing(time: np.ndarray) -> np.ndarray:
    out: np.ndarray = 0.02 * np.exp(-0.4 * time) * np.cos(14.0 * time)
    return out


def lost(count: int, at: int) -> stepid.Experiment:
    """So many samples were lost before sample `at`, and the clock was written on."""
    return record(swing(TIME + STEP * count * (np.arange(SAMPLES) >= at)))


@pytest.mark.parametrize("count", [1, 2, 5, 17])
@pytest.mark.parametrize("at", [40, 130, 305])
def test_lost_samples_make_a_jump(count: int, at: int) -> None:
    assert jumps(lost(count, at)) == [at]


def test_a_reading_that_slips_makes_one() -> None:
    assert jumps(record(swing(TIME) + 1e-3 * (TIME >= 2.0) - 2e-3 * (TIME >= 3.0))) == [200, 300]


@pytest.mark.parametrize(("blow", "found"), [(0.1, [250]), (0.2, [])])
def test_what_is_none_hides_only_jumps_that_are_hardly_larger(blow: float, found: list[int]) -> None:
    """A blow at sample 120 is half as large, in one sample, as its speed: 0.5 mm and 1 mm, beside a slip of 2 mm."""
    hit = blow * np.maximum(TIME - 1.2, 0.0) * np.exp(-np.maximum(TIME - 1.2, 0.0))
    assert jumps(record(hit + 2e-3 * (TIME >= 2.5))) == found


def bounced(time: np.ndarray) -> np.ndarray:
    """A stop at 12 mm turns the cart between two samples, once."""
    out: np.ndarray = 0.012 - np.abs(0.05 * (time - 1.234)) - 0.02 * np.maximum(time - 1.234, 0.0) ** 2
    return out


NONE = {
    "swing": swing(TIME),
    "stop": bounced(TIME),
    "blow": np.where(TIME < 1.0, 0.0, 0.02 * np.exp(-0.4 * TIME) * np.sin(14.0 * (TIME - 1.0))),
    "wrong reading": swing(TIME) + 5e-3 * (np.arange(SAMPLES) == 150),
    "three wrong readings": swing(TIME) + 5e-3 * (np.abs(np.arange(SAMPLES) - 150) <= 1),
    "too early": swing(TIME + 0.05 * (TIME >= 0.1)),
}


@pytest.mark.parametrize("name", NONE)
def test_what_only_looks_alike_is_none(name: str) -> None:
    assert jumps(record(NONE[name])) == []


def test_a_gap_in_the_stamps_is_none_nor_what_a_step_of_the_input_makes() -> None:
    gap = TIME + 0.05 * (TIME >= 2.0)
    assert jumps(record(swing(gap), time=gap)) == []
    volts = np.where(TIME >= 1.0, 1.0, 0.0)
    fast = np.where(TIME >= 1.0, 0.02 * (1 - np.exp(-(TIME - 0.995) / 2e-3)), 0.0)  # all of it in one sample
    assert jumps(record(fast, volts)) == []


@pytest.mark.parametrize("motion", ["translation", "rotation"])
def test_a_campaign_without_any_is_the_same_and_nothing_is_said(motion: Any) -> None:
    whole = stepid.Campaign(name="c", experiments=(record(swing(TIME)),), motion=motion, input_unit="A")
    assert split_campaign(whole) == (whole, ())


def test_a_record_is_split_where_it_jumps_and_that_is_said() -> None:
    run, other = lost(5, 130), record(swing(TIME)).model_copy(update={"name": "b"})
    campaign, (note,) = split_campaign(stepid.Campaign(name="c", experiments=(run, other)))
    assert note == (
        "Run 'a' jumps at sample 130: samples were lost there, or the reading slipped. "
        "What moves on from elsewhere is taken as runs 'a (1)', 'a (2)'."
    )
    assert [part.name for part in campaign.experiments] == ["a (1)", "a (2)", "b"]
    assert [part.position.size for part in campaign.experiments] == [130, 270, 400]
    assert campaign.experiments[1].starts == "motion"
    found = stepid.fit(campaign)
    assert found.rms == pytest.approx(5e-6, rel=0.1)
    assert found.parameters["stiffness[s]"].value == pytest.approx(14.0**2 + 0.4**2, rel=1e-3)
    assert split_at(run, [10, 130])[0].name == "a (1)"  # ten samples are left out
    assert split_at(run, list(range(20, 400, 20))) == (run,)
    assert [part.position.size for part in split_at(run, [10, 130])] == [120, 270]


def test_what_is_too_short_for_a_run_is_left_out_and_said() -> None:
    run = lost(9, 390)
    assert jumps(run) == [390]
    campaign, (note,) = split_campaign(stepid.Campaign(name="c", experiments=(run,)))
    assert [part.position.size for part in campaign.experiments] == [390]
    assert note.endswith("is taken as run 'a (1)'. 10 samples in parts too short for a run are left out.")


def test_a_part_that_a_hand_held_but_for_a_few_samples_is_left_out() -> None:
    """A release that lost samples right after it: what comes before the jump is no motion."""
    since = np.maximum(np.arange(SAMPLES) - 48, 0)
    whole = record(swing(STEP * np.where(since > 4, since + 6, since)))
    run = whole.model_copy(update={"starts": "auto"})
    assert jumps(run) == [53]
    (part,) = split_at(run, [53])
    assert (part.time[0], part.starts) == (run.time[53], "motion")
    assert [p.position.size for p in split_at(run, [100])] == [100, 300]  # here it swings before, too
