"""Several effects at once: in whatever order they are given, they leave no more than one of them alone."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

import stepid
from hidden import Run, fast

DRY = {"coulomb_friction": {"level": 0.15}, "load_proportional_friction": {"coefficient": 0.01}}
RUNS = ((0.0, 1.0), (0.5, -1.0), (1.0, 2.0), (0.0, -1.0), (0.5, 2.0), (1.0, 1.0))  # kg, V
TIME = 0.005 * np.arange(600)


def sticking(mass: float, stiffness: float, damping: float, gain: float) -> stepid.Campaign:
    """Two dry frictions: one of them alone leads to another valley, from which there had been no way on."""
    drives = [np.where(TIME < 0.1, 0.0, volts) for _, volts in RUNS]
    plants = [
        Run(
            mass=mass + added, stiffness=stiffness, damping=damping, gain=gain, sample_time=0.005, inputs=u, effects=DRY
        )
        for (added, _), u in zip(RUNS, drives, strict=True)
    ]
    rng = np.random.default_rng(1)
    runs = [
        stepid.Experiment(
            name=f"{i}", time=TIME, position=x + 2e-5 * rng.standard_normal(x.size), input=u, added_mass=RUNS[i][0],
            spring="s", damper="d",
        )
        for i, (x, u) in enumerate(zip(fast(plants), drives, strict=True))
    ]  # fmt: skip
    return stepid.Campaign(name="sticking", experiments=tuple(runs))


@pytest.mark.parametrize("plant", [(1.672, 624.1, 4.694, 2.356), (1.117, 373.3, 4.674, 4.058)])
def test_two_dry_frictions_leave_only_the_noise_in_either_order(plant: tuple[float, ...]) -> None:
    made = sticking(*plant)
    for order in permutations(DRY):
        found = stepid.fit(made, effects=order)
        assert [name.partition(".")[0] for name in found.parameters][-2:] == list(order)
        assert found.rms < 1.1 * found.noise
