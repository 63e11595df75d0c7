"""The ring-down is cut where the swing begins and ends, and is the same for paper and for the screen."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pytest

import diagnosis_example as example
from stepid import plot
from stepid.diagnosis.result import Diagnosis, RunGap
from stepid.errors import UndeterminedError
from stepid.plot.ring_down import zoomed_ring_down
from stepid.report.pictures import pictures

REST, NOISE = 2e-3, 1e-5


def swinging(*, damping: float = 1.0, amplitude: float = 0.02) -> RunGap:
    """A release at 1 s that swings at 1 Hz about a rest off zero; the linear model swings a little less."""
    time = np.arange(0.0, 8.0, 0.01)
    after = np.maximum(time - 1.0, 0.0)
    swing = amplitude * np.exp(-damping * after) * np.cos(2 * np.pi * after)
    return RunGap(
        name="release", time=time, measured=REST + swing, linear=REST + 0.9 * swing, model=REST + swing, before=1e-3,
        after=1e-5, phases={"ring-down": 1e-3},
    )  # fmt: skip


def told(*runs: RunGap) -> Diagnosis:
    d = example.named()
    return d.model_copy(update={"runs": runs, "gap": d.gap.model_copy(update={"noise": NOISE})})


def test_it_begins_at_the_first_passage_and_goes_on_as_long_again() -> None:
    shown = zoomed_ring_down(told(swinging(damping=4.0)))
    assert shown is not None
    assert shown.run == "release"
    assert shown.time[0] == pytest.approx(1.25, abs=0.011)  # a quarter of a period after the release
    ends = 1.0 + np.log(0.02 / (5 * NOISE)) / 4.0  # exp(−4 t) has sunk to five times the noise
    assert shown.time[-1] == pytest.approx(1.25 + 2 * (ends - 1.25), abs=0.5)
    np.testing.assert_array_equal(shown.measured[:3], swinging(damping=4.0).measured[125:128])


def test_the_run_that_fails_most_there_is_shown() -> None:
    worse = swinging().model_copy(update={"name": "worse", "phases": {"ring-down": 2e-3}})
    shown = zoomed_ring_down(told(swinging(), worse))
    assert shown is not None
    assert shown.run == "worse"


@pytest.mark.parametrize("run", [swinging(amplitude=0.0), swinging().model_copy(update={"phases": {}})])
def test_no_run_that_swings_no_picture(run: RunGap) -> None:
    d = told(run)
    assert zoomed_ring_down(d) is None
    assert "ring-down" not in pictures(d, ())
    with pytest.raises(UndeterminedError, match=r"no run of .* rings down"):
        plot.ring_down(d, axes=plt.figure().add_subplot())
