"""A stop that is met and left within one step of the search: both ends of the step lie before it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hidden.accuracy_cases import COUNTS
from hidden.fast import fast
from hidden.plant import Run
from hidden.reference import reference
from hidden_runs import simulated
from stepid.simulation.simulator import COARSE

M, K, C, GAIN = 1.5, 216.0, 2.0, 7.8
OMEGA = math.sqrt(K / M)
ZETA = C / 2 / math.sqrt(K * M)
PEAK = GAIN / K * (1 + math.exp(-math.pi * ZETA / math.sqrt(1 - ZETA**2)))  # m, of a step of 1 V
ALLOWED = 0.05  # counts, RMS: what a search may be off


def grazing(depth: float, stretch: float, friction: float = 0.0) -> Run:
    """A step whose first peak, without the stop, would lie beyond it by a share `depth`; 14 to 16 samples a period."""
    effects = {"end_stop": {"stiffness": 3000.0, "position": (1 - depth) * PEAK - 2 * friction / K}}
    if friction:
        effects["coulomb_friction"] = {"level": friction}
    return Run(M, K, C, GAIN, 2 * math.pi / OMEGA / 16 * stretch, np.ones(48), effects)


@pytest.mark.parametrize("friction", [0.0, 0.02])
@pytest.mark.parametrize("depth", [1e-2, 1e-3, 2e-4])
def test_a_stop_is_seen_wherever_the_samples_lie(depth: float, friction: float) -> None:
    runs = [grazing(depth, stretch, friction) for stretch in np.linspace(1.0, 1.15, 9)]
    off = [simulated(run, tolerance=COARSE) - reference(run) for run in runs]
    assert max(float(np.sqrt(np.mean(d**2))) for d in off) * COUNTS < ALLOWED


@pytest.mark.parametrize("depth", [1e-4, 1e-6, 1e-8, 1e-10])
def test_a_cart_that_turns_where_it_meets_a_stop_comes_back(depth: float) -> None:
    """Also in the hidden plant, and with friction that is next to none: turn and stop are two events in one place."""
    run = grazing(depth, 1.0, 1e-10)
    told = reference(run)
    assert np.ptp(told[24:]) > 0.2 * PEAK
    assert np.max(np.abs(fast([run])[0] - told)) * COUNTS < 0.01
    assert np.max(np.abs(simulated(run, tolerance=COARSE) - told)) * COUNTS < ALLOWED
