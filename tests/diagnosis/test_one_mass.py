"""Runs of one mass: friction that goes with the weight is Coulomb friction there, and both are told."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from hidden import Run, fast

NAMES = ("coulomb_friction", "load_proportional_friction")


@pytest.mark.parametrize("hidden", [{NAMES[0]: {"level": 0.15}}, {NAMES[1]: {"coefficient": 0.01}}])
def test_both_laws_are_answers(hidden: dict[str, dict[str, float]]) -> None:
    rng, time = np.random.default_rng(2), 0.01 * np.arange(400)
    runs = [
        Run(
            mass=1.5, stiffness=400.0, damping=3.0, gain=1.0, sample_time=0.01, inputs=np.zeros(time.size),
            effects=hidden, position=begin,
        )
        for begin in (0.02, 0.015, -0.018)
    ]  # fmt: skip
    found = stepid.diagnose(
        stepid.Campaign(
            name="one mass",
            experiments=[
                stepid.Experiment(
                    name=f"case {i}", time=time, position=x + 5e-6 * rng.standard_normal(time.size),
                    input=np.zeros(time.size), added_mass=0.0, spring="s", damper="d",
                )
                for i, x in enumerate(fast(runs))
            ],
        )
    )  # fmt: skip
    assert found.verdict == "ambiguous"
    assert {(name,) for name in NAMES} <= {found.effects, *found.alternatives}
    assert found.next_experiment is not None
    assert "half of the moving mass added" in found.next_experiment
