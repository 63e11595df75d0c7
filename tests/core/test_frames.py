"""DataFrames in and out: what goes in comes back equal, what cannot is named."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import diagnosis_example as example
import stepid
from stepid.errors import InputError, MissingPackageError

FINITE = st.floats(-1e6, 1e6, allow_nan=False)
TEXT = st.text(min_size=1, max_size=8)


@st.composite
def experiments(draw: st.DrawFn, name: str | None = None) -> stepid.Experiment:
    n = draw(st.integers(8, 24))
    record = st.lists(FINITE, min_size=n, max_size=n)
    return stepid.Experiment(
        name=draw(TEXT) if name is None else name,
        time=draw(st.floats(-100, 100)) + draw(st.floats(1e-4, 1.0)) * np.arange(n),
        position=draw(record),
        input=draw(record),
        added_mass=draw(st.floats(0, 10)),
        spring=draw(TEXT),
        damper=draw(TEXT),
        counts_per_meter=draw(st.none() | st.sampled_from([226600.0, -226600.0])),
        input_before=draw(FINITE),
        base=draw(TEXT),
        input_between=draw(st.sampled_from(["held", "lines", "smooth"])),
        starts=draw(st.sampled_from(["auto", "rest", "motion"])),
    )


@st.composite
def campaigns(draw: st.DrawFn) -> stepid.Campaign:
    names = draw(st.lists(TEXT, min_size=1, max_size=3, unique=True))
    return stepid.Campaign(name=draw(TEXT), experiments=tuple(draw(experiments(name)) for name in names))


@given(experiments())
@settings(max_examples=50, deadline=None)
def test_an_experiment_comes_back(experiment: stepid.Experiment) -> None:
    frame = experiment.to_dataframe()
    assert list(frame) == ["time", "position", "input"]
    fields = ("name", "added_mass", "spring", "damper", "counts_per_meter", "base")
    fields += ("input_before", "input_between", "starts")
    own = {field: getattr(experiment, field) for field in fields}
    assert stepid.Experiment.from_dataframe(frame, **own) == experiment


@given(campaigns())
@settings(max_examples=50, deadline=None)
def test_a_campaign_comes_back(campaign: stepid.Campaign) -> None:
    frame = campaign.to_dataframe()
    assert len(frame) == sum(e.time.size for e in campaign.experiments)
    assert stepid.Campaign.from_dataframe(frame, name=campaign.name) == campaign


@given(campaigns(), st.randoms(use_true_random=False))
@settings(max_examples=20, deadline=None)
def test_the_order_of_columns_and_a_new_index_do_not_matter(campaign: stepid.Campaign, random: object) -> None:
    frame = campaign.to_dataframe()
    columns = list(frame)
    random.shuffle(columns)  # type: ignore[attr-defined]
    frame = frame[columns].set_index(pd.Index(range(len(frame), 0, -1)))
    assert stepid.Campaign.from_dataframe(frame, name=campaign.name) == campaign


def test_the_frame_is_a_copy() -> None:
    experiment = example.campaign().experiments[0]
    before = float(experiment.position[3])
    frame = experiment.to_dataframe()
    frame.loc[3, "position"] = 99.0
    assert experiment.position[3] == before


def test_runs_may_be_interleaved_and_columns_left_out() -> None:
    campaign = example.campaign()
    frame = campaign.to_dataframe().drop(
        columns=["counts_per_meter", "base", "input_before", "input_between", "starts"]
    )
    shuffled = frame.sort_values("time", kind="stable")
    again = stepid.Campaign.from_dataframe(shuffled, name=campaign.name)
    assert [e.name for e in again.experiments] == list(example.RUNS)
    assert again["case 6"].counts_per_meter is None
    np.testing.assert_array_equal(again["case 6"].position, campaign["case 6"].position)


def test_nullable_and_categorical_columns_are_read() -> None:
    campaign = example.campaign()
    plain = campaign.to_dataframe()
    frame = plain.astype({"position": "Float64", "input": "Float64", "run": "category", "spring": "category"})
    assert stepid.Campaign.from_dataframe(frame, name=campaign.name) == campaign
    whole = plain.convert_dtypes()
    assert stepid.Campaign.from_dataframe(whole, name=campaign.name) == campaign


def _frame() -> pd.DataFrame:
    return example.campaign().to_dataframe()


def test_a_missing_value_is_named() -> None:
    frame = _frame().astype({"position": "Float64"})
    frame.loc[7, "position"] = pd.NA
    with pytest.raises(InputError, match=r"column 'position'.*1 missing value\(s\), the first in row 7"):
        stepid.Campaign.from_dataframe(frame, name="x")
    plain = _frame()
    plain.loc[7, "position"] = np.nan
    with pytest.raises(InputError, match=r"Experiment 'case 4'.*position.*index 7"):
        stepid.Campaign.from_dataframe(plain, name="x")


def test_text_in_place_of_numbers_is_refused() -> None:
    with pytest.raises(InputError, match="position: needs numbers"):
        stepid.Campaign.from_dataframe(_frame().astype({"position": str}), name="x")


@pytest.mark.parametrize("column", ["run", "time", "position", "input", "added_mass", "spring", "damper"])
def test_a_missing_column_is_named(column: str) -> None:
    with pytest.raises(InputError, match=rf"no column '{column}'"):
        stepid.Campaign.from_dataframe(_frame().drop(columns=[column]), name="x")


@pytest.mark.parametrize(("column", "value"), [("spring", "stiff"), ("added_mass", 9.0), ("spring", None)])
def test_what_changes_within_a_run_is_named(column: str, value: object) -> None:
    frame = _frame()
    frame.loc[11, column] = value
    with pytest.raises(InputError, match=rf"run 'case 4': column '{column}' changes .* in row 11"):
        stepid.Campaign.from_dataframe(frame, name="x")


@pytest.mark.parametrize("value", [None, ""])
def test_a_row_without_a_run_is_named(value: object) -> None:
    frame = _frame()
    frame.loc[11, "run"] = value
    with pytest.raises(InputError, match=r"row 11 of the data frame names no run in column 'run'"):
        stepid.Campaign.from_dataframe(frame, name="x")


# ---- results ----------------------------------------------------------------------------------------------------


def test_identified_parameters_as_a_frame() -> None:
    found = stepid.identify(example.campaign())
    frame = found.to_dataframe()
    assert list(frame) == ["value", "uncertainty", "unit"]
    assert frame.index.name == "parameter"
    assert set(found.covariance_labels) <= set(frame.index)
    for name in found.masses:
        row = frame.loc[f"masses[{name}]"]
        assert (row["value"], row["unit"]) == (found.masses[name], "kg")
        assert row["uncertainty"] == found.uncertainty.masses[name]
    assert frame.loc["stiffness[medium]", "unit"] == "N/m"
    assert frame.loc["static_gain[case 4]", "value"] == found.static_gain["case 4"]


def test_fit_and_diagnosis_as_frames() -> None:
    d = example.named()
    fit = stepid.Fit(
        parameters=d.parameters
        | {"sensor_drift.rate": stepid.Estimate(value=0.0, unit="m/s")},  # the data leave it open
        model=d.model,
        rms=d.gap.after,
        noise=d.gap.noise,
        run_rms={},
        correlation=np.eye(2),
        converged=True,
    )
    frame = d.to_dataframe()
    assert list(frame.index) == list(d.parameters)
    assert frame.loc["coulomb_friction.level", "unit"] == "N"
    assert frame.loc["coulomb_friction.level", "uncertainty"] == d.parameters["coulomb_friction.level"].uncertainty
    pd.testing.assert_frame_equal(fit.to_dataframe().loc[frame.index], frame)
    assert np.isnan(fit.to_dataframe().loc["sensor_drift.rate", "uncertainty"])
    run = d.runs[0].to_dataframe()
    np.testing.assert_array_equal(run["measured"] - run["model"], d.runs[0].measured - d.runs[0].model)


def test_verification_as_a_frame() -> None:
    campaign = example.campaign()
    verified = stepid.verify(stepid.identify(campaign), campaign)
    frame = verified.to_dataframe().set_index("run")
    assert frame["rms"].to_dict() == dict(verified.rms)
    record = verified["case 4"].to_dataframe()
    assert np.sqrt(((record["measured"] - record["simulated"]) ** 2).mean()) == pytest.approx(verified.rms["case 4"])


def test_without_pandas_the_extra_is_named() -> None:
    code = (
        "import sys; sys.modules['pandas'] = None; import stepid\n"
        "run = stepid.datasets.lab_campaign().experiments[0]\n"
        "try: run.to_dataframe()\n"
        "except ImportError as error: print(type(error).__name__, error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(MissingPackageError.__name__)
    assert "pip install 'stepid[pandas]'" in done.stdout


# ---- plain dictionaries -----------------------------------------------------------------------------------------


@cache
def _results() -> dict[str, stepid.Experiment]:
    campaign = example.campaign()
    found = stepid.identify(campaign)
    characteristics = [stepid.characterize(e) for e in campaign.experiments]
    results: list[Any] = [
        campaign,
        campaign.experiments[0],
        campaign.mass_offsets[0],
        characteristics[0],
        stepid.assemble(characteristics, campaign.mass_offsets),
        found,
        stepid.verify(found, campaign),
        stepid.find_trends(characteristics),
        example.named(),
        example.named().model,
        example.named().parameters["force_gain"],
    ]
    return {type(result).__name__: result for result in results}


@pytest.mark.parametrize(
    "kind",
    [
        "Campaign",
        "Experiment",
        "MassOffset",
        "Characteristics",
        "StackedSystem",
        "IdentifiedParameters",
        "Verification",
        "Trends",
        "Diagnosis",
        "PlantModel",
        "Estimate",
    ],
)
def test_results_become_plain_dictionaries_and_come_back(kind: str) -> None:
    result = _results()[kind]
    values = result.to_dict()
    assert isinstance(values, dict)
    assert json.loads(json.dumps(values)) == values  # plain: nothing that JSON would have to bend
    assert type(result).from_dict(values) == result
    assert values.keys() == type(result).model_fields.keys()


@given(experiments())
@settings(max_examples=25, deadline=None)
def test_any_experiment_becomes_a_plain_dictionary(experiment: stepid.Experiment) -> None:
    assert stepid.Experiment.from_dict(json.loads(json.dumps(experiment.to_dict()))) == experiment


def test_a_wrong_dictionary_is_refused() -> None:
    values = example.campaign().experiments[0].to_dict()
    with pytest.raises(InputError, match="added_mass"):
        stepid.Experiment.from_dict(values | {"added_mass": -1.0})
    with pytest.raises(InputError, match="not plain"):
        stepid.Experiment.from_dict(values | {"time": np.arange(3.0)})


def test_a_campaigns_frame_without_a_column_is_told_all_it_needs() -> None:
    frame = {"time": [0.0], "position": [0.0], "input": [0.0]}
    with pytest.raises(
        InputError, match=r"no column 'run'; there are: time, position, input. Rename .*: run, time, .*damper"
    ):
        stepid.Campaign.from_dataframe(frame, name="rig")
