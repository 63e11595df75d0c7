"""A fit to all samples ends early where another with no more in it has left less."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from made_up_evidence import FLOOR, RUNS, SAMPLES, candidate, context
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.polish import polished

NOISE = RUNS * SAMPLES * FLOOR**2


class Slow:
    """A fit that does not converge, and counts how often it goes on."""

    names, deviations, excess = ("cogging", "free_play"), frozenset({"gain"}), 0.0

    def __init__(self, times: float) -> None:
        self.went = 0
        self.polished: Any = SimpleNamespace(cost=times**2 * NOISE, converged=False)
        self.rested = self.polished, self.polished  # at rest it is known already

    def polish(self, *, laps: int, tolerance: float) -> None:
        self.went += 1


@pytest.mark.parametrize(
    ("names", "deviations", "times", "went"),
    [
        (("cogging",), (), 4.0, 1),  # simpler, and leaves less
        (("cogging", "end_stop"), ("gain",), 4.0, 1),
        (("cogging",), (), 6.0, 2),  # leaves more
        (("cogging", "end_stop", "actuator_lag"), (), 4.0, 2),  # has more in it
        (("cogging",), ("damping",), 4.0, 2),  # another condition
        (("cogging", "free_play"), ("gain",), 4.0, 2),  # itself
    ],
)
def test_who_cannot_win_goes_no_further(
    names: Sequence[str], deviations: Sequence[str], times: float, went: int
) -> None:
    fitted: Any = Slow(5.0)
    assert polished(context(), fitted, Effort(), [candidate(names, times=times, deviations=deviations)]) is not None
    assert fitted.went == went


def test_near_the_floor_all_go_on() -> None:
    fitted: Any = Slow(1.3)
    polished(context(), fitted, Effort(), [candidate(("cogging",), times=1.0)])
    assert fitted.went == 2
