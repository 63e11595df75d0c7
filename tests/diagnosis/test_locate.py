"""Where the linear model disagrees: phases from the closed form, forces from hidden effects, trends of made-up runs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import stepid
from closed_form import SAMPLE_TIME, Plant, make_run
from hidden.campaigns import Request, make_campaigns
from stepid.core.experiment import Campaign
from stepid.diagnosis.locate import locate, phases_of, run_trends
from stepid.diagnosis.phases import BEFORE, DRIVEN, OVERSHOOT, PHASES, REST, RING_DOWN, RISE, phase_of_samples
from stepid.diagnosis.residual_force import SHAPES, Shape, bump, residual_force, shape
from stepid.diagnosis.wording import sentences
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.noise_floor import noise_floor
from stepid.fitting.problem import fit_linear
from stepid.fitting.spectrum import strongest_period
from stepid.fitting.weak_form import measured_motion
from stepid.simulation.records import Records, lay_out

PLANT = Plant(base_mass=0.95, stiffness=216.0, damping=8.0)
START = 12


def fitted(campaign: Campaign) -> tuple[Records, Optimum, float]:
    records = lay_out(campaign)
    linear = fit_linear(records)
    assert linear is not None
    return records, linear, noise_floor(records)


def steps(**changes: object) -> Campaign:
    """Linear runs with two masses, as they come from the closed form."""
    fields = {"noise": 2e-6, "count": 900, "steps": ((START, 0.5),)} | changes
    rng = np.random.default_rng(4)
    return Campaign(
        name="linear",
        experiments=tuple(make_run(PLANT, m, name=f"{m} kg", rng=rng, **fields) for m in (0.5, 2.0)),  # type: ignore[arg-type]
    )


def labels(campaign: Campaign) -> list[np.ndarray]:
    records, linear, floor = fitted(campaign)
    motion = measured_motion(records, linear.shared, floor, strongest_period(records))
    phase = phase_of_samples(records, linear, motion, floor)
    return [phase[piece] for piece in records.pieces()]


def test_a_cart_that_an_input_holds_is_where_it_holds_it() -> None:
    """A step off is a step on, seen from where it begins: positions count from where the spring rests."""
    on = steps().experiments
    off = [
        run.model_copy(update={"input": 0.5 - run.input, "input_before": 0.5, "position": -run.position}) for run in on
    ]
    both = Campaign(
        name="on and off", experiments=(*on, *(run.model_copy(update={"name": f"off {run.name}"}) for run in off))
    )
    records, linear, floor = fitted(both)
    motion = measured_motion(records, linear.shared, floor, strongest_period(records))
    held = PLANT.gain / PLANT.stiffness * 0.5
    pieces = records.pieces()
    for up, down in zip(pieces[:2], pieces[2:], strict=True):
        np.testing.assert_allclose(motion.x[down], held - motion.x[up], atol=2e-3 * held)
        assert abs(motion.x[down][-50:].mean()) < 2e-3 * held
    phase = phase_of_samples(records, linear, motion, floor)
    for up, down in zip(pieces[:2], pieces[2:], strict=True):
        assert np.mean(phase[up] != phase[down]) < 0.01


def test_phases_begin_where_the_closed_form_says() -> None:
    for added, label in zip((0.5, 2.0), labels(steps()), strict=True):
        frequency = PLANT.rates(added)[1]
        steady = PLANT.gain / PLANT.stiffness * 0.5

        def swing(t: float, added: float = added, steady: float = steady) -> float:
            return float(PLANT.response(np.array([t]), added, ((0.0, 0.5),))[0]) - steady

        first = brentq(swing, 1e-3, np.pi / frequency)
        times = SAMPLE_TIME * np.arange(label.size - START)
        far = np.abs([swing(t) for t in times]) > 0.02 * steady
        settled = int(np.flatnonzero(far)[-1]) + 1 + START
        expected = {
            RISE: START,
            OVERSHOOT: START + first / SAMPLE_TIME,
            RING_DOWN: START + (first + np.pi / frequency) / SAMPLE_TIME,
            REST: settled,
        }
        assert set(label[:START]) == {BEFORE}
        assert np.all(np.diff(label) >= 0)
        for phase, begin in expected.items():
            assert abs(int(np.flatnonzero(label == phase)[0]) - begin) <= 2, PHASES[phase]


def test_a_step_back_begins_the_phases_again() -> None:
    (label, _) = labels(steps(steps=((START, 0.5), (400, -0.5))))
    assert label[399] == REST
    assert set(label[400:405]) == {RISE}
    assert label[-1] == REST


def test_a_step_too_small_to_see_is_rest() -> None:
    (label, _) = labels(steps(steps=((START, 0.5), (600, 1e-1)), noise=1e-3))
    assert np.mean(label[700:] == REST) > 0.9


def test_release_rings_down_and_rests() -> None:
    time = SAMPLE_TIME * np.arange(900)
    runs = []
    for added in (0.0, 1.5):
        decay, frequency = PLANT.rates(added)
        x = 0.02 * np.exp(-decay * time) * (np.cos(frequency * time) + decay / frequency * np.sin(frequency * time))
        fields = {"added_mass": added, "spring": "medium", "damper": "none", "name": f"{added}"}
        runs.append(stepid.Experiment(time=time, position=x, input=0 * time, **fields))
    for run, label in zip(runs, labels(Campaign(name="releases", experiments=tuple(runs))), strict=True):
        settled = int(np.flatnonzero(np.abs(run.position) > 0.02 * np.ptp(run.position))[-1]) + 1
        assert set(label) == {RING_DOWN, REST}
        assert abs(int(np.flatnonzero(label == REST)[0]) - settled) <= 5  # smoothing flattens a peak that grazes


def test_an_input_without_steps_drives() -> None:
    volts = np.random.default_rng(3).standard_normal(300)
    changes = tuple((START + i, v) for i, v in enumerate(np.diff(volts, prepend=0.0, append=0.0)))
    for label in labels(steps(steps=changes, noise=1e-5)):
        assert set(label[:START]) == {BEFORE}
        assert set(label[START : START + 300]) == {DRIVEN}
        assert label[START + 302] == RING_DOWN
        assert label[-1] == REST


def test_phase_rms_is_that_of_the_samples() -> None:
    campaign = stepid.datasets.lab_campaign()
    records, linear, floor = fitted(campaign)
    where, each = locate(records, linear, floor), phases_of(records, linear, floor)
    assert list(where.phases) == [p for p in PHASES if p in where.phases]
    residual, total = linear.residual, dict.fromkeys(where.phases, 0.0)
    for name, piece, label in zip(where.runs, records.pieces(), labels(campaign), strict=True):
        assert where.runs[name] == pytest.approx(float(np.sqrt(np.mean(residual[piece] ** 2))))
        for phase, rms in each[name].items():
            square = residual[piece][label == PHASES.index(phase)] ** 2
            assert rms == pytest.approx(float(np.sqrt(square.mean())))
            total[phase] += float(square.sum())
    assert sum(total.values()) == pytest.approx(float(residual @ residual))
    assert max(where.phases, key=lambda p: where.phases[p]) == "ring-down"


@pytest.mark.parametrize("half", [3, 5, 12])
def test_bump_is_exact_for_a_parabola(half: int) -> None:
    time = 0.01 * np.arange(-half, half + 1)
    kernels = bump(half, 0.01)
    for power, exact in enumerate([(1, 0, 0), (0, 1, 0), (None, 0, 2)]):
        for kernel, value in zip(kernels, exact, strict=True):
            if value is not None:
                assert np.convolve(time**power, kernel, "valid")[0] == pytest.approx(value, abs=1e-9)


HIDDEN = (
    ("coulomb_friction", "level", "sign of velocity"),
    ("quadratic_damping", "coefficient", "velocity squared"),
    ("quadratic_stiffness", "coefficient", "position squared"),
    ("cubic_stiffness", "coefficient", "position cubed"),
)


@pytest.fixture(scope="module")
def hidden() -> dict[str, tuple[Campaign, dict[str, object]]]:
    made = make_campaigns([Request(3, (name,), None, 60.0, "four") for name, _, _ in HIDDEN])
    return {name: one for (name, _, _), one in zip(HIDDEN, made, strict=True)}


@pytest.mark.parametrize(("effect", "parameter", "expected"), HIDDEN)
def test_residual_force_shows_the_hidden_law(
    effect: str, parameter: str, expected: str, hidden: dict[str, tuple[Campaign, dict[str, dict[str, float]]]]
) -> None:
    campaign, truth = hidden[effect]
    records, linear, floor = fitted(campaign)
    motion = measured_motion(records, linear.shared, floor, strongest_period(records))
    phase = phase_of_samples(records, linear, motion, floor)
    found = shape(residual_force(records, linear, motion, phase, floor))
    assert found is not None
    assert found.name == expected
    assert found.share > 0.85
    assert -found.coefficient == pytest.approx(truth["parameters"][f"{effect}.{parameter}"], rel=0.05)


def test_coulomb_is_a_step_and_a_cubic_a_cubic(
    hidden: dict[str, tuple[Campaign, dict[str, dict[str, float]]]],
) -> None:
    campaign, truth = hidden["coulomb_friction"]
    where = locate(*fitted(campaign))
    level = truth["parameters"]["coulomb_friction.level"]
    v, force = where.velocity_levels, where.velocity_force
    fast = np.abs(v) > 0.25 * np.abs(v).max()
    np.testing.assert_allclose(force[fast], -level * np.sign(v[fast]), rtol=0.25)
    assert any("jumps by" in sentence for sentence in where.sentences)
    campaign, truth = hidden["cubic_stiffness"]
    where = locate(*fitted(campaign))
    x, force = where.position_levels, where.position_force
    cubic = -truth["parameters"]["cubic_stiffness.coefficient"] * x**3
    assert np.corrcoef(force, cubic)[0, 1] > 0.97
    assert np.ptp(force - cubic) < 0.35 * np.ptp(cubic)
    assert any("stiffer away from rest" in sentence for sentence in where.sentences)


def test_a_linear_plant_disagrees_nowhere() -> None:
    where = locate(*fitted(steps(noise=2e-5)), enough=True)
    assert len(where.sentences) == 1
    assert where.sentences[0].startswith("nowhere")


def test_trends_compare_runs_with_the_same_spring_and_damper() -> None:
    plants = [(0.0, "a"), (1.0, "a"), (2.0, "a"), (0.0, "b")]
    runs = tuple(
        make_run(PLANT, m, name=f"{m} {d}", damper=d, steps=((START, size),), noise=1e-6)
        for (m, d), size in zip(plants, (0.5, 0.5, 0.5, -0.7), strict=True)
    )
    records, linear, _ = fitted(Campaign(name="c", experiments=runs))
    found = run_trends(records, linear, np.array([1e-4, 2e-4, 3e-4, 9e-4]))
    assert found == {"mass": pytest.approx(1.0)}  # size and direction vary with the damper only
    flipped = run_trends(records, linear, np.array([3e-4, 2e-4, 1e-4, 9e-4]))
    assert flipped["mass"] == pytest.approx(-1.0)


def test_sentences_say_what_was_found() -> None:
    kind = Shape("sign of velocity", -0.3, 0.8, np.zeros(1))
    phases = {"rise": 1e-4, "ring-down": 1.2e-3, "rest": 2e-5}
    trends = {"mass": 0.91, "size": 0.2, "direction": -0.8}
    said = sentences(6e-4, 2e-5, phases, {"a": 1e-4, "b": 9e-4}, trends, kind)
    assert said == (
        "largest in the ring-down (1.20 mm RMS); at the noise at rest",
        "most in run 'b' (900 µm), least in run 'a' (100 µm)",
        "grows with mass (correlation +0.91)",
        "larger in runs that go down (correlation 0.80)",
        "the residual force jumps by 0.6 N where the velocity changes sign, like friction of 0.3 N either way "
        "(80 % of the force that no spring or damper gives)",
    )
    along = sentences(6e-4, 2e-5, phases, {"a": 1e-4}, {}, Shape("sign of velocity", 0.3, 0.8, np.zeros(1)))
    assert "jumps by 0.6 N where the velocity changes sign (80 %" in along[-1]  # no friction pushes
    vague = sentences(6e-4, 2e-5, {"rise": 6e-4}, {"a": 6e-4}, {}, Shape(SHAPES[1], 1.0, 0.1, np.zeros(1)))
    assert vague[0] == "largest in the rise (600 µm RMS)"
    assert "look at the drive" in vague[-1]
    quiet = {"before": 2e-5, "rest": 3e-5, "rise": 2.5e-5, "ring-down": 1e-3}
    mixed = sentences(6e-4, 2e-5, quiet, {"a": 6e-4}, {}, None)[0]
    assert mixed.endswith("; at the noise at rest, in the rise and before the first step")
    faint = sentences(2.5e-5, 2e-5, {"rest": 2.8e-5, "rise": 2e-5}, {"a": 2.5e-5}, {}, None)[0]
    assert faint == "largest at rest (28.0 µm RMS), little above the noise in every phase"
    assert sentences(6e-4, 2e-5, {"rise": 6e-4}, {"a": 6e-4}, {}, None)[-1].startswith("too little motion")


def test_too_little_motion_has_no_shape() -> None:
    short = steps(count=40, noise=1e-4)
    where = locate(*fitted(short))
    assert where.velocity_levels.size == where.velocity_force.size
    assert np.isfinite(where.velocity_force).all()


def test_releases_are_told_without_steps_and_drive() -> None:
    trends = {"size": 0.95, "direction": -0.9}
    runs = {"a": 1e-4, "b": 9e-4}
    phases = {"ring-down": 6e-4}
    said = sentences(6e-4, 2e-5, phases, runs, trends, Shape(SHAPES[1], 1.0, 0.1, np.zeros(1)), driven=False)
    assert "grows with how far from rest a run starts (correlation +0.95)" in said
    assert "larger in runs that start below rest (correlation 0.90)" in said
    assert said[-1].endswith("look at the reading or time, too")
