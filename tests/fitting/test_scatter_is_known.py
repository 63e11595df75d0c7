"""What a strength is known to beside gains that differ: by coverage, with few runs and with more."""

from __future__ import annotations

import numpy as np
import pytest

from scattered_campaigns import scattered
from stepid.effects import resolve
from stepid.fitting.covariance import estimates
from stepid.fitting.deviations import with_deviations
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.levenberg_marquardt import minimize

LEVEL = 0.03  # V


@pytest.mark.slow
@pytest.mark.parametrize(
    ("volts", "masses", "determined"),
    [
        ((0.5, 0.2), (0.0, 1.0), (0.0, 0.0)),  # two runs do not tell a dead zone from gains that differ
        ((0.5, 0.2, 0.35), (0.0, 1.0, 2.0), (0.3, 0.7)),
        ((0.5, -0.5, 0.5, 0.2, 0.3, -0.2), (0.0, 0.5, 1.5, 2.0, 1.0, 0.25), (0.95, 1.0)),
    ],
)
def test_a_dead_zone_beside_gains_that_differ_is_covered(
    volts: tuple[float, ...], masses: tuple[float, ...], determined: tuple[float, float]
) -> None:
    """Gains differ by 1 %, which steps tell from a dead zone by the size of the input alone."""
    effects, covered, narrow = resolve(["actuator_dead_zone"]), [], []
    for seed in range(60):
        drawn = 0.01 * np.random.default_rng(100 + seed).standard_normal(len(volts))
        gain = [(1 + d) * (abs(v) - LEVEL) / abs(v) - 1 for d, v in zip(drawn, volts, strict=True)]
        context = prepare(scattered(seed, masses=masses, volts=volts, gain=gain))
        fitted = fit_effects(context, effects)
        assert fitted is not None
        free = minimize(with_deviations(fitted.problem, ("gain",)), fitted.shared, fitted.local)
        assert free is not None
        found = estimates(free, effects, context.floor)[0]["actuator_dead_zone.level"]
        error = found.uncertainty or np.inf
        covered.append(abs(found.value - LEVEL) < 1.96 * error)
        narrow.append(error < LEVEL / 2)
    assert np.mean(covered) >= 0.87  # 0.95 less three standard errors of 60
    low, high = determined
    assert low <= np.mean(narrow) <= high
