"""Stretches of a record."""

from __future__ import annotations

import numpy as np
import pytest

from stepid import Campaign, Experiment
from stepid.core.slices import of_one_recording
from stepid.errors import InputError

TIME = 0.01 * np.arange(100)
DRIVEN = Experiment(
    name="long", time=TIME, position=np.sin(TIME), input=np.arange(100.0), added_mass=0.5, spring="s", damper="d",
    input_between="lines", counts_per_meter=100.0,
)  # fmt: skip


def test_a_stretch_keeps_what_belongs_to_the_run_and_starts_in_motion() -> None:
    part = DRIVEN.slice(20, 60, name="part")
    np.testing.assert_array_equal(part.time, TIME[20:60])
    np.testing.assert_array_equal(part.input, np.arange(20.0, 60.0))
    assert (part.name, part.input_before, part.starts, part.resolution) == ("part", 19.0, "motion", 0.01)
    assert (part.added_mass, part.input_between) == (0.5, "lines")


def test_the_first_stretch_starts_as_the_record_does() -> None:
    assert DRIVEN.slice(last=50).starts == "auto"
    assert DRIVEN.slice() == DRIVEN


def test_a_stretch_by_time_and_from_the_end() -> None:
    assert DRIVEN.slice(after=0.195, until=0.4) == DRIVEN.slice(20, 41)
    assert DRIVEN.slice(-20) == DRIVEN.slice(80)


def test_a_stretch_of_a_release_is_a_release() -> None:
    released = DRIVEN.model_copy(update={"input": np.zeros(100)})
    assert released.slice(30).starts == "auto"
    assert released.slice(30).input_before == 0.0
    moving = released.model_copy(update={"starts": "motion"})
    assert moving.slice(30).starts == "motion"  # what is known of the whole holds for its parts


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ({"first": 95}, r"'long': samples 95 to 100 of 100 are 5; .*at least 8"),
        ({"after": 3.0}, r"are 0; .*0 s to 0.99 s"),
        ({"first": 2, "after": 0.1}, "both first and after"),
        ({"first": 2.5}, "first is 2.5"),
        ({"until": float("nan")}, "until is nan"),
    ],
)
def test_stretches_that_cannot_be(bounds: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        DRIVEN.slice(**bounds)


def test_a_campaign_in_parts_holds_every_sample_once() -> None:
    short = DRIVEN.slice(0, 25, name="short")
    parts = Campaign(name="rig", experiments=(DRIVEN, short), weight_uncertainty=0.01).in_parts(3)
    assert [run.name for run in parts] == [f"{name}, part {k}" for name in ("long", "short") for k in (1, 2, 3)]
    np.testing.assert_array_equal(np.concatenate([run.time for run in parts]), [*TIME, *TIME[:25]])
    assert [run.time.size for run in parts] == [33, 33, 34, 8, 8, 9]
    assert [run.starts for run in parts[:3]] == ["auto", "motion", "motion"]
    assert (parts.name, parts.weight_uncertainty) == ("rig", 0.01)
    assert of_one_recording(parts.experiments[:3])


def test_parts_of_a_free_swing_start_in_motion_and_those_of_a_hold_may_hold_a_hand() -> None:
    swing = 0.02 * np.exp(-0.02 * np.arange(240)) * np.cos(0.27 * np.arange(240))
    held = np.concatenate([np.full(160, 0.02), swing])
    plain = {"input_before": 0.0, "name": "a", "added_mass": 0.0, "spring": "s", "damper": "d"}
    for position, starts in ((swing, ["auto", "motion", "motion"]), (held, ["auto", "auto", "motion"])):
        time = 0.01 * np.arange(position.size)
        run = Experiment(time=time, position=position, input=np.zeros(time.size), **plain)  # type: ignore[arg-type]
        assert [part.starts for part in Campaign(name="rig", experiments=(run,)).in_parts(3)] == starts


@pytest.mark.parametrize(
    ("number", "message"),
    [(1, "is 1"), (2.0, "is 2.0"), (True, "is True"), (13, "13 parts have 7; a part.* 12 at most")],
)
def test_parts_that_cannot_be(number: int, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Campaign(name="rig", experiments=(DRIVEN,)).in_parts(number)


def test_parts_that_go_on_where_others_end_are_of_one_recording() -> None:
    first, second, third = (DRIVEN.slice(a, b) for a, b in ((0, 30), (31, 60), (60, 100)))
    assert of_one_recording([first, second, third])
    assert of_one_recording([third, first, second])
    assert not of_one_recording([first, third])  # 30 samples are missing
    assert not of_one_recording([DRIVEN])
    assert not of_one_recording([first, first.model_copy(update={"name": "again"})])  # each has its own clock
    other = second.model_copy(update={"damper": "another"})
    assert not of_one_recording([first, other, third])
