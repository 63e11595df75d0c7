"""What is handed over in place of a campaign or of an experiment is told what to make of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import stepid
from closed_form import Plant, make_campaign
from stepid.errors import InputError

PLANT = Plant(base_mass=0.954, stiffness=216.2, damping=14.0)
CAMPAIGN = make_campaign(PLANT, np.random.default_rng(1))
PARAMETERS = stepid.identify(CAMPAIGN)
MODEL = stepid.PlantModel(
    base_mass={"cart": 1.0}, stiffness={"spring": 216.0}, damping={"damper": 14.0}, force_gain=8.0, effects=(), runs={}
)
OF_CAMPAIGNS = {
    "identify": stepid.identify,
    "diagnose": stepid.diagnose,
    "fit": stepid.fit,
    "verify": lambda given: stepid.verify(PARAMETERS, given),
    "simulate": lambda given: stepid.simulate(MODEL, given),
    "write_campaign": lambda given: stepid.write_campaign(given, "never made"),
}
OTHERS = {
    "a list": [*CAMPAIGN.experiments],
    "a tuple": CAMPAIGN.experiments,
    "a list of frames": [pd.DataFrame({"time": [0.0]})],
    "a DataFrame": CAMPAIGN.to_dataframe(),
    "an Experiment": CAMPAIGN.experiments[0],
    "a str": "campaign.toml",
    "a NoneType": None,
}


@pytest.mark.parametrize("other", OTHERS)
@pytest.mark.parametrize("name", OF_CAMPAIGNS)
def test_no_campaign(name: str, other: str) -> None:
    with pytest.raises(InputError) as caught:
        OF_CAMPAIGNS[name](OTHERS[other])
    assert caught.value.cause == f"a Campaign is needed here, not {other.removesuffix(' of frames')}"
    assert "stepid.Campaign(name=…, experiments=[…])" in caught.value.remedy
    assert not Path("never made").exists()


@pytest.mark.parametrize(
    "use",
    [
        stepid.characterize,
        stepid.characterize_all,
        stepid.characterize_each,
        stepid.to_time_response,
        lambda run: stepid.simulate_system(stepid.transfer_function(PARAMETERS, CAMPAIGN.experiments[0].name), run),
    ],
)
@pytest.mark.parametrize("other", [CAMPAIGN, [*CAMPAIGN.experiments], "run 1"], ids=["campaign", "list", "name"])
def test_no_experiment(use, other) -> None:
    with pytest.raises(InputError, match=r"an Experiment is needed here, not a .*Give one run: campaign\[name\]"):
        use(other)


@pytest.mark.parametrize("other", [CAMPAIGN, CAMPAIGN.experiments, ["run 1"]], ids=["campaign", "experiments", "name"])
def test_trends_of_what_has_no_characteristics(other) -> None:
    with pytest.raises(InputError, match=r"something else. Give \[stepid.characterize\(run\) for run in"):
        stepid.find_trends(other)
