"""Noise that is slower, and so larger, than the readings tell: the linear plant is enough where nothing follows it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

import stepid
from hidden.campaigns import Request, make_campaigns
from scattered_campaigns import scattered
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.explore import linear_candidate
from stepid.diagnosis.loud_noise import louder_in_motion, trace
from stepid.diagnosis.phases import BEFORE, REST, phase_of_samples
from stepid.diagnosis.selection.candidate import Candidate
from stepid.fitting.deviations import with_deviations
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.multistart import FitContext

LATE = (0.6, -0.5, 0.3, -0.7, 0.4, -0.1)  # samples


def wandering(seed: int, size: float) -> stepid.Campaign:
    """Runs that start late by chance, with first-order noise of 25 samples and so many m on their readings."""
    rng, stays = np.random.default_rng(seed), np.exp(-1 / 25)
    whole, runs = scattered(seed, late=LATE), []
    for run in whole.experiments:
        noise = lfilter([np.sqrt(1 - stays**2)], [1.0, -stays], rng.standard_normal(run.time.size))
        runs.append(run.model_copy(update={"position": run.position + size * noise}))
    return whole.model_copy(update={"experiments": tuple(runs)})


def explored_starts(context: FitContext) -> list[Candidate]:
    """The linear plant with start times that are alike, and that differ."""
    plain = linear_candidate(context)
    problem = with_deviations(plain.optimum.problem, ("start_time",))
    fitted = minimize(problem, plain.optimum.shared, plain.optimum.local)
    assert fitted is not None
    return [plain, replace(plain, deviations=frozenset({"start_time"}), optimum=fitted)]


def test_runs_that_start_late_beside_slow_noise_leave_nothing_unexplained() -> None:
    d = stepid.diagnose(wandering(1, 1.2e-5))
    assert (d.verdict, d.effects) == ("adequate", ())
    assert 1.1 < d.gap.after / d.gap.noise < 1.5
    assert d.gap.after < 0.1 * d.gap.before
    assert "the noise is larger than it looks" in d.reasons[-1]
    assert "start_time" in d.scatter


def test_a_hand_that_touches_the_cart_is_no_noise() -> None:
    """It is not there while the cart rests."""
    d = stepid.diagnose(make_campaigns([Request(11, (), "bump", 1.7)])[0][0])
    assert (d.verdict, d.effects) == ("unexplained", ())
    assert d.gap.before / d.gap.noise < 2


def test_noise_is_as_large_while_the_cart_rests() -> None:
    context = prepare(wandering(1, 1.2e-5))
    late = next(c for c in explored_starts(context) if c.deviations)
    assert not louder_in_motion(context, Criteria(), late)
    assert louder_in_motion(context, Criteria(), linear_candidate(context))


@pytest.mark.parametrize(("moving", "louder"), [(1.05, False), (1.15, True)])
def test_by_how_much_it_may_be_louder_is_what_the_floor_is_known_to(moving: float, louder: bool) -> None:
    """A floor that was read 3 per cent too high leaves next to nothing where the cart rests."""
    context = prepare(scattered(3))
    plain = linear_candidate(context)
    phase = phase_of_samples(context.records, context.linear, context.measured, context.floor)
    resting = (phase == BEFORE) | (phase == REST)
    white = np.random.default_rng(1).standard_normal(resting.size)
    left = context.floor * np.where(resting, 1.005, moving) * white * context.records.weight
    problem: Any = SimpleNamespace(residual=lambda _: left)
    optimum: Any = SimpleNamespace(problem=problem, solved=None)
    assert louder_in_motion(context, Criteria(), replace(plain, optimum=optimum)) is louder


@pytest.mark.parametrize(("effects", "state"), [((), ""), (("cubic_stiffness",), "position")])
def test_a_law_leaves_a_trace_and_noise_none(effects: tuple[str, ...], state: str) -> None:
    context = prepare(make_campaigns([Request(3, effects, None, 8.0 if effects else None, "four")])[0][0])
    found = trace(context, Criteria(), linear_candidate(context))
    assert bool(found) == bool(state)
