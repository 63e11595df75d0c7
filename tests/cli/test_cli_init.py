"""`stepid init`: from recordings to a campaign, with few answers or none."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest

import stepid
from lab_folders import make_folder
from lab_person import check_campaign, person
from stepid.cli import run


def test_a_person_answers_and_has_a_campaign(tmp_path: Path) -> None:
    truths = make_folder(tmp_path / "lab", 15)  # exports: how many counts are one meter?
    answers, shown = person(tmp_path / "lab", truths)
    assert 1 <= answers <= 4
    assert "Next: stepid diagnose" in shown
    check_campaign(tmp_path / "lab", truths)


@pytest.mark.slow
def test_people_in_ten_laboratories(tmp_path: Path) -> None:
    for seed in range(10):
        truths = make_folder(tmp_path / str(seed), seed)
        assert person(tmp_path / str(seed), truths)[0] <= 4
        check_campaign(tmp_path / str(seed), truths)


def three_runs(folder: Path, head: str = "t_s,x_mm,u_V\n") -> list[str]:
    t = np.arange(150) * 0.01
    paths = []
    for i in (1, 2, 3):
        x = 8 * (1 - np.exp(-2 * t) * np.cos(18 / np.sqrt(i) * t))
        path = folder / f"case_{i}.csv"
        path.write_text(head + "".join(f"{a:g},{b:.5f},0.5\n" for a, b in zip(t, x, strict=True)))
        paths.append(str(path))
    return paths


def test_without_a_terminal_what_is_not_known_is_marked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = three_runs(tmp_path)
    assert run(["init", *files]) == 0
    assert "--added-mass" in capsys.readouterr().out
    assert (tmp_path / "campaign.toml").read_text().count('added_mass = "?"') == 3
    assert run(["diagnose", str(tmp_path)]) == 2
    assert "It must be a number" in capsys.readouterr().err
    assert run(["init", *files, "--added-mass", "0,0.5,1"]) == 2
    assert "exists already" in capsys.readouterr().err
    assert run(["init", *files, "--added-mass", "0,0.5,1", "--spring", "medium", "--force", "--name", "lab 3"]) == 0
    read = stepid.read_campaign(tmp_path)
    assert [e.name for e in read.experiments] == ["case 1", "case 2", "case 3"]
    assert [e.added_mass for e in read.experiments] == [0.0, 0.5, 1.0]
    assert {e.spring for e in read.experiments} == {"medium"}
    assert read.name == "lab 3"


def test_a_folder_is_its_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    three_runs(tmp_path)
    out = tmp_path / "mine and yours.toml"
    assert run(["init", str(tmp_path), "--added-mass", "0;0,5;1", "--out", str(out)]) == 0
    assert [e.added_mass for e in stepid.read_campaign(out).experiments] == [0.0, 0.5, 1.0]
    copied = capsys.readouterr().out.rpartition("Next: ")[2]
    assert shlex.split(copied) == ["stepid", "diagnose", str(out), "--out", "results"]


def test_a_pattern_that_no_shell_expanded_is_its_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    three_runs(tmp_path)
    pattern = str(tmp_path / "case_*.csv")
    assert run(["init", pattern, "--added-mass", "0,0.5,1"]) == 0
    assert [e.name for e in stepid.read_campaign(tmp_path).experiments] == ["case 1", "case 2", "case 3"]
    assert run(["diagnose", pattern]) == 2
    assert "Which masses were added, in kg (case 1, case 2, case 3)?" in capsys.readouterr().err
    assert run(["init", str(tmp_path / "nope*.csv")]) == 2
    assert "nope*.csv: no file is called so" in capsys.readouterr().err


def test_values_go_to_files_in_the_order_given(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = three_runs(tmp_path)
    renamed = [str(Path(file).rename(tmp_path / f"load_{n}.csv")) for file, n in zip(files, (2, 10, 30), strict=True)]
    two, ten, thirty = renamed
    out = tmp_path / "mine.toml"
    said = ["--added-mass", "0.5,1.5,1", "--out", str(out), "--force"]
    assert run(["init", thirty, two, ten, *said]) == 0  # by hand, in an order of one's own
    runs = {e.name: e.added_mass for e in stepid.read_campaign(out).experiments}
    assert runs == {"load 30": 0.5, "load 2": 1.5, "load 10": 1.0}
    assert run(["init", *sorted(renamed), *said]) == 2  # as a shell's load_*.csv, 10 before 2
    told = capsys.readouterr().err
    assert "--added-mass: it is not clear which value is whose" in told
    assert "such as load_2.csv load_10.csv load_30.csv" in told
    assert run(["diagnose", *sorted(renamed), "--spring", "soft,stiff,soft", "-q"]) == 2
    assert "--spring: it is not clear" in capsys.readouterr().err
    assert run(["init", *sorted(renamed), "--added-mass", "0.5", "--out", str(out), "--force"]) == 0  # all the same
    assert [e.name for e in stepid.read_campaign(out).experiments] == ["load 2", "load 10", "load 30"]


def test_a_campaign_apart_from_its_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "elsewhere").mkdir()
    out = tmp_path / "elsewhere" / "campaign.toml"
    assert run(["init", *three_runs(tmp_path), "--added-mass", "0,0.5,1", "--out", str(out)]) == 0
    assert "Next: stepid diagnose" in capsys.readouterr().out
    assert 'file = "../case_1.csv"' in out.read_text()


def test_diagnose_needs_no_manifest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seen: list[stepid.Campaign] = []

    def stop(campaign: stepid.Campaign, **_: object) -> None:
        seen.append(campaign)
        raise stepid.errors.InputError("stopped", "by the test")

    monkeypatch.setattr(stepid, "diagnose", stop)
    files = three_runs(tmp_path)
    assert run(["diagnose", *files]) == 2
    assert "Give --added-mass" in capsys.readouterr().err
    assert run(["diagnose", *files, "--added-mass", "0,0.5,1.5", "-q"]) == 2
    assert [e.added_mass for e in seen[0].experiments] == [0.0, 0.5, 1.5]
    assert not (tmp_path / "campaign.toml").exists()


def test_diagnose_says_what_it_leaves_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise stepid.errors.InputError("stopped", "by the test")

    monkeypatch.setattr(stepid, "diagnose", stop)
    first, *_ = three_runs(tmp_path)
    rows = Path(first).read_text().splitlines()
    Path(first).write_text("\n".join([*rows, "measured by hand"]) + "\n")
    (tmp_path / "d_1.5kg.csv").write_text("\n".join(rows[:7]) + "\n")
    assert run(["diagnose", str(tmp_path), "--added-mass", "0,0.5,1.5", "-q"]) == 2
    told = capsys.readouterr().err
    assert "d_1.5kg.csv: holds no table of numbers that stepid finds; left out" in told
    assert "case_1.csv, case 1: 1 line below the rows is left out" in told


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--added-mass", "0,1"], "added_mass has 2 values for 3 runs"),
        (["--added-mass", "heavy"], "Give numbers parted by commas"),
        (["--added-mass", "-1"], "Give 0 or more"),
        (["--position-unit", "furlong"], "is no unit of the position"),
        (["--counts-per-meter", "0"], "Give the counts of one meter"),
        (["--out", "nowhere/campaign.toml"], "no such folder"),
    ],
)
def test_bad_answers(arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["init", *three_runs(tmp_path), *arguments]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "campaign.toml").exists()


@pytest.mark.parametrize(
    ("column", "words"),
    [
        (
            ["--position", "u_V"],
            "column 'u_V' is in V by its name, no position. Columns that can be the position: x_mm",
        ),
        (["--position", "0"], "column 't_s' is in s by its name, no position"),
        (["--input", "x_mm"], "column 'x_mm' is in mm by its name, no input. Columns that can be the input: u_V."),
        (["--time", "u_V"], "column 'u_V' is in V by its name, no time. Columns that can be the time: t_s."),
    ],
)
def test_a_column_of_another_unit_is_refused(
    column: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = three_runs(tmp_path)
    for command in ("init", "diagnose"):
        assert run([command, *files, *column, "--added-mass", "0,0.5,1"]) == 2
        assert f"case_1.csv: {words}" in capsys.readouterr().err
    assert not (tmp_path / "campaign.toml").exists()


def test_a_sensor_gives_volts_whose_meters_are_said(tmp_path: Path) -> None:
    files = three_runs(tmp_path, "t_s,AI1 (V),AI0 (V)\n")
    said = ["--position", "AI1 (V)", "--position-unit", "0.01", "--input", "AI0 (V)", "--added-mass", "0,0.5,1"]
    assert run(["init", *files, *said]) == 0
    assert stepid.read_campaign(tmp_path)[0].position.max() == pytest.approx(0.15, rel=0.1)


def test_an_answer_that_is_refused_is_asked_for_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "".join(f"{0.01 * n:.2f};{n % 7};{n % 5};0.5\n" for n in range(60))
    (tmp_path / "a.csv").write_text("t_s;x1_mm;x2_mm;u_V\n" + rows)
    typed = iter(["u_V", "x2_mm"])
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True)
    monkeypatch.setattr("builtins.input", lambda: next(typed))
    assert run(["init", str(tmp_path / "a.csv"), "--added-mass", "0"]) == 0
    assert "column 'u_V' is in V by its name, no position" in capsys.readouterr().out
    assert stepid.read_campaign(tmp_path)[0].position.max() == pytest.approx(0.004)


def test_force_replaces_a_manifest_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    files = three_runs(tmp_path)
    target = tmp_path / "campaign.toml"
    target.write_text("mine")
    said = ["--added-mass", "0,0.5,1", "--force"]

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        assert run(["init", *files, *said]) == 2
    assert "cannot be written (No space left on device)" in capsys.readouterr().err
    assert target.read_text() == "mine"
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".csv", ".csv", ".csv", ".toml"]
    assert run(["init", *files, *said]) == 0
    assert len(stepid.read_campaign(target)) == 3


@pytest.mark.skipif(sys.platform != "linux", reason="other systems refuse such names")
def test_a_name_that_is_no_text_is_refused_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (first, *_) = three_runs(tmp_path)
    odd = os.fsdecode(os.fsencode(tmp_path) + b"/Federd\xe4mpfer_1kg.csv")
    Path(first).rename(odd)
    (tmp_path / "campaign.toml").write_text("mine")
    assert run(["init", odd, "--force"]) == 2
    told = capsys.readouterr().err
    assert "mpfer_1kg.csv': a name is not text" in told
    assert "Rename it." in told
    assert (tmp_path / "campaign.toml").read_text() == "mine"
    with pytest.raises(stepid.errors.InputError, match="a name is not text"):
        stepid.draft_campaign(odd).write(tmp_path / "other.toml")
    assert not (tmp_path / "other.toml").exists()


def test_options_for_recordings_are_refused_beside_a_manifest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["init", *three_runs(tmp_path), "--added-mass", "0,0.5,1"]) == 0
    assert run(["diagnose", str(tmp_path), "--added-mass", "0,0.5,1"]) == 2
    assert "--added-mass is for recordings" in capsys.readouterr().err


def turning(folder: Path, head: str = "t_s,angle_deg,torque [Nm]\n") -> list[str]:
    files = three_runs(folder, head)
    for file, name in zip(files, ("bare", "with_0.5kg", "two"), strict=True):
        Path(file).rename(folder / f"{name}.csv")
    return [str(folder / f"{name}.csv") for name in ("bare", "with_0.5kg", "two")]


def test_what_is_in_degrees_turns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = turning(tmp_path)
    assert run(["init", *files]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "Which inertias were added, in kg·m² (bare, two, with 0.5kg)? (--added-mass)" in told
    assert "0.5 kg were added by the name: give their moment of inertia, in kg·m²" in told
    assert run(["init", *files, "--added-mass", "0,0.01,0.02", "--force"]) == 0
    text = (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    assert 'motion = "rotation"' in text
    assert "position_scale = 0.017453292519943295  # rad per deg, by its name" in text
    assert "# kg·m², as you said" in text
    assert "kg were added" not in text
    read = stepid.read_campaign(tmp_path)
    assert (read.motion, read.input_unit) == ("rotation", "N·m")
    assert np.ptp(read["bare"].position) < 0.5


def test_counts_turn_where_it_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = three_runs(tmp_path, "t_s,x_counts,current_A\n")
    said = ["--added-mass", "0,0.01,0.02", "--motion", "rotation"]
    assert run(["init", *files, *said]) == 0
    assert "How many counts are one radian? (--counts-per-meter)" in " ".join(capsys.readouterr().out.split())
    assert run(["init", *files, *said, "--counts-per-meter", "2546.5", "--force"]) == 0
    read = stepid.read_campaign(tmp_path)
    assert (read.motion, read.input_unit, read["case 1"].counts_per_meter) == ("rotation", "A", 2546.5)
    assert run(["init", *files, "--motion", "sideways", "--force"]) == 2
    assert "motion is 'sideways'. Give translation or rotation." in capsys.readouterr().err


def test_an_angle_driven_by_a_force_is_no_rotation_yet(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = turning(tmp_path, "t_s,angle_deg,force_N\n")
    assert run(["init", *files, "--added-mass", "0,0.01,0.02"]) == 0
    assert 'with motion = "rotation" give the torque in N·m' in " ".join(capsys.readouterr().out.split())
    assert (stepid.read_campaign(tmp_path).motion, stepid.read_campaign(tmp_path).input_unit) == ("translation", "N")


def test_degrees_are_not_taken_for_radians(tmp_path: Path) -> None:
    (file, *_) = turning(tmp_path)
    with pytest.raises(stepid.errors.InputError, match="'angle_deg' is in deg by its name") as refused:
        stepid.read_table(
            file, time="t_s", position="angle_deg", input=2, name="r", added_mass=0.0, spring="s", damper="d"
        )
    assert "Give position_scale = 0.0174532925199" in str(refused.value)
