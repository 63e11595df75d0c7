"""What happens and is over within one step of the search: a stop met and left, a cart that moves back for a moment."""

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


def grazing(depth: float, stretch: float, friction: float = 0.0, samples: int = 16) -> Run:
    """A step whose first peak, without the stop, would lie beyond it by a share `depth`; so many samples a period."""
    effects = {"end_stop": {"stiffness": 3000.0, "position": (1 - depth) * PEAK - 2 * friction / K}}
    if friction:
        effects["coulomb_friction"] = {"level": friction}
    return Run(M, K, C, GAIN, 2 * math.pi / OMEGA / samples * stretch, np.ones(3 * samples), effects)


def off(run: Run) -> float:
    """RMS error of the search's simulation, counts."""
    return float(np.sqrt(np.mean((simulated(run, tolerance=COARSE) - reference(run)) ** 2))) * COUNTS


@pytest.mark.parametrize("friction", [0.0, 0.02])
@pytest.mark.parametrize("depth", [1e-2, 1e-3, 2e-4])
def test_a_stop_is_seen_wherever_the_samples_lie(depth: float, friction: float) -> None:
    assert max(off(grazing(depth, stretch, friction)) for stretch in np.linspace(1.0, 1.15, 9)) < ALLOWED
    assert max(off(grazing(depth, stretch, friction, 6)) for stretch in np.linspace(0.9, 1.1, 9)) < ALLOWED


@pytest.mark.parametrize("depth", [1e-4, 1e-6, 1e-8, 1e-10])
def test_a_cart_that_turns_where_it_meets_a_stop_comes_back(depth: float) -> None:
    """Also in the hidden plant, and with friction that is next to none: turn and stop are two events in one place."""
    run = grazing(depth, 1.0, 1e-10)
    told = reference(run)
    assert np.ptp(told[24:]) > 0.2 * PEAK
    assert np.max(np.abs(fast([run])[0] - told)) * COUNTS < 0.01
    assert np.max(np.abs(simulated(run, tolerance=COARSE) - told)) * COUNTS < ALLOWED


@pytest.mark.parametrize(
    ("damping", "level", "amplitude", "frequency", "period", "phase", "size"),
    [(4.222, 0.2853, 0.8106, 11.84, 0.03235, 0.02167, 64), (1.526, 0.6012, 0.5948, 14.68, 0.01015, 3.138, 192)],
)
def test_friction_turns_where_a_cart_moves_back_for_a_moment(
    damping: float, level: float, amplitude: float, frequency: float, period: float, phase: float, size: int
) -> None:
    """Two of 900 plants drawn with a disturbance: both ends of a step move forward, and the cart moves back between."""
    effects = {
        "coulomb_friction": {"level": level},
        "periodic_disturbance": {"amplitude": amplitude, "frequency": frequency},
    }
    assert off(Run(M, K, damping, GAIN, period, np.ones(size), effects, phase=phase)) < ALLOWED
