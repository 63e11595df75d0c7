"""Recordings understood from Python, as `stepid init` understands them on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stepid
import webapp_files
from exports import export_bytes
from stepid.cli import run
from stepid.errors import InputError


def recordings(folder: Path, *, named: bool = False) -> Path:
    folder.mkdir(exist_ok=True)
    for name, content in webapp_files.three(named=named).items():
        (folder / name).write_bytes(content)
    return folder


def test_a_draft_shows_what_it_understood_and_asks_for_the_rest(tmp_path: Path) -> None:
    draft = stepid.draft_campaign(recordings(tmp_path / "lab"))
    assert repr(draft) == "CampaignDraft('lab', 3 runs, 1 open)"
    (question,) = draft.questions
    assert question == "Which masses were added, in kg (run 1, run 2, run 3)? Give added_mass=…."
    lines = draft.summary().splitlines()
    assert lines[0] == "Recordings of campaign 'lab'"
    assert lines[3].startswith("run 1.csv (decimal ,)  300 × 10 ms  Weg [mm] in mm  Spannung [V] in V")
    assert lines[-1] == question
    assert str(draft) == draft.summary()
    page = draft._repr_html_()
    assert "<td>Weg [mm] in mm</td>" in page
    assert f"<p>{question}</p>" in page
    with pytest.raises(InputError, match=r"do not say all: Which masses.* Give added_mass=…, or fill in the campaign"):
        draft.campaign()


def test_all_that_is_open_is_named_at_once(tmp_path: Path) -> None:
    for i in (1, 2):
        (tmp_path / f"run {i}.csv").write_bytes(webapp_files.recording(0.5 * i, units=False))
    draft = stepid.draft_campaign(tmp_path)
    with pytest.raises(InputError, match=r"Give position_unit=…, added_mass=…") as caught:
        draft.campaign()
    assert "In which unit is the position" in caught.value.cause
    read = stepid.draft_campaign(tmp_path, position_unit="cm", added_mass=(0, 1)).campaign()
    same = stepid.draft_campaign(tmp_path, position_unit=0.01, added_mass=(0, 1)).campaign()
    assert read.experiments == same.experiments
    assert float(read[0].position.max()) == pytest.approx(0.137, rel=0.05)


def test_it_is_the_campaign_that_the_command_line_writes(tmp_path: Path) -> None:
    folder = recordings(tmp_path / "lab")
    draft = stepid.draft_campaign(str(folder / "run *.csv"), added_mass=[0.0, 0.5, 1.0], spring="medium", name="mine")
    assert draft.questions == ()
    assert repr(draft) == "CampaignDraft('mine', 3 runs, complete)"
    campaign = draft.campaign()
    assert [e.added_mass for e in campaign] == [0.0, 0.5, 1.0]
    assert {e.spring for e in campaign} == {"medium"}
    assert [source.name for source in campaign.provenance.sources] == ["run 1.csv", "run 2.csv", "run 3.csv"]
    written = draft.write()
    assert written == folder / "campaign.toml"
    assert stepid.read_campaign(folder) == campaign
    by_shell = [str(folder / f"run {i}.csv") for i in (1, 2, 3)]
    said = ["--added-mass", "0,0.5,1", "--spring", "medium", "--name", "mine", "--out", str(tmp_path / "cli.toml")]
    assert run(["init", *by_shell, *said]) == 0
    assert draft.write(tmp_path / "python.toml").read_text() == (tmp_path / "cli.toml").read_text()
    with pytest.raises(InputError, match="exists already"):
        draft.write(folder)
    with pytest.raises(InputError, match="cannot be written"):
        draft.write(tmp_path / "nowhere" / "campaign.toml")


def test_what_is_open_is_marked_in_the_manifest(tmp_path: Path) -> None:
    written = stepid.draft_campaign(recordings(tmp_path / "lab")).write()
    assert written.read_text().count('added_mass = "?"') == 3


def test_control_characters_in_names_of_columns_are_shown_in_comments(tmp_path: Path) -> None:
    rows = "".join(f"{0.01 * n:.2f};{n % 7};{n % 5};0.5\n" for n in range(60))
    (tmp_path / "a.csv").write_text("t_s;x\x01_mm;y\x7f_mm;u_V\n" + rows)
    text = stepid.draft_campaign(tmp_path / "a.csv", added_mass=0.0).write().read_text()
    assert "x\\x01_mm" in text
    with pytest.raises(InputError, match=r"has no column '[?]' for position"):  # and not: is not TOML
        stepid.read_campaign(tmp_path)


def test_names_say_masses_and_notes_are_left_out(tmp_path: Path) -> None:
    folder = recordings(tmp_path / "lab", named=True)
    (folder / "notes.txt").write_text("dear diary\nnothing was measured\n")
    draft = stepid.draft_campaign(folder)
    with pytest.warns(UserWarning, match=r"notes\.txt: holds no table of numbers that stepid finds; left out"):
        campaign = draft.campaign()
    assert [e.added_mass for e in campaign] == [0.0, 0.5, 1.0]
    assert [e.spring for e in campaign] == ["medium"] * 3
    assert len(draft.left_out) == 1
    assert "notes.txt" in draft.summary().splitlines()[-1]
    one = stepid.draft_campaign(Path(folder / "medium_0.5kg.csv"), added_mass=2).campaign()
    assert [e.added_mass for e in one] == [2.0]  # what is said goes before what a name says


def test_a_campaign_warns_of_what_is_left_out_of_its_files(tmp_path: Path) -> None:
    folder = recordings(tmp_path / "lab", named=True)
    file = folder / "medium_0.5kg.csv"
    file.write_bytes(file.read_bytes() + b"measured by hand\n")
    with pytest.warns(UserWarning, match=r"medium_0\.5kg.*: 1 line below the rows is left out"):
        assert len(stepid.draft_campaign(folder).campaign()) == 3


def test_values_go_to_files_in_the_order_in_which_they_are_named(tmp_path: Path) -> None:
    folder = recordings(tmp_path / "lab")
    for old, new in ((3, 10), (1, 30)):
        (folder / f"run {old}.csv").rename(folder / f"run {new}.csv")
    by_hand = [folder / f"run {n}.csv" for n in (30, 2, 10)]
    read = stepid.draft_campaign(iter(by_hand), added_mass=[0.5, 1.5, 1.0]).campaign()
    assert {e.name: e.added_mass for e in read} == {"run 30": 0.5, "run 2": 1.5, "run 10": 1.0}
    by_number = stepid.draft_campaign(folder, added_mass=[1.5, 1.0, 0.5]).campaign()
    assert {e.name: e.added_mass for e in by_number} == {e.name: e.added_mass for e in read}
    with pytest.raises(InputError, match=r"added_mass=…: it is not clear which value is whose"):
        stepid.draft_campaign(sorted(folder.glob("*.csv")), added_mass=[0.5, 1.5, 1.0])


def test_columns_may_be_chosen_by_number(tmp_path: Path) -> None:
    rows = "".join(f"{0.01 * n:.2f};{n % 7};{n % 5};0.5\n" for n in range(60))
    (tmp_path / "a.csv").write_text("t_s;x1_mm;x2_mm;u_V\n" + rows)
    read = stepid.draft_campaign(tmp_path / "a.csv", position=2, added_mass=0.0).campaign()
    assert len(read) == 1
    assert read[0].position.max() == pytest.approx(0.004)
    both = stepid.draft_campaign(tmp_path / "a.csv", position="all", added_mass=[0.0, 0.5]).campaign()
    assert [e.added_mass for e in both] == [0.0, 0.5]


def columns_of(folder: Path, name: str, head: str) -> Path:
    file = folder / name
    file.write_text((head + "\n" if head else "") + "".join(f"{0.01 * n:.2f};{n % 7};{n % 5};0.5\n" for n in range(60)))
    return file


@pytest.mark.parametrize(
    ("role", "column", "said"),
    [
        ("position", "foo", "has no column 'foo' for position (t_s, x1_mm, x2_mm, u_V)"),
        ("position", 7, "has no column 7 for position (t_s, x1_mm, x2_mm, u_V)"),
        ("time", "clock", "has no column 'clock' for time"),
        ("input", "u2", "has no column 'u2' for input"),
    ],
)
def test_a_column_that_is_not_there_is_refused(
    tmp_path: Path, role: str, column: Any, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = columns_of(tmp_path, "a.csv", "t_s;x1_mm;x2_mm;u_V")
    with pytest.raises(InputError, match="by its name or its number from 0") as refused:
        stepid.draft_campaign(file, **{"position": "x1_mm", role: column})
    assert f"{file}: {said}" in refused.value.cause
    for command in (["init"], ["diagnose", "-q"]):
        assert run([*command, str(file), f"--{role}", str(column), "--added-mass", "0"]) == 2
        assert f"a.csv: {said}" in capsys.readouterr().err
    assert not (tmp_path / "campaign.toml").exists()


def test_a_column_that_some_files_have_is_doubted_in_the_others(tmp_path: Path) -> None:
    files = [
        columns_of(tmp_path, "a.csv", "t_s;x1_mm;x2_mm;u_V"),
        columns_of(tmp_path, "b.csv", "t_s;x_mm;set_mm;u_V"),
    ]
    draft = stepid.draft_campaign(files, position="x2_mm", added_mass=[0.0, 0.5])
    with pytest.warns(UserWarning, match=r"b\.csv: has no column 'x2_mm' for position .*; 'x_mm' is taken"):
        assert len(draft.campaign()) == 2
    bare = columns_of(tmp_path, "c.csv", "")
    with pytest.raises(InputError, match=r"no column .x2_mm. for position \(no header; columns count from 0 to 3\)"):
        stepid.draft_campaign(bare, position="x2_mm")


def test_an_export_has_columns_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "run.txt").write_bytes(export_bytes())
    (draft,) = stepid.draft_campaign(tmp_path, position="Encoder 1 Pos").runs
    assert draft.titles["position"] == "Encoder 1 Pos"
    with pytest.raises(InputError, match=r"whose position is 'Encoder 1 Pos'.* takes another encoder: encoder = 2"):
        stepid.draft_campaign(tmp_path, position="Encoder 2 Pos")


def below(file: Path, runs: int, rows: int = 200) -> Path:
    """Write runs one below the other, whose clocks begin anew."""
    row = "{:.2f},{:.5f},0.5\n"
    x = [8 * (1 - 0.98**n * np.cos(0.15 * n)) for n in range(rows)]
    file.write_text("t_s,x_mm,u_V\n" + runs * "".join(row.format(0.01 * n, x[n]) for n in range(rows)))
    return file


def test_runs_one_below_the_other_are_refused_by_the_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = below(tmp_path / "both.csv", 2)
    said = f"{file}, line 202: time starts anew at 0 s after 1.99 s, so the table seems to hold two runs one below"
    for command in (["init"], ["diagnose", "-q"]):
        assert run([*command, str(file), "--added-mass", "0"]) == 2
        assert f"{said} the other. Save each run as a file of its own." in capsys.readouterr().err
    assert not (tmp_path / "campaign.toml").exists()
    named: dict[str, Any] = {"time": "t_s", "position": "x_mm", "input": "u_V", "position_scale": 1e-3}
    with pytest.raises(InputError, match=r"stop = 200 keeps the first run, start = 200 the second\.") as refused:
        stepid.read_table(file, **named)
    assert said in refused.value.cause
    first, second = stepid.read_table(file, **named, stop=200), stepid.read_table(file, **named, start=200)
    assert first == second
    three = below(tmp_path / "three.csv", 3)
    with pytest.raises(InputError, match=r"hold 3 runs .* start = 200, stop = 400 the second"):
        stepid.read_table(three, **named, sample_time=0.01)
    with pytest.raises(InputError, match=r"hold two runs .* stop = 200 keeps"):
        stepid.read_table(three, **named, stop=400)


def test_files_that_are_joined_may_have_clocks_of_their_own(tmp_path: Path) -> None:
    files = [below(tmp_path / name, 1) for name in ("a.csv", "b.csv")]
    with pytest.raises(InputError, match=r"b\.csv, line 2: 0 s after .* leave time out if each file starts a clock"):
        stepid.read_table(files, time="t_s", position="x_mm", input="u_V", position_scale=1e-3)
    late = below(tmp_path / "late.csv", 1)
    late.write_text(late.read_text().replace("\n1.90,", "\n0.02,"))  # one stamp, and not the next ones
    with pytest.raises(InputError, match=r"line 192: 0\.02 s after 1\.89 s: time does not increase.* leave time out\."):
        stepid.read_table(late, time="t_s", position="x_mm", input="u_V", position_scale=1e-3)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"added_mass": "x"}, "added_mass is 'x'. Give a number, or one a run"),
        ({"added_mass": [0.0, 1.0]}, "added_mass has 2 values for 3 runs"),
        ({"added_mass": []}, r"added_mass is \[\]"),
        ({"spring": 3}, "spring is 3. Give a label"),
        ({"time": 1.5}, "time is 1.5. Give a column"),
        ({"position_unit": True}, "position_unit is True. Give a unit, or SI units per unit"),
        ({"position_unit": "furlong"}, "'furlong' is no unit of the position"),
        ({"step": float("nan")}, "step is nan. Give a finite number"),
        ({"motion": "up"}, "motion is 'up'"),
        ({"name": 3}, "name is 3"),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path: Path, given: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        stepid.draft_campaign(recordings(tmp_path / "lab"), **given)


@pytest.mark.parametrize("files", ["nope*.csv", "nope.csv", [], 3, b"x", ["run 1.csv", None], {"run 1.csv": 0.5}])
def test_files_that_are_none_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, files: Any) -> None:
    monkeypatch.chdir(recordings(tmp_path / "lab"))
    with pytest.raises(InputError):
        stepid.draft_campaign(files)


@pytest.mark.parametrize("level", [0.0, 0.5])
def test_a_step_that_was_said_is_not_asked_for_while_the_position_is_open(level: float, tmp_path: Path) -> None:
    rows = "".join(f"{0.01 * n:.2f},{n % 7},{n % 5}\n" for n in range(60))
    (tmp_path / "a.csv").write_text("t_s,x_mm,y_mm\n" + rows, encoding="utf-8")
    draft = stepid.draft_campaign(tmp_path, step=level, added_mass=0.0)
    assert draft.questions == ('Which column is the position (x_mm, y_mm; "all" if each is a run)? Give position=….',)
    written = draft.write().read_text(encoding="utf-8")
    assert any(line.startswith("step") and f"level = {level}" in line for line in written.splitlines())
    drawn = stepid.draft_campaign(tmp_path, step=level, added_mass=0.0, position="y_mm").campaign()[0]
    assert float(drawn.input[-1]) == level
