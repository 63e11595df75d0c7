"""Records that begin in motion: an effect's own states are free in every run, and have to predict as a phase does."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import stepid
from hidden import Run, fast
from stepid.diagnosis.selection.candidate import Candidate, free_effects
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects

TIME = 0.01 * np.arange(300)
CASES = (("a", 0.0, 0.03), ("b", 0.0, -0.02), ("c", 0.5, 0.025), ("d", 0.5, 0.04), ("e", 1.0, -0.03))
MODE = {"flexible_coupling": {"mass": 0.12, "stiffness": 400.0, "damping": 0.3}}


def releases(clocks: Sequence[float], effects: dict[str, dict[str, float]], seed: int = 0) -> stepid.Campaign:
    """Free releases, each read by a clock that is so many times as fast as it says."""
    rng, runs = np.random.default_rng(seed), []
    for (name, added, begin), clock in zip(CASES, clocks, strict=True):
        (x,) = fast(
            [
                Run(
                    mass=1.0 + added, stiffness=350.0, damping=4.0, gain=1.0, sample_time=0.01 * clock,
                    inputs=np.zeros(TIME.size), effects=effects, position=begin,
                )
            ]
        )  # fmt: skip
        runs.append(
            stepid.Experiment(
                name=name, time=TIME, position=x + 15e-6 * rng.standard_normal(TIME.size), input=np.zeros(TIME.size),
                added_mass=added, spring="s", damper="d",
            )
        )  # fmt: skip
    return stepid.Campaign(name="releases", experiments=runs)


def test_a_clock_that_is_fast_is_no_second_mass() -> None:
    """A mode of no weight follows any run by the states in which it begins, and predicts nothing of its rest."""
    found = stepid.diagnose(releases((1.0, 1.0, 1.01, 1.0, 1.0), {}))
    assert found.verdict == "unexplained"
    assert found.effects == ()


def test_a_second_mass_is_named() -> None:
    found = stepid.diagnose(releases((1.0,) * 5, MODE))
    assert (found.verdict, found.effects) == ("named", ("flexible_coupling",))


def test_states_are_a_freedom_where_every_run_begins_in_motion() -> None:
    coupling, spring = resolve(["flexible_coupling"]), resolve(["cubic_stiffness"])
    campaign = releases((1.0,) * 5, {})
    driven = [
        e.model_copy(update={"name": f"{e.name} again", "input": np.where(TIME < 0.5, 0.0, 1.0), "position": at_rest()})
        for e in campaign.experiments[:2]
    ]
    mixed = campaign.model_copy(update={"experiments": (*campaign.experiments, *driven)})
    for some, free in ((campaign, coupling), (mixed, ())):
        context = prepare(some)
        for effects, expected in ((coupling, free), (spring, ())):
            fitted = fit_effects(context, effects)
            assert fitted is not None
            assert free_effects(Candidate(effects, frozenset(), fitted, 0.0)) == expected


def at_rest() -> np.ndarray:
    """A step's reading in closed form, of a damped cart at rest before it."""
    late = np.maximum(TIME - 0.5, 0.0)
    noise = 15e-6 * np.random.default_rng(7).standard_normal(TIME.size)
    return 0.01 * (1.0 - np.exp(-2.0 * late) * (np.cos(18.6 * late) + 2.0 / 18.6 * np.sin(18.6 * late))) + noise
