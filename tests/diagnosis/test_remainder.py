"""What is said of a rest: its shape and the kinds of law that make it, on hidden effects and on short records."""

from __future__ import annotations

import re

import numpy as np
import pytest

import stepid
from hidden.campaigns import Request, make_campaigns
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.explore import linear_candidate
from stepid.diagnosis.locate import locate
from stepid.diagnosis.remainder import NEITHER, UNDRIVEN, Share, remainder, rest_shares
from stepid.diagnosis.shape_in_motion import of_the_linear_plant
from stepid.fitting.fit import prepare
from stepid.fitting.multistart import FitContext


def told(context: FitContext) -> tuple[str, ...]:
    """What is said of the linear plant's rest."""
    return remainder(context, linear_candidate(context), Criteria())


SHAPES = (
    ("coulomb_friction", "velocity", "friction or damping"),
    ("quadratic_damping", "velocity", "friction or damping"),
    ("cubic_stiffness", "position", "springs that bend"),
    ("free_play", "position", "play, stops"),
    ("periodic_disturbance", "line", "steady swing"),
    ("sensor_drift", "slow", "drifting sensor"),
)
IN_THE_MOTION = {
    "input_delay": "a drive with a memory",
    "actuator_lag": "a drive with a memory",
    "viscoelastic_spring": "a spring with a memory",
    "position_dependent_damping": "a damping that depends on position",
}


@pytest.fixture(scope="module")
def contexts() -> dict[str, FitContext]:
    names = [name for name, _, _ in SHAPES] + [*IN_THE_MOTION, "actuator_dead_zone"]
    made = make_campaigns([Request(3, (name,), None, 60.0, "four") for name in names])
    return {name: prepare(campaign) for name, (campaign, _) in zip(names, made, strict=True)}


@pytest.mark.parametrize(("effect", "shape", "words"), SHAPES)
def test_the_largest_share_is_that_of_the_hidden_law(
    effect: str, shape: str, words: str, contexts: dict[str, FitContext]
) -> None:
    context = contexts[effect]
    shares = rest_shares(context, context.linear)
    assert shares[0].shape == shape
    assert shares[0].share > 0.8
    assert [s.share for s in shares] == sorted((s.share for s in shares), reverse=True)
    (said,) = told(context)
    assert words in said
    assert said.startswith(f"{100 * shares[0].share:.0f} % of the rest")


@pytest.mark.parametrize("effect", IN_THE_MOTION)
def test_a_law_that_no_force_shows_is_seen_in_the_motion(effect: str, contexts: dict[str, FitContext]) -> None:
    (said,) = told(contexts[effect])
    assert f"fits {IN_THE_MOTION[effect]}: " in said
    assert float(said.partition(" %")[0]) > 95


def test_a_rest_without_a_shape_is_said_to_have_none(contexts: dict[str, FitContext]) -> None:
    assert told(contexts["actuator_dead_zone"]) == NEITHER


def test_no_law_of_a_drive_is_asked_for_where_nothing_drives() -> None:
    assert UNDRIVEN[0].endswith("time alone. Laws with a memory and shocks leave such a rest.")
    assert "drive" not in UNDRIVEN[0]


def released(count: int, *, stiffness: tuple[float, ...] = (200.0, 200.0), jitter: float = 0.0) -> stepid.Campaign:
    """Linear hand releases with two masses; `stiffness` N/m of each, `jitter` of the stamps in samples."""
    rng = np.random.default_rng(1)
    runs = []
    for i, k in enumerate(stiffness):
        time = 0.02 * np.arange(count) + 0.02 * jitter * rng.uniform(-1, 1, count)
        swing = 0.02 * np.exp(-0.5 * time) * np.cos(np.sqrt(k / (1 + i)) * time)
        position = swing + 2e-5 * rng.normal(size=count)
        run = {"time": time, "position": position, "input": np.zeros(count), "spring": "s", "damper": "d"}
        runs.append(stepid.Experiment(name=f"run {i}", added_mass=float(i), **run))
    return stepid.Campaign(name="released", experiments=tuple(runs))


def test_runs_that_differ_are_told() -> None:
    context = prepare(released(500, stiffness=(200.0, 200.0, 200.0, 240.0)))
    shares = rest_shares(context, context.linear)
    assert shares[0].shape == "run"
    said = told(context)[0]
    assert re.search(r"of its own in every run.*do not repeat", said)


@pytest.mark.parametrize(("times", "alike", "overtone"), [(3.0, True, True), (3.3, True, False), (3.0, False, False)])
def test_a_swing_at_a_multiple_of_the_natural_frequency_is_an_overtone(
    times: float, alike: bool, overtone: bool
) -> None:
    """A shaker shakes all runs alike; an overtone follows the mass."""
    runs, rate = [], np.sqrt(200.0)
    for run in released(600, stiffness=(200.0, 400.0 if alike else 200.0)).experiments:
        louder = run.position + 4e-4 * np.exp(-0.5 * run.time) * np.cos(times * rate * run.time)
        runs.append(run.model_copy(update={"position": louder, "spring": run.name if alike else "s"}))
    context = prepare(stepid.Campaign(name="overtone", experiments=tuple(runs)))
    (said, *_) = told(context)
    assert (", 3 times the natural frequency: a law that bends" in said) is overtone
    assert ("steady swing" in said) is not overtone


@pytest.mark.parametrize(("swings", "steady"), [(1.4, False), (3.5, True)])
def test_one_swing_is_no_steady_one(swings: float, steady: bool) -> None:
    """What swings once or twice within the longest record is as well a drift."""
    runs = []
    for i, run in enumerate(released(600).experiments):
        phase = 2 * np.pi * swings * run.time / run.time[-1] + i
        runs.append(run.model_copy(update={"position": run.position + 1e-3 * np.sin(phase)}))
    context = prepare(stepid.Campaign(name="slow", experiments=tuple(runs)))
    assert any("steady swing" in said for said in told(context)) is steady


@pytest.mark.parametrize("count", [30, 45, 60])
@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_short_and_uneven_releases_do_not_fail(count: int, jitter: float) -> None:
    try:
        context = prepare(released(count, jitter=jitter))
    except stepid.errors.StepidError:
        return  # refused before anything is said of a rest
    said = told(context)
    assert all(s.endswith(".") for s in said)
    assert all(isinstance(s, Share) and 0 <= s.share <= 1 for s in rest_shares(context, context.linear))


def test_the_linear_plants_residual_is_described_by_the_law_that_takes_most(contexts: dict[str, FitContext]) -> None:
    for effect, what in IN_THE_MOTION.items():
        assert re.fullmatch(rf"[\d.]+ % of the residual fits {what}", of_the_linear_plant(contexts[effect]))
    assert of_the_linear_plant(contexts["actuator_dead_zone"]) == ""


def test_where_the_force_has_no_shape_the_motion_tells(contexts: dict[str, FitContext]) -> None:
    context = contexts["input_delay"]
    found = locate(context.records, context.linear, context.floor, otherwise=lambda: of_the_linear_plant(context))
    assert re.fullmatch(
        r"the residual force has no clear shape, but [\d.]+ % of the residual fits a drive with a memory",
        found.sentences[-1],
    )
    plain = locate(context.records, context.linear, context.floor)
    assert "follows neither velocity nor position clearly" in plain.sentences[-1]
