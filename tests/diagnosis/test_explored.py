"""What a search may look among: nothing that the records cannot hold."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stepid import Criteria, Effort
from stepid.diagnosis import explore
from stepid.effects import CATALOGUE
from stepid.effects.drive import acts_on_input

OF_THE_DRIVE = {"actuator_lag", "input_delay", "actuator_dead_zone", "actuator_saturation", "actuator_rate_limit"}


def test_effects_of_the_drive_are_those_that_change_the_input() -> None:
    assert {e.name for e in CATALOGUE if acts_on_input(e)} == OF_THE_DRIVE


@pytest.mark.parametrize("driven", [False, True])
def test_where_nothing_is_driven_no_effect_of_the_drive_is_looked_for(
    driven: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[set[str]] = []

    def search(_: object, catalogue: Any, **__: object) -> Any:
        asked.append({e.name for e in catalogue})
        return SimpleNamespace(run=list)

    monkeypatch.setattr(explore, "Search", search)
    context: Any = SimpleNamespace(records=SimpleNamespace(driven=np.array([False, driven])))
    explore._search(context, CATALOGUE, Criteria(), Effort(), lambda _: None)
    assert asked == [{e.name for e in CATALOGUE} - (set() if driven else OF_THE_DRIVE)]
