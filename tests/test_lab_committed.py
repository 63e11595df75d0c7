"""What stepid 0.1.0 sealed opens ever after: the same answers, the same hashes, the same marks."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import stepid
from stepid import lab
from stepid.lab.answers import digest

SEALED = Path(__file__).parent / "golden" / "assignment-0.1.0"
PASSPHRASE = "an old sentence that opens"
GROUPS = ("A", "B")


@pytest.fixture(scope="module")
def answers() -> lab.Answers:
    return lab.open_answers(SEALED, passphrase=PASSPHRASE)


def marks(check: lab.Check) -> dict[str, object]:
    return {
        "passed": check.passed,
        "naming": check.naming,
        "words": check.words,
        "close": check.close,
        "inside": check.inside,
        "counted": len(check.counted),
        "parameters": {p.name: {"close": p.close, "inside": p.inside, "words": p.words} for p in check.parameters},
    }


def test_the_answers_sealed_by_the_first_version_open(answers):
    assert (answers.groups, answers.seed) == (GROUPS, "golden")
    assert [a.effects for a in answers.answers] == [("coulomb_friction",), ()]
    assert answers["A"].parameters["coulomb_friction.level"] == 0.25
    assert answers["B"].parameters["base_mass"] == 0.814055


@pytest.mark.parametrize("group", GROUPS)
def test_the_hashes_are_those_of_the_first_version(answers, group):
    lab.confirm(answers[group], SEALED / group)
    assert answers[group].commitment in (SEALED / group / "commitment.txt").read_text(encoding="utf-8")
    assert digest(stepid.read_campaign(SEALED / group)) == answers[group].records


def test_what_was_handed_in_then_gets_the_same_marks(answers):
    expected = json.loads((SEALED / "marks.json").read_text(encoding="utf-8"))
    given = lab.read_submissions(SEALED / "submissions")
    assert {s.group: marks(lab.check(answers[s.group], s)) for s in given} == expected


def test_odd_numbers_and_words_keep_their_hash():
    odd = [0.0, -0.0, 1e-5, -1.25e-5, 1.5e-6, 5e-324, 0.1 + 0.2, 1e15, 123456789.123, 1e-4, -7.0, 2.5e-9]
    run = stepid.Experiment(
        name='Fall "1"\\\n\té\u2028\x01\x7f',
        time=[0.0088542 * i for i in range(12)],
        position=odd,
        input=odd[::-1],
        added_mass=1e-5,
        spring="mittel",
        damper="½ turn",
        counts_per_meter=-226600.0,
        input_before=-3e-7,
    )
    bare = run.model_copy(update={"name": "2", "counts_per_meter": None})
    campaign = stepid.Campaign(name="group Ä", experiments=(run, bare), weight_uncertainty=1e-5)
    assert digest(campaign) == "4f8d59b7256c4f06a28fb161b130b08dc35be4203ea2be025473b68d2747daf6"
