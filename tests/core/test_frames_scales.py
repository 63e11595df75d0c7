"""Scales of a data frame's columns: the same as those of a table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import diagnosis_example as example
import stepid
from stepid.errors import InputError

SCALES = {"time": 1e-3, "position": -1e-3, "input": 0.25}  # what a column is multiplied by


def _unscaled(frame: pd.DataFrame) -> pd.DataFrame:
    return frame.assign(**{role: frame[role] / scale for role, scale in SCALES.items()})


def test_scales_mean_what_they_mean_in_a_table(tmp_path: Path) -> None:
    run = example.campaign().experiments[0]
    frame = _unscaled(run.to_dataframe())
    frame.to_csv(tmp_path / "run.csv", index=False)
    known = {"name": run.name, "added_mass": run.added_mass, "spring": run.spring, "damper": run.damper}
    scales = {f"{role}_scale": scale for role, scale in SCALES.items()}
    columns = {role: role for role in SCALES}
    again = stepid.Experiment.from_dataframe(frame, **known, **scales)
    assert again == stepid.read_table(tmp_path / "run.csv", **known, **columns, **scales)
    for role in SCALES:
        np.testing.assert_allclose(getattr(again, role), getattr(run, role), rtol=1e-14)


def test_a_campaign_is_scaled_too() -> None:
    campaign = example.campaign()
    frame = _unscaled(campaign.to_dataframe())
    scales = {f"{role}_scale": scale for role, scale in SCALES.items()}
    again = stepid.Campaign.from_dataframe(frame, name=campaign.name, **scales)
    for run in campaign.experiments:
        for role in SCALES:
            np.testing.assert_allclose(getattr(again[run.name], role), getattr(run, role), rtol=1e-14)
    counts = frame.assign(position=(frame["position"]).astype("int16")).astype({"position": "Int16"})
    whole = stepid.Campaign.from_dataframe(counts, name=campaign.name, **scales)
    assert whole["case 6"].position.min() == 1e-3 * -counts.loc[counts["run"] == "case 6", "position"].max()


@pytest.mark.parametrize(
    ("scale", "message"),
    [
        ({"position_scale": 0.0}, "'x': position_scale is zero. Give meters per unit"),
        ({"time_scale": -1.0}, "'x': time_scale is -1. Give seconds per unit"),
        ({"input_scale": float("nan")}, "'x': input_scale is nan. Give a finite number"),
        ({"time_scale": "ms"}, "'x': time_scale is 'ms'. Give a finite number"),
        ({"position_scale": 1e6}, "'x': with position_scale = 1e.06 the positions span .* Give it in meters per unit"),
    ],
)
def test_a_scale_that_cannot_be_is_refused(scale: dict[str, Any], message: str) -> None:
    run = example.campaign().experiments[0]
    with pytest.raises(InputError, match=f"run {message}"):
        stepid.Experiment.from_dataframe(run.to_dataframe(), name="x", added_mass=0.0, spring="s", damper="d", **scale)
    with pytest.raises(InputError, match=f"campaign {message}"):
        stepid.Campaign.from_dataframe(example.campaign().to_dataframe(), name="x", **scale)


def test_text_is_refused_with_a_scale_too() -> None:
    with pytest.raises(InputError, match="position: needs numbers"):
        stepid.Campaign.from_dataframe(
            example.campaign().to_dataframe().astype({"position": str}), name="x", position_scale=1e-3
        )


@pytest.mark.parametrize("zone", [None, "Europe/Rome"])
def test_clock_times_and_durations_are_seconds(zone: str | None) -> None:
    run = example.campaign().experiments[0]
    known = {"name": run.name, "added_mass": run.added_mass, "spring": run.spring, "damper": run.damper}
    frame = run.to_dataframe()
    lasted = pd.to_timedelta(frame["time"], unit="s")
    began = pd.Timestamp("2026-03-04 10:11:12.5", tz=zone)
    for time in (lasted, began + lasted):
        again = stepid.Experiment.from_dataframe(frame.assign(time=time), **known)
        np.testing.assert_allclose(again.time - again.time[0], run.time - run.time[0], atol=2e-9)
    with pytest.raises(InputError, match=r"time_scale = 0.001, but the times have a unit of their own. Leave it out"):
        stepid.Experiment.from_dataframe(frame.assign(time=lasted), **known, time_scale=1e-3)
    gone = lasted.mask(frame.index == 3)
    with pytest.raises(InputError, match=r"time: 1 value\(s\) are not finite, the first at index 3"):
        stepid.Experiment.from_dataframe(frame.assign(time=gone), **known)
