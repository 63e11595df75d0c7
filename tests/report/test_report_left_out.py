"""Runs that a diagnosis leaves out, in its report: listed with the reason, without a picture."""

from __future__ import annotations

import json
import re
from pathlib import Path

import matplotlib as mpl
import pytest

import diagnosis_example as example
from diagnosis_example import changed
from page_text import Tags, packed
from stepid.diagnosis.result import Diagnosis
from stepid.identification.transfer.verification import Verification
from stepid.report import provenance
from stepid.report.hand import HandMethod, pictured
from stepid.report.json_values import diagnosis_values
from stepid.report.story import tell
from stepid.report.text_diagnosis import diagnosis_report
from stepid.report.write import hand_of, write_all


@pytest.fixture(autouse=True)
def _no_windows() -> None:
    mpl.use("Agg")


def with_a_copy() -> Diagnosis:
    """The example's campaign with two more runs, which the diagnosis leaves out and the peak method uses."""
    d = example.named()
    assert d.data is not None
    first, second = (  # not copies to the last digit: those the peak method leaves out, too
        run.model_copy(update={"name": f"copy of {run.name}", "added_mass": 3.0, "position": run.position * 1.000001})
        for run in d.data.experiments[:2]
    )
    data = d.data.model_copy(update={"experiments": (first, *d.data.experiments, second)})
    notes = tuple(
        f"Runs 'case {i}', 'copy of case {i}' hold the same record under different labels, and they are left out."
        for i in (4, 5)
    )
    return changed(d, data=data, notes=notes)


@pytest.mark.slow
def test_runs_left_out_are_listed_with_the_reason_and_have_no_picture(tmp_path: Path) -> None:
    d = with_a_copy()
    write_all(d, provenance.of_data(d), tmp_path)
    d.to_markdown(tmp_path / "alone.md")
    assert (tmp_path / "report-pictures.pdf").read_bytes().startswith(b"%PDF")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    drawn = json.loads(packed(page, "pictures"))
    shown = set(re.findall(r'data-picture="([^"]+)"', page))
    assert shown == set(drawn)
    assert {name for name in shown if name.startswith("verification-")} == {f"verification-{i}" for i in range(4)}
    note = (tmp_path / "report.md").read_text(encoding="utf-8").replace("\\", "")
    hand = hand_of(d)
    assert isinstance(hand, HandMethod)
    assert "copy of case 4" in hand.found.masses  # that is why a picture was expected
    for text in (Tags(page).text, note, (tmp_path / "alone.md").read_text(encoding="utf-8")):
        assert "Left out of the diagnosis and its pictures: copy of case 4, copy of case 5." in text
        assert "uses copy of case 4, copy of case 5 all the same" in text
        assert all(note in text for note in d.notes)
    assert [run["name"] for run in diagnosis_values(d)["runs"]] == list(example.RUNS)
    assert Diagnosis.from_dict(d.to_dict()) == d


def test_a_report_without_a_verified_run_of_the_diagnosis_has_no_such_picture() -> None:
    d = with_a_copy()
    hand = hand_of(d)
    assert isinstance(hand, HandMethod)
    others = tuple(run for run in hand.verified.runs if run.name.startswith("copy"))
    assert len(others) == 2
    apart = hand.model_copy(update={"verified": Verification(runs=others)})
    assert pictured(d, apart) is None
    (chapter,) = [c for c in tell(d, apart, provenance.of_data(d)) if c.name == "verification"]
    assert chapter.pictures == ()
    assert [row[0] for row in chapter.tables[0].rows] == [run.name for run in others]


def test_the_text_says_which_runs_only_the_peak_method_uses() -> None:
    d, whole = with_a_copy(), example.named()
    hand, plain = hand_of(d), hand_of(whole)
    assert isinstance(hand, HandMethod)
    assert isinstance(plain, HandMethod)
    said = "uses copy of case 4, copy of case 5 all the same. The diagnosis left that out"
    assert said in diagnosis_report(d, hand.found)[1].body
    assert "all the same" not in diagnosis_report(whole, plain.found)[1].body
