"""The kernel against tight, event-located integration: every effect, steps and releases, thirty combinations."""

from __future__ import annotations

import pytest

from exact_plants import EFFECTS, NEW_EFFECTS
from hidden.accuracy_cases import ALONE, CASES
from hidden_runs import error
from stepid.effects import CATALOGUE
from stepid.simulation.simulator import COARSE, FINE

ALLOWED = 1e-3  # counts, RMS: what a simulation may be off
SEARCHING = 0.05  # counts, RMS: the same in a search
OFTEN = (  # a step with each effect, and what combines events of every kind
    *(f"{name} step" for name in ALONE),
    "power_damping release",
    "cogging release",
    "presliding_hysteresis release",
    "combination 1",
    "combination 10",
    "combination 11",
    "combination 18",
    "combination 28",
    "straight friction",
    "smooth friction",
)


def test_every_effect_of_the_catalogue_is_checked() -> None:
    assert sorted(e.name for e in CATALOGUE) == sorted(ALONE) == sorted([*EFFECTS, *NEW_EFFECTS])


ENTRIES = ("linear step", "straight plain", "smooth plain")
CHAINS = ("straight drive", "smooth drive")  # corners that a rate limit sees only through a cubic
ALLOWED_THERE = 0.015  # counts, RMS


@pytest.mark.parametrize(
    "case", [c if c in (*OFTEN, *CHAINS) else pytest.param(c, marks=pytest.mark.slow) for c in CASES]
)
def test_a_thousandth_of_a_count(case: str) -> None:
    assert error(case) <= (ALLOWED_THERE if case in CHAINS else ALLOWED)
    assert error(case, tolerance=COARSE) <= (0.5 if case in CHAINS else SEARCHING)


def _drives() -> dict[str, tuple[dict[str, dict[str, float]], str]]:
    pairs = (("actuator_rate_limit", "actuator_lag"), ("actuator_dead_zone", "actuator_lag"), ("actuator_lag",))
    return {f"{' + '.join(names)} {way}": ({n: ALONE[n] for n in names}, way) for names in pairs for way in ENTRIES}


@pytest.mark.parametrize("case", _drives())
def test_what_a_lag_sees_between_the_samples(case: str) -> None:
    """The drive before it may bend within a step."""
    effects, entry = _drives()[case]
    assert error((effects, CASES[entry][1])) <= ALLOWED


@pytest.mark.slow
@pytest.mark.parametrize("case", [c for c in CASES if c not in CHAINS])
def test_a_tighter_tolerance_is_nearer_to_the_truth(case: str) -> None:
    """Or as near as rounding and the reference's own error allow."""
    assert error(case, tolerance=FINE / 50) <= max(0.1 * error(case), 2e-5)
