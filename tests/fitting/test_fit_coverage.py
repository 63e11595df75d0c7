"""Coverage of the joint fit's intervals: how often the named effect's parameters lie within 95 %."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from hidden.campaigns import Request, make_campaigns

CASES = {"coulomb_friction": 15, "cubic_stiffness": 15, "quadratic_damping": 15, "input_delay": 15}


@pytest.mark.slow
def test_intervals_cover_the_truth_as_often_as_they_say() -> None:
    wanted = [
        Request(77000 + 100 * i + j, (name,), r0=5.0, kind="five")
        for i, (name, count) in enumerate(CASES.items())
        for j in range(count)
    ]
    off = []
    for campaign, truth in make_campaigns(wanted):
        exact = campaign.model_copy(update={"weight_uncertainty": 1e-9})
        found = stepid.fit(exact, effects=truth["effects"])
        for name, value in truth["parameters"].items():
            estimate = found.parameters[name]
            assert estimate.uncertainty is not None, (campaign.name, name)
            off.append((estimate.value - value) / estimate.uncertainty)
    z = np.array(off)
    covered = float(np.mean(np.abs(z) < 1.96))
    assert covered > 0.95 - 3 * np.sqrt(0.95 * 0.05 / z.size), f"{100 * covered:.1f} % of {z.size}"
    spread = float(np.sqrt(np.mean(z**2)))
    assert 0.75 < spread < 1.28, f"standard scores spread by {spread:.2f}"  # ±3/√(2·60)
    assert abs(np.mean(z)) < 3 / np.sqrt(z.size), f"standard scores are off by {np.mean(z):.2f} on average"
    print(f"coverage {100 * covered:.1f} % of {z.size}, spread {spread:.2f}, mean {np.mean(z):+.2f}")
