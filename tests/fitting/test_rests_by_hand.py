"""Where each run rests, and how it starts, as a fit reads it off."""

from __future__ import annotations

import pytest

import stepid
from closed_form import Plant, make_run


def test_rest_positions_come_back() -> None:
    plant = Plant(base_mass=0.95, stiffness=216.0, damping=9.0)
    rests = {"a": 0.004, "b": -0.002, "c": 0.0}
    runs = [
        make_run(plant, added, name=name, rest=rest, count=300, noise=1e-6)
        for added, (name, rest) in zip((0.0, 0.5, 1.0), rests.items(), strict=True)
    ]
    found = stepid.fit(stepid.Campaign(name="c", experiments=tuple(runs))).model
    assert {name: state.rest for name, state in found.runs.items()} == pytest.approx(rests, abs=1e-6)
