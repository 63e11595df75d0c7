"""Blind campaigns: the same from the same seed, of the wanted visibility, recovered by a fit, and telling nothing."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stepid
from stepid import lab
from stepid.effects import CATALOGUE
from stepid.errors import InputError

SMALL = lab.Rig(
    runs=(
        lab.RunPlan(name="run 1", added_mass=0.0, level=0.5),
        lab.RunPlan(name="run 2", added_mass=1.0, level=-0.4),
    ),
    hold=1.2,
    after=0.6,
)
LEVEL = stepid.EffectModel(name="coulomb_friction", values={"level": 0.123456})
PASSPHRASE = "correct horse battery"


def small(**fields):
    effects = {"A": (LEVEL,), "B": ()}
    standard = {"seed": "tests of blind campaigns", "groups": ("A", "B"), "effects": effects, "rig": SMALL}
    return lab.make(**{**standard, **fields})


@pytest.fixture(scope="module")
def coulomb() -> lab.Assignment:
    return lab.make(seed=110000000000, groups=("A",), effects=("coulomb_friction",))


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def students(folder: Path) -> dict[str, bytes]:
    return {name: raw for name, raw in contents(folder).items() if name != "answers.sealed"}


def test_the_same_seed_makes_the_same_folders_byte_for_byte(tmp_path):
    for name in ("one", "two"):
        small().write(tmp_path / name, passphrase=PASSPHRASE)
    assert students(tmp_path / "one") == students(tmp_path / "two")
    assert len(students(tmp_path / "one")) == 2 * (len(SMALL.runs) + 2)
    opened = [lab.open_answers(tmp_path / name, passphrase=PASSPHRASE) for name in ("one", "two")]
    assert opened[0] == opened[1] == small().answers
    assert (tmp_path / "one" / "answers.sealed").read_bytes() != (tmp_path / "two" / "answers.sealed").read_bytes()


def test_each_group_is_told_before_it_is_made(capsys):
    told = []
    made = small(progress=told.append)
    assert [(str(one), one.done, one.left) for one in told] == [("A", 0, 2), ("B", 1, 1)]
    assert all(isinstance(one, stepid.Progress) and not one.best for one in told)  # nothing of what is hidden
    assert made == small(progress=False) == small()
    assert capsys.readouterr() == ("", "")
    with pytest.raises(InputError, match=r"progress is True\. Give a function, or False"):
        small(progress=True)


def test_an_exception_raised_in_progress_cancels():
    def stop(stage):
        if stage == "B":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        small(progress=stop)


@pytest.mark.parametrize("seed", [1, "another sentence"])
def test_another_seed_makes_another_plant(seed):
    one, two = small(seed=seed), small()
    assert one["A"] != two["A"]
    assert one.answers["A"].parameters["base_mass"] != two.answers["A"].parameters["base_mass"]
    assert one.answers["A"].nonce != two.answers["A"].nonce


@given(st.permutations(["A", "B", "C 3"]), st.integers(1, 3))
@settings(max_examples=4, deadline=None)
def test_a_groups_campaign_does_not_depend_on_the_others(order, count):
    groups = tuple(order[:count])
    made, alone = small(groups=groups, effects=(LEVEL,)), small(groups=groups[-1:], effects=(LEVEL,))
    assert made[groups[-1]] == alone[groups[-1]]
    assert made.answers[groups[-1]] == alone.answers[groups[-1]]
    assert made.groups == groups


def test_drawn_effects_follow_the_seed_and_their_probability():
    draw = lab.Draw(among=("actuator_dead_zone", "sensor_drift"), none=0.5)
    groups = tuple(f"group {i}" for i in range(12))
    rig = SMALL.model_copy(update={"noise": 1e-6})
    one = lab.make(seed=3, groups=groups, effects=draw, rig=rig).answers
    assert one == lab.make(seed=3, groups=groups, effects=draw, rig=rig).answers
    found = {answer.effects for answer in one.answers}
    assert found == {(), ("actuator_dead_zone",), ("sensor_drift",)}
    assert all(a.effects == () for a in small(effects=lab.Draw(none=1.0)).answers.answers)
    picked = [lab.Draw(none=0.25).pick(np.random.default_rng(i)) for i in range(2000)]
    assert sum(p == () for p in picked) == pytest.approx(500, abs=4 * np.sqrt(375))
    assert {p for p in picked if p} == {(name,) for name in lab.Draw().among}


def visible(answer: lab.Answer, low: float, high: float) -> None:
    assert 0.85 * low <= answer.visibility <= 1.2 * high, answer


@pytest.mark.parametrize("name", ["coulomb_friction", "actuator_saturation", "cubic_stiffness", "end_stop"])
def test_what_is_hidden_is_as_visible_as_asked_for(name):
    answer = lab.make(seed=5, groups=("A",), effects=(name,), visibility=(8.0, 9.0)).answers["A"]
    assert answer.effects == (name,)
    visible(answer, 8.0, 9.0)
    assert answer.noise == pytest.approx(10e-6, rel=0.1)
    wanted = {f"{name}.{q.name}" for e in CATALOGUE if e.name == name for q in e.parameters}
    assert set(answer.parameters) == set(answer.units) == {*lab.Rig().labels, *wanted}


@pytest.mark.slow
@pytest.mark.parametrize("name", [e.name for e in CATALOGUE])
def test_every_effect_of_the_catalogue_can_be_hidden(name):
    visible(lab.make(seed=7, groups=("A",), effects=(name,)).answers["A"], 5.0, 25.0)


def test_nothing_hidden_leaves_the_noise():
    for seed in range(4):
        answer = small(seed=seed, effects=()).answers["A"]
        assert answer.visibility == pytest.approx(1.0, abs=0.06)
        assert answer.names == "nothing"


def test_the_records_are_a_labs(coulomb, tmp_path):
    campaign = coulomb["A"]
    truth = coulomb.answers["A"]
    written = coulomb.write(tmp_path / "class", passphrase=PASSPHRASE).parent / "A"
    assert [p.name for p in sorted(written.glob("0*"))] == [f"0{i}-run-{i}.txt" for i in (1, 2, 3, 4)]  # raw exports
    for run, plan in zip(campaign.experiments, lab.Rig().runs, strict=True):
        assert (run.name, run.added_mass) == (plan.name, plan.added_mass)
        counts = run.position * run.counts_per_meter
        assert np.allclose(counts, np.rint(counts), atol=1e-6)
        begin = int(np.flatnonzero(run.input)[0])
        assert np.ptp(run.position[:begin]) > 0  # noise before the step
        assert set(np.unique(run.input)) == {0.0, plan.level}
    middle = lab.Rig()
    for name, value in zip(middle.labels, (0.95, 216.0, 12.0, 7.8), strict=True):
        assert abs(truth.parameters[name] / value - 1) <= middle.spread


def test_a_fit_with_the_right_effect_passes_and_without_it_fails():
    made = small()
    answer = made.answers["A"]
    fit = stepid.fit(made["A"], effects=answer.effects)
    right = lab.check(answer, lab.Submission(group="A", parameters=fit.parameters, effects=answer.effects))
    assert right.passed, right.summary()
    assert fit.rms == pytest.approx(answer.noise, rel=0.05)
    for name, estimate in fit.parameters.items():
        assert estimate.parts["noise"] == pytest.approx(answer.attainable[name], rel=0.25)
    linear = stepid.fit(made["A"])
    wrong = lab.check(answer, lab.Submission(group="A", parameters=linear.parameters))
    assert not wrong.passed
    assert wrong.naming == "wrong"
    assert not wrong["damping[1/2 turn]"].right
    assert linear.rms / answer.noise == pytest.approx(answer.visibility, rel=0.02)


@pytest.mark.slow
def test_stated_intervals_cover_the_truth():
    hidden = stepid.EffectModel(name="quadratic_damping", values={"coefficient": 40.0})
    inside = total = 0
    for seed in range(40):
        made = small(seed=seed, groups=("A",), effects=(hidden,))
        exact = made["A"].model_copy(update={"weight_uncertainty": 1e-9})  # kg: made-up weights are what they say
        fit = stepid.fit(exact, effects=("quadratic_damping",))
        found = lab.check(
            made.answers["A"],
            lab.Submission(group="A", parameters=fit.parameters, effects=("quadratic_damping",)),
        )
        inside, total = inside + found.inside, total + len(found.parameters)
    assert 0.90 <= inside / total <= 0.99  # parameters of one campaign err together, so the count is coarser than 200


def test_students_find_no_answer_in_their_files(tmp_path, coulomb):
    sealed = coulomb.write(tmp_path / "class", passphrase=PASSPHRASE)
    answer = coulomb.answers["A"]
    words = ["coulomb", "friction", "effect", answer.nonce, "110000000000"]
    numbers = [s for v in answer.parameters.values() for s in (f"{v:.6g}", f"{v:.5g}", f"{v:.4g}")]
    for raw in contents(tmp_path / "class").values():
        text = raw.decode().lower()
        assert not [w for w in (*words, *numbers) if w in text]
    assert sealed == tmp_path / "class" / "answers.sealed"
    assert "coulomb" not in f"{coulomb!r} {coulomb!s}"


def test_names_sizes_and_times_tell_nothing(tmp_path):
    wordy = stepid.EffectModel(name="cogging", values={"amplitude": 0.0543219876, "pitch": 0.004, "phase": 1.23456789})
    seen = []
    for name, hidden in (("one", ()), ("two", (wordy, LEVEL))):
        small(effects=hidden).write(tmp_path / name, passphrase=PASSPHRASE)
        files = contents(tmp_path / name)
        seen.append((list(files), files["A/campaign.toml"], len(files["answers.sealed"])))
        times = {os.stat(p).st_mtime_ns for p in (tmp_path / name).rglob("*")}
        assert len(times) == 1
    assert seen[0] == seen[1]


def test_folders_appear_whole_or_not_at_all(tmp_path, monkeypatch):
    made = small()
    with pytest.raises(InputError, match="shorter than 8"):
        made.write(tmp_path / "class", passphrase="short")
    original = Path.write_text

    def fails(self, *args, **fields):
        if self.name == "answers.sealed":
            raise OSError(28, "No space left on device")
        return original(self, *args, **fields)

    monkeypatch.setattr(Path, "write_text", fails)
    with pytest.raises(InputError, match="No space left"):
        made.write(tmp_path / "class", passphrase=PASSPHRASE)
    assert list(tmp_path.iterdir()) == []
    monkeypatch.undo()
    made.write(tmp_path / "new" / "class", passphrase=PASSPHRASE)
    with pytest.raises(InputError, match="exists already"):
        made.write(tmp_path / "new" / "class", passphrase=PASSPHRASE)
    assert stepid.read_campaign(tmp_path / "new" / "class" / "B") == made["B"]


def test_models_go_to_json_and_back():
    made = small()
    for obj in (made, made.answers, made.answers["A"], SMALL, lab.Draw()):
        assert type(obj).model_validate_json(obj.model_dump_json()) == obj


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"groups": ()}, "groups is"),
        ({"groups": "AB"}, "groups is 'AB'"),
        ({"groups": ("A", "a")}, "capitals"),
        ({"groups": ("../A",)}, "cannot be called"),
        ({"groups": ("answers.sealed",)}, "cannot be called"),
        ({"groups": ("A.",)}, "cannot be called"),
        ({"groups": ("A", 1)}, "cannot be called 1"),
        ({"seed": True}, "seed is True"),
        ({"seed": ""}, "seed is ''"),
        ({"seed": 1.5}, "seed is 1.5"),
        ({"effects": ("friction",)}, "no effect called 'friction'"),
        ({"effects": "coulomb_friction"}, "Give a sequence"),
        ({"effects": {"A": ()}}, "nothing for group 'B'"),
        ({"effects": {"A": (), "B": (), "C": ()}}, "speaks of a group 'C'"),
        ({"effects": (LEVEL, "coulomb_friction")}, "named twice"),
        ({"effects": (stepid.EffectModel(name="free_play", values={"level": 1.0}),)}, "Give gap"),
        ({"visibility": (1.0, 3.0)}, "visibility is"),
        ({"visibility": (9.0, 3.0)}, "visibility is"),
        ({"visibility": 5.0}, "visibility is"),
        ({"effects": ("actuator_saturation",), "visibility": (5e4, 5e4)}, "cannot be made strong enough"),
    ],
)
def test_make_refuses(fields, words):
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        small(**fields)


def test_an_effect_from_outside_needs_values():
    class Own(type(CATALOGUE[0])):
        name = "own_friction"

    with pytest.raises(InputError, match="no natural size"):
        small(effects=("own_friction",), catalogue=(*CATALOGUE, Own()))
    hidden = (stepid.EffectModel(name="own_friction", values={"level": 0.1}),)
    assert small(effects=hidden, catalogue=(*CATALOGUE, Own())).answers["A"].visibility > 1.5


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"runs": (SMALL.runs[0], SMALL.runs[0])}, "used twice"),
        ({"runs": SMALL.runs[:1]}, "two different added masses"),
        ({"hold": 0.05}, "20 samples"),
        ({"noise": float("nan")}, "noise"),
        ({"spread": 0.7}, "spread"),
    ],
)
def test_a_rig_refuses(fields, words):
    with pytest.raises(InputError, match=words):
        lab.Rig(**fields)
    with pytest.raises(InputError, match="0 V"):
        lab.RunPlan(name="x", added_mass=0.0, level=0.0)
