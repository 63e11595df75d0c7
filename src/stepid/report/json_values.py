"""What `--json` prints: plain dictionaries for other programs; samples are left to the files and the library."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import stepid
from stepid.core.base import Model
from stepid.datasets.replication import PaperRebuild
from stepid.diagnosis.result import Diagnosis
from stepid.identification.parameters import IdentifiedParameters
from stepid.identification.transfer.verification import Verification

FORMAT = 1
"""Raised where a key changes its meaning or goes; keys that are added leave it as it is."""


def paper_values(rebuilt: PaperRebuild) -> dict[str, Any]:
    """The paper's numbers rebuilt beside the printed ones, its misprints and the responses' peaks."""
    values = rebuilt.to_dict()
    return _headed() | values | {"responses": _without(rebuilt.responses, {"time", "rebuilt", "printed"})}


def identify_values(campaign: str, parameters: IdentifiedParameters, verified: Verification) -> dict[str, Any]:
    """The identified parameters and how well they fit each run."""
    return _headed() | {
        "campaign": campaign,
        "parameters": parameters.to_dict(),
        "verification": _without(verified.runs, {"time", "measured", "simulated"}),
    }


def diagnosis_values(found: Diagnosis) -> dict[str, Any]:
    """The diagnosis without the records that it is about."""
    values = found.to_dict()
    del values["data"]
    return _headed() | values | {"runs": _without(found.runs, {"time", "measured", "linear", "model"})}


def _headed() -> dict[str, Any]:
    return {"format": FORMAT, "stepid": stepid.__version__}


def _without(models: Iterable[Model], fields: set[str]) -> list[dict[str, Any]]:
    return [{key: value for key, value in model.to_dict().items() if key not in fields} for model in models]
