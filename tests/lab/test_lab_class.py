"""What a class hands in: files read and written, all groups in one table."""

from __future__ import annotations

import json

import pytest

from lab_example import answer, mass, submission
from stepid import lab
from stepid.errors import InputError


def class_answers():
    return lab.Answers(seed="s", answers=tuple(answer(group=g) for g in ("A", "B", "C")))


def test_a_class_in_one_table():
    bad = submission(group="B", effects=())
    results = lab.check_all(class_answers(), [bad, submission()])
    assert [c.group for c in results.checks] == ["A", "B"]
    assert results.missing == ("C",)
    assert results["A"].passed
    assert not results["B"].passed
    lines = results.summary().splitlines()
    assert [" ".join(line.split()) for line in lines[3:]] == [
        "A coulomb friction coulomb friction 5/5 5/5 passed, naming right",
        "B coulomb friction nothing 4/5 4/5 not passed, naming wrong",
        "C – – – – nothing handed in",
    ]
    assert results.records()[1] == {
        "group": "B",
        "hidden": "coulomb friction",
        "named": "nothing",
        "naming": "wrong",
        "close": 4,
        "inside": 4,
        "parameters": 5,
        "passed": False,
    }
    assert repr(results) == "Results(1 of 2 passed, 1 missing)"
    assert "<table>" in results._repr_html_()
    assert lab.Results.model_validate_json(results.model_dump_json()) == results
    frame = pytest.importorskip("pandas").DataFrame(results.records())
    assert list(frame["passed"]) == [True, False]


def test_a_class_refuses():
    for handed_in, words in (
        ([submission(), submission()], "has handed in twice"),
        ([submission(group="D")], "no answer for group 'D'"),
    ):
        with pytest.raises(InputError, match=words):
            lab.check_all(class_answers(), handed_in)
    results = lab.check_all(class_answers(), [submission()])
    with pytest.raises(InputError, match="'B' has handed in nothing"):
        results["B"]
    with pytest.raises(InputError, match="there is no group 'D'"):
        results["D"]


def test_submissions_are_handed_in_as_files(tmp_path):
    one, two = submission(), submission(group="B", effects=(), alternatives=(("free_play",),))
    assert one.write(tmp_path / "in" / "a.json") == tmp_path / "in" / "a.json"
    two.write(tmp_path / "in" / "b.json")
    two.write(tmp_path / "in" / "b.json")  # handed in again
    assert lab.read_submissions(tmp_path / "in") == (one, two)
    assert sorted(p.name for p in (tmp_path / "in").iterdir()) == ["a.json", "b.json"]
    assert repr(one) == "Submission(group 'A': coulomb_friction named, 5 parameters)"
    with pytest.raises(InputError, match=r"does not end in \.json"):
        one.write(tmp_path / "a.txt")
    with pytest.raises(InputError, match="no folder with submissions"):
        lab.read_submissions(tmp_path / "nowhere")


def test_submissions_written_by_hand(tmp_path):
    file = tmp_path / "A.json"
    good = {"group": "A", "parameters": {"base_mass": {"value": 1, "uncertainty": 0.1, "unit": "kg"}}}
    file.write_text(json.dumps(good))
    assert lab.read_submission(file).parameters["base_mass"] == mass(1.0, 0.1)
    cases = {
        '"value": NaN': "base_mass.value",
        '"value": "1"': "base_mass.value",
        '"value": 1, "error": 2': "base_mass.error",
        '"value": 1, "uncertainty": -0.1, "unit": "kg"}}, "x": {"y": {"z": 1': "base_mass.uncertainty",
    }
    for broken, words in cases.items():
        file.write_text(json.dumps(good).replace('"value": 1', broken))
        with pytest.raises(InputError, match=rf"A\.json: Submission: .*{words}"):
            lab.read_submission(file)
    for text in ("{", '{"group": "A"}', "[]"):
        file.write_text(text)
        with pytest.raises(InputError, match=r"A\.json: Submission"):
            lab.read_submission(file)
    with pytest.raises(InputError, match="no such file"):
        lab.read_submission(tmp_path / "none.json")
