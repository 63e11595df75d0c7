"""A fit to all samples ends early where another has left less; it keeps the initial states that earn their price."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

import stepid
from made_up_evidence import FLOOR, RUNS, SAMPLES, candidate, context
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.polish import polished
from stepid.effects import resolve
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.fit import prepare
from stepid.fitting.multistart import Start
from sticking_carts import rise

NOISE = RUNS * SAMPLES * FLOOR**2


class Slow:
    """A fit that does not converge, and counts how often it goes on."""

    names, deviations, excess = ("cogging", "free_play"), frozenset({"gain"}), 0.0

    def __init__(self, times: float) -> None:
        self.went = 0
        self.polished: Any = SimpleNamespace(cost=times**2 * NOISE, converged=False)
        self.rested = self.polished, self.polished  # at rest it is known already

    def polish(self, *, iterations: int, tolerance: float) -> None:
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


@pytest.mark.parametrize("offset", [0.0, 0.8])
@pytest.mark.parametrize("seed", [0, 7])
def test_colored_noise_buys_no_initial_states(seed: int, offset: float) -> None:
    """Carts that rub: as many samples say less of a start if their noise is correlated."""
    rng = np.random.default_rng(seed)
    time = 0.005 * np.arange(400)
    runs = []
    for i, mass in enumerate((1.0, 1.25, 1.5, 2.0)):
        noise = 1.5e-5 * lfilter([1.0], [1.0, -0.95], rng.standard_normal(700))[300:]
        begin = offset * (-1) ** i * 1.0 / 400.0  # of what friction holds over the stiffness
        position = rise(time - 0.05, mass, 25.0, 400.0, 4.0 - 1.0, begin) + noise
        runs.append(
            stepid.Experiment(
                name=f"run {i}", time=time, position=position, input=np.where(time >= 0.05, 0.5, 0.0),
                added_mass=mass - 1.0, spring="spring", damper="damper",
            )
        )  # fmt: skip
    shared = prepare(stepid.Campaign(name="rubs", experiments=runs))
    (friction,) = resolve(("coulomb_friction",))
    fitted = CandidateFit(shared, (friction,))
    starts = [Start(shared.coarse_linear.shared, (v,)) for v in friction.starts(shared.scales)]
    fitted.begin(starts, like=shared.coarse_linear, iterations=20, patient=True)
    found = polished(shared, fitted, Effort())
    assert found is not None
    assert found.problem.active.sum() == (len(runs) if offset else 0)
