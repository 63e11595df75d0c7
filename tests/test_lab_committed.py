"""What stepid 0.1.0 sealed opens ever after: the same answers, the same hashes, the same marks."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import stepid
from stepid import lab
from stepid.lab import hashes
from stepid.lab.hashes import answer_digest, digest

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


class LongerExperiment(stepid.Experiment):
    """What an experiment may be one day."""

    temperature: float = 20.0
    remarks: tuple[str, ...] = ()


class LongerCampaign(stepid.Campaign):
    experiments: tuple[LongerExperiment, ...]
    operator: str = ""


class LongerAnswer(lab.Answer):
    hints: tuple[str, ...] = ()


def longer(campaign: stepid.Campaign) -> LongerCampaign:
    runs = tuple(LongerExperiment(**{f: getattr(e, f) for f in hashes.EXPERIMENT}) for e in campaign.experiments)
    return LongerCampaign(name=campaign.name, experiments=runs, weight_uncertainty=campaign.weight_uncertainty)


def test_a_field_that_is_added_later_changes_no_hash(answers, monkeypatch):
    answer, campaign = answers["A"], stepid.read_campaign(SEALED / "A")
    more = longer(campaign)
    assert "temperature" in more.model_dump_json()
    assert digest(more) == digest(campaign) == answer.records
    told = LongerAnswer(**{f: getattr(answer, f) for f in hashes.ANSWER})
    assert "hints" in told.model_dump_json()
    assert told.commitment == answer_digest(told) == answer.commitment
    monkeypatch.setattr("stepid.lab.assignment.read_campaign", lambda folder: longer(stepid.read_campaign(folder)))
    lab.confirm(told, SEALED / "A")


def another(value: object) -> object:
    if isinstance(value, str):
        return value + "x"
    if isinstance(value, tuple):
        return value[:-1]
    return {**value, "x": 1.0} if isinstance(value, Mapping) else value + 1.0


def test_every_field_of_the_first_version_changes_the_hash(answers):
    answer, campaign = answers["A"], stepid.read_campaign(SEALED / "A")
    run = campaign.experiments[0]
    for field in hashes.EXPERIMENT:
        changed = run.model_copy(update={field: another(getattr(run, field))})
        whole = campaign.model_copy(update={"experiments": (changed, *campaign.experiments[1:])})
        assert digest(whole) != answer.records, field
    for field in hashes.CAMPAIGN:
        assert digest(campaign.model_copy(update={field: another(getattr(campaign, field))})) != answer.records, field
    for field in hashes.ANSWER:
        changed = answer.model_copy(update={field: another(getattr(answer, field))})
        assert changed.commitment != answer.commitment, field


@given(st.floats(-1e15, 1e15) | st.floats(-1e-3, 1e-3))
def test_numbers_are_written_as_the_first_version_did(value):
    estimate = stepid.Estimate(value=value, unit="é\n\x01")
    assert hashes.written(estimate.to_dict()) == estimate.model_dump_json()
    assert float(hashes.written(value)) == value


def test_what_no_hash_covers_is_refused():
    with pytest.raises(TypeError, match="set is nothing"):
        hashes.written({1.0})
