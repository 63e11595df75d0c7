"""Starts of dry friction by where runs begin and come to rest."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.effects import resolve
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.fit import prepare
from stepid.fitting.multistart_held import held_starts
from sticking_carts import campaign

(FRICTION,) = resolve(["coulomb_friction"])
MASS, DAMPING, STIFFNESS, GAIN, LEVEL, NOISE = 1.5, 120.0, 400.0, 10.0, 1.2, 2e-6


def creeping(*starts: float, level: float = LEVEL) -> stepid.Campaign:
    """Carts of much damping that a step moves from where friction held them to where it holds them again."""
    rng = np.random.default_rng(5)
    runs = []
    for i, (start, added) in enumerate(zip(starts, (0.0, 0.5, 1.0), strict=False)):
        time = 0.005 * np.arange(600)
        mass, end = MASS + added, (GAIN * 0.5 - level) / STIFFNESS
        rates = np.roots([mass, DAMPING, STIFFNESS]).real
        after = np.maximum(time - 0.1, 0.0)
        moved = (rates[1] * np.exp(rates[0] * after) - rates[0] * np.exp(rates[1] * after)) / (rates[1] - rates[0])
        x = end + (start - end) * moved + NOISE * rng.standard_normal(time.size)
        volts = np.where(time >= 0.1, 0.5, 0.0)
        runs.append(
            stepid.Experiment(
                name=f"run {i}", time=time, position=x, input=volts, added_mass=added, spring="s", damper="d"
            )
        )
    return stepid.Campaign(name="creeping", experiments=runs)


def test_starts_hold_every_run_where_it_began() -> None:
    begun = np.array([-1.5e-3, 0.2e-3, 2.0e-3])
    fit = prepare(creeping(*begun))
    starts = held_starts(fit, FRICTION)
    assert starts
    layout = fit.coarse_linear.problem.layout
    for start in starts:
        stiffness, ((level,),) = float(start.linear[layout.stiffness][0]), start.values
        assert start.displacement is not None
        assert np.abs(start.displacement).max() * stiffness <= level * (1 + 1e-9)
        assert np.diff(start.displacement) == pytest.approx(np.diff(begun), rel=0.02)


def test_no_start_where_travels_tell_of_no_friction() -> None:
    assert held_starts(prepare(creeping(0.0, 0.0, 0.0, level=0.0)), FRICTION) == []
    assert held_starts(prepare(creeping(1e-3)), FRICTION) == []  # one run alone
    assert held_starts(prepare(stepid.datasets.lab_campaign()), *resolve(["cubic_stiffness"])) == []


def test_runs_that_start_in_motion_are_left_alone() -> None:
    held = creeping(-1.5e-3, 0.2e-3, 2.0e-3).experiments
    moving = held[0].slice(40, 600, name="moves").model_copy(update={"starts": "motion"})
    fit = prepare(stepid.Campaign(name="both", experiments=[*held, moving]))
    for start in held_starts(fit, FRICTION):
        assert start.displacement is not None
        assert np.isnan(start.displacement).tolist() == [False, False, False, True]


@pytest.mark.parametrize("seed", [10, 101, 221, 225, 301, 417])
def test_friction_alone_reaches_the_floor_from_there(seed: int) -> None:
    """Mass and stiffness of the linear plant are off by up to a thousand times."""
    fit = prepare(campaign(seed))
    ended = []
    for start in held_starts(fit, FRICTION):
        found = CandidateFit(fit, (FRICTION,))
        found.begin([start], like=fit.coarse_linear)
        found.run(iterations=15)
        ended.append(found.cost)
    assert min(ended) < fit.noise_limit
