"""A drive that meets its command between two samples: a step ends there, and the derivatives are smooth beyond it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hidden.plant import Run
from hidden_runs import central, plant_of, simulator_of
from stepid.simulation.simulator import COARSE, FINE

M, K, C, GAIN = 0.956, 132.7, 7.9, 0.797
PERIOD = 0.011  # s, between samples
VOLTS = 2.0


def ramped(rate: float) -> Run:
    """A step that the drive follows at so many volts a second."""
    inputs = np.full(180, VOLTS)
    inputs[:3] = 0.0
    return Run(M, K, C, GAIN, PERIOD, inputs, {"actuator_rate_limit": {"rate": rate}})


def ramp_response(t: np.ndarray) -> np.ndarray:
    """Response at rest to a force that grows by 1 N/s from t = 0 (partial fractions of 1/(s² (m s² + c s + k)))."""
    delta, omega = C / (2 * M), math.sqrt(K / M - (C / (2 * M)) ** 2)
    t = np.maximum(t, 0.0)
    decay = np.exp(-delta * t)
    bent = C / K * np.cos(omega * t) + (C * delta / K - 1.0) / omega * np.sin(omega * t)
    return np.asarray((t - C / K + decay * bent) / K)


def exact(rate: float) -> np.ndarray:
    t = PERIOD * (np.arange(180) - 3)
    return GAIN * rate * (ramp_response(t) - ramp_response(t - VOLTS / rate))


@pytest.mark.parametrize("tolerance", [COARSE, FINE])
@pytest.mark.parametrize("samples", [0.37, 1.0, 1.12, 3.9])
def test_a_ramp_that_ends_between_samples_is_exact(samples: float, tolerance: float) -> None:
    told = ramped(VOLTS / (samples * PERIOD))
    shared, local = plant_of(told, ["actuator_rate_limit"])
    sim = simulator_of(told, tolerance=tolerance)
    off = sim.readings(shared[None], local[None])[0] - exact(shared[-1])
    assert np.abs(off).max() < tolerance * sim.scale


@pytest.mark.parametrize(("tolerance", "off"), [(COARSE, 1e-2), (FINE, 1e-3)])
@pytest.mark.parametrize("samples", np.linspace(0.9, 2.1, 9))
def test_the_derivative_by_a_rate_is_that_of_the_reading(samples: float, tolerance: float, off: float) -> None:
    """Across the corner a step is off by what its tolerance allows, in a way that jumps from one rate to the next."""
    told = ramped(VOLTS / (samples * PERIOD))
    shared, local = plant_of(told, ["actuator_rate_limit"])
    sim, row = simulator_of(told, tolerance=tolerance), shared.size - 1
    reading = sim.readings(shared[None], local[None])[0]
    wanted = np.arange(shared.size) == row
    found = sim.derivatives(shared, local, reading, wanted, np.zeros(local.shape, bool))[0][row]
    slope = (exact(shared[row] * 1.001) - exact(shared[row] * 0.999)) / (0.002 * shared[row])
    assert np.linalg.norm(found - slope) < off * np.linalg.norm(slope)
    np.testing.assert_allclose(central(sim, shared, local, row, 1e-4 * shared[row]), slope, atol=off * abs(slope).max())
