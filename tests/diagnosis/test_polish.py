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
from stepid.core.base import Array
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.polish import polished
from stepid.effects import resolve
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.multistart import Start
from sticking_carts import rise, swings

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


def rubbing(noises: Sequence[Array], begins: Sequence[float]) -> list[stepid.Experiment]:
    """Carts of 1 kg and more that 4 N move once, against friction of 1 N and a spring of 400 N/m."""
    time = 0.005 * np.arange(400)
    return [
        stepid.Experiment(
            name=f"run {i}", time=time, position=rise(time - 0.05, mass, 25.0, 400.0, 4.0 - 1.0, begin) + noise,
            input=np.where(time >= 0.05, 0.5, 0.0), added_mass=mass - 1.0, spring="spring", damper="damper",
        )
        for i, (mass, noise, begin) in enumerate(zip((1.0, 1.25, 1.5, 2.0), noises, begins, strict=True))
    ]  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_runs_that_all_begin_where_friction_just_holds_them_are_as_well_at_rest(seed: int) -> None:
    """Steps one way tell neither from the other; there the least push frees a cart, and no derivative shows the way."""
    rng, time = np.random.default_rng(seed), 0.03 * np.arange(150)
    stiffness, damping, push, friction = 250.0, 5.0, 12.0, 0.5  # N/m, N·s/m, N/V and N
    runs = [
        stepid.Experiment(
            name=f"run {added}", time=time, added_mass=added, spring="spring", damper="damper",
            position=swings(time - 0.21, 1.3 + added, damping, stiffness, 1.5 * push, friction)
            + 50e-6 * rng.standard_normal(time.size),
            input=np.where(time > 0.2, 1.5, 0.0),
        )
        for added in (0.0, 0.5, 1.0, 1.5)
    ]  # fmt: skip
    shared = prepare(stepid.Campaign(name="to and fro", experiments=runs))
    fitted = CandidateFit(shared, resolve(("coulomb_friction",)))
    local = np.zeros((fitted.fine.layout.n_run, 4))
    local[0] = -friction / stiffness
    pushed = np.array([1.3, stiffness, damping, push - friction / 1.5, friction])  # by the spring, too, that is bent
    bent = minimize(fitted.fine, pushed, local, tolerance=shared.tolerance)
    assert bent is not None
    assert bent.cost < 1.2 * shared.full_noise_cost
    assert np.all(bent.local[0] < -0.9 * friction / stiffness)
    fitted.best, fitted.polished = bent, bent
    found = polished(shared, fitted, Effort())
    assert found is not None
    assert found.problem.active.sum() == 0
    assert found.shared[-2:] == pytest.approx([push, friction], rel=5e-3)


@pytest.mark.parametrize("offset", [0.0, 0.8])
@pytest.mark.parametrize("seed", [0, 7])
def test_colored_noise_buys_no_initial_states(seed: int, offset: float) -> None:
    """Carts that rub: as many samples say less of a start if their noise is correlated."""
    rng = np.random.default_rng(seed)
    noises = [1.5e-5 * lfilter([1.0], [1.0, -0.95], rng.standard_normal(700))[300:] for _ in range(4)]
    runs = rubbing(noises, [offset * (-1) ** i * 1.0 / 400.0 for i in range(4)])  # of what friction holds
    shared = prepare(stepid.Campaign(name="rubs", experiments=runs))
    (friction,) = resolve(("coulomb_friction",))
    fitted = CandidateFit(shared, (friction,))
    starts = [Start(shared.coarse_linear.shared, (v,)) for v in friction.starts(shared.scales)]
    fitted.begin(starts, like=shared.coarse_linear, iterations=20, patient=True)
    found = polished(shared, fitted, Effort())
    assert found is not None
    assert found.problem.active.sum() == (len(runs) if offset else 0)
