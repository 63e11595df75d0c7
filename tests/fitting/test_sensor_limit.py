"""Readings at the sensor's limit: found where the cart goes on beyond it, and left out; a stop or a peak is none."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from broken_campaigns import changed
from made_up_releases import released
from scattered_campaigns import scattered
from stepid.core.base import Array
from stepid.fitting.fit import prepare
from stepid.fitting.reading_faults import mend
from stepid.fitting.sensor_limit import at_limit, beyond

TIME = 0.01 * np.arange(470)
SWING = np.exp(-0.3 * TIME) * np.cos(4.0 * TIME + 0.7)


def record(position: Array) -> stepid.Experiment:
    return stepid.Experiment(
        name="r", time=TIME, position=position, input=0.0 * TIME, added_mass=0.0, spring="s", damper="d",
        starts="motion",
    )  # fmt: skip


def rounded(position: Array, count: float) -> Array:
    return position if count == 0 else count * np.round(position / count)


@pytest.mark.parametrize("count", [0.0, 1e-4, 5e-3])
@pytest.mark.parametrize("limits", [(-0.4, 2.0), (-0.55, 0.35), (-2.0, 0.4)])
def test_readings_at_a_limit_are_found(count: float, limits: tuple[float, float]) -> None:
    read = np.clip(rounded(SWING, count), *(rounded(np.array(limits), count)))
    first = 1 if limits[1] < SWING[0] else 0  # a record that begins beyond a limit does so unseen
    expected = (read == read.max()) & (limits[1] < SWING.max()) | (read == read.min()) & (limits[0] > SWING.min())
    assert at_limit(record(read)).tolist() == expected.tolist()
    assert expected[first:].any()


@pytest.mark.parametrize("count", [1e-4, 1e-2, 0.05, 0.1])
def test_a_peak_within_a_count_is_no_limit(count: float) -> None:
    assert not at_limit(record(rounded(SWING, count))).any()


def test_a_cart_that_rests_at_a_stop_and_sets_out_from_it_is_at_no_limit() -> None:
    into, rest = np.linspace(-1.0, 0.0, 100), np.zeros(100)
    out = -0.5 * 9e-4 * np.arange(270.0) ** 2 / 27
    assert not at_limit(record(np.concatenate([into, rest, out]))).any()


def test_what_is_beyond_a_limit_goes_on_as_it_came() -> None:
    limit = np.abs(SWING) > 0.45
    guessed = beyond(np.clip(SWING, -0.45, 0.45), limit)
    inner = limit & (TIME[np.argmin(limit)] < TIME)
    assert np.abs(guessed - SWING)[inner].max() < 0.03
    assert np.array_equal(guessed[~limit], SWING[~limit])


def test_they_are_told_and_not_fitted() -> None:
    clean = scattered(1)
    clipped = clean
    for run in range(6):
        y = clean.experiments[run].position
        clipped = changed(clipped, run, position=np.minimum(y, y.min() + 0.9 * np.ptp(y)))
    context = prepare(clipped)
    told = [fault for fault in context.faults if fault.kind == "clipped readings"]
    assert [fault.run for fault in told] == [run.name for run in clean.experiments]
    assert all("are at the sensor's limit" in fault.words for fault in told)
    for fault, run in zip(told, clipped.experiments, strict=True):
        assert fault.size == pytest.approx(run.position.max())
        assert mend(run).wrong.sum() == (run.position == run.position.max()).sum()
    assert context.linear.rms < 1.05 * prepare(clean).linear.rms
    assert stepid.diagnose(clipped).verdict == stepid.diagnose(clean).verdict == "adequate"


def test_a_release_is_at_no_limit() -> None:
    assert not at_limit(released(0.5)).any()
