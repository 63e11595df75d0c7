"""`stepid init`: from recordings to a campaign, with few answers or none."""

from __future__ import annotations

import os
import pty
import select
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import stepid
from folder_score import answers_of, files_of
from lab_folders import COUNTS_PER_METER, POSITION, TIME, Truth, make_folder
from stepid.cli import run

SOURCE = str(Path(stepid.__file__).parents[1])
QUESTIONS = {
    "Which column is the position": "position",
    "In which unit is the time": "time_unit",
    "In which unit is the position": "position_unit",
    "How many counts are one meter": "counts_per_meter",
    "In which unit is the input": "input_unit",
    "How large was the step": "step",
    "How many kg is one weight": "weight",
    "Which masses were added": "added_mass",
}


def person(folder: Path, truths: list[Truth], *, limit: float = 60.0) -> tuple[int, str]:
    """Run `stepid init` on a terminal and answer what it asks; how many answers, and all that was shown."""
    leader, follower = pty.openpty()
    names = [file.name for file in files_of(truths, folder)]
    child = subprocess.Popen(
        [sys.executable, "-m", "stepid", "init", *names],
        cwd=folder,
        env=os.environ | {"TERM": "xterm-256color", "COLUMNS": "200", "PYTHONPATH": SOURCE},
        stdin=follower,
        stdout=follower,
        stderr=follower,
    )
    os.close(follower)
    shown, heard, answers, end = "", 0, 0, time.monotonic() + limit
    while time.monotonic() < end:
        if select.select([leader], [], [], 0.1)[0]:
            try:
                chunk = os.read(leader, 65536)
            except OSError:  # how Linux says that the other end is closed
                break
            shown += chunk.decode(errors="replace")
        for words, key in QUESTIONS.items():
            if words in shown[heard:] and shown.endswith(("? ", "] ")):
                heard, answers = len(shown), answers + 1
                os.write(leader, ("all" if key == "position" else answers_of(key, truths)).encode() + b"\n")
    os.close(leader)
    assert child.wait(timeout=10) == 0, shown
    return answers, shown


def check_campaign(folder: Path, truths: list[Truth]) -> None:
    """The campaign holds what the script wrote, in SI units."""
    runs = stepid.read_campaign(folder).experiments
    assert len(runs) == len(truths)
    for truth in truths:
        scale = POSITION[truth.position_unit] or 1 / COUNTS_PER_METER
        (mine,) = [
            e
            for e in runs
            if e.position.size == truth.position.size
            and np.allclose(e.position, truth.position * scale, rtol=1e-6, atol=1e-12)
        ]
        assert mine.added_mass == pytest.approx(truth.real_mass)
        tolerance = 1e-3 if truth.format == "ecp" else 1e-9
        np.testing.assert_allclose(mine.time, truth.time * TIME[truth.time_unit], atol=tolerance)


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


def test_a_folder_is_its_files(tmp_path: Path) -> None:
    three_runs(tmp_path)
    assert run(["init", str(tmp_path), "--added-mass", "0;0,5;1", "--out", str(tmp_path / "mine.toml")]) == 0
    assert [e.added_mass for e in stepid.read_campaign(tmp_path / "mine.toml").experiments] == [0.0, 0.5, 1.0]


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


def test_options_for_recordings_are_refused_beside_a_manifest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["init", *three_runs(tmp_path), "--added-mass", "0,0.5,1"]) == 0
    assert run(["diagnose", str(tmp_path), "--added-mass", "0,0.5,1"]) == 2
    assert "--added-mass is for recordings" in capsys.readouterr().err
