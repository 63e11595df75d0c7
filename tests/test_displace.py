"""Starting displacements under friction: the scan leaves the minima that a descent cannot."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.effects import resolve
from stepid.engine.displace import resettle, scan_displacements
from stepid.engine.least_squares import minimize
from stepid.engine.problem import build, fit_linear, start_local
from stepid.engine.records import lay_out

TRUTH = stepid.datasets.lab_truth()


def test_the_made_up_campaign_settles_at_its_noise() -> None:
    records = lay_out(stepid.datasets.lab_campaign())
    linear = fit_linear(records)
    assert linear is not None
    problem = build(records, resolve(["coulomb_friction"]))
    stuck = minimize(problem, np.append(linear.shared, 0.2), start_local(problem, linear), iterations=12)
    assert stuck is not None
    assert stuck.rms > 2 * TRUTH.noise_rms  # a minimum with another pattern of sticking
    scanned = scan_displacements(stuck)
    np.testing.assert_array_equal(scanned[1:], stuck.local[1:])
    found = resettle(stuck, tolerance=0.0)
    assert found.rms < 1.03 * TRUTH.noise_rms
    assert found.shared[-1] == pytest.approx(TRUTH.parameters["coulomb_friction.level"], rel=3e-3)


def test_a_linear_plant_comes_back_as_it_is() -> None:
    records = lay_out(stepid.datasets.lab_campaign())
    linear = fit_linear(records)
    assert linear is not None
    assert resettle(linear, tolerance=0.0) is linear
