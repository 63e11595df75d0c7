"""A plant is the same in other units: a torsion rig of a few g·m², a tuning fork, a pendulum clock's tower."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stepid
from broken_campaigns import campaign

PLANTS: dict[str, dict[str, dict[str, float]]] = {
    "coulomb_friction": {"coulomb_friction": {"level": 0.25}},
    "cubic_stiffness": {"cubic_stiffness": {"coefficient": 6e4}},
    "quadratic_damping": {"quadratic_damping": {"coefficient": 8.0}},
    "viscoelastic_spring": {"viscoelastic_spring": {"stiffness": 40.0, "damping": 8.0}},
    "none": {},
}


def in_units(
    told: stepid.Campaign, *, mass: float = 1.0, length: float = 1.0, time: float = 1.0, volts: float = 1.0
) -> stepid.Campaign:
    """The same readings, each unit so many times as large a number."""
    runs = [
        e.model_copy(
            update={
                "time": e.time * time,
                "position": e.position * length,
                "input": e.input * volts,
                "added_mass": e.added_mass * mass,
                "counts_per_meter": None if e.counts_per_meter is None else e.counts_per_meter / length,
            }
        )
        for e in told.experiments
    ]
    return told.model_copy(
        update={"experiments": tuple(runs), "weight_uncertainty": told.weight_uncertainty * math.sqrt(mass)}
    )


@pytest.fixture(scope="module", params=PLANTS)
def told(request: pytest.FixtureRequest) -> tuple[stepid.Campaign, stepid.Diagnosis]:
    made = campaign(11, PLANTS[request.param])
    return made, stepid.diagnose(made)


@pytest.mark.parametrize(
    "units",
    [{"mass": 1e-3}, {"mass": 1e-6}, {"length": 1e-3}, {"length": 1e-5}, {"time": 1e3}, {"volts": 1e3}],
    ids=lambda units: " ".join(f"{name} {times:g}" for name, times in units.items()),
)
def test_an_answer_is_the_same_in_other_units(
    told: tuple[stepid.Campaign, stepid.Diagnosis], units: dict[str, float]
) -> None:
    """Masses below a gram were clipped, forces of 1 N on soft springs ran away, a small motion's cubic term stood."""
    here = told[1]
    there = stepid.diagnose(in_units(told[0], **units))
    assert (there.verdict, there.effects, there.alternatives) == (here.verdict, here.effects, here.alternatives)
    assert there.left == pytest.approx(here.left, rel=1e-3)
    assert there.explained == pytest.approx(here.explained, abs=1e-3)
    mass = there.parameters["base_mass"].value / units.get("mass", 1.0)
    off = abs(mass - here.parameters["base_mass"].value)
    assert off < 0.05 * float(here.parameters["base_mass"].uncertainty or np.inf)
