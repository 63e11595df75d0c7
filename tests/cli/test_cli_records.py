"""What is a recording and what a manifest, where the name of a single file does not tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stepid
from stepid.cli import run
from stepid.io.guess.files import holds_records

T = 0.01 * np.arange(200)
X = 8 * (1 - np.exp(-2 * T) * np.cos(15 * T))  # mm
TABLE = "% t (s)\tx (mm)\tu (V)\n" + "".join(f"{t:.3f}\t{x:.4f}\t0.5\n" for t, x in zip(T, X, strict=True))
MANIFEST = Path(stepid.datasets.__file__).parent / "lab" / "campaign.toml"


@pytest.mark.parametrize("name", ["rigidarm_K1_9", "run.log", "run.2"])
def test_a_table_of_any_name_is_a_recording(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / name).write_text(TABLE, encoding="utf-8")
    assert run(["diagnose", str(tmp_path / name), "--position-unit", "furlong"]) == 2
    assert "'furlong' is no unit of the position" in capsys.readouterr().err
    assert run(["diagnose", str(tmp_path / name)]) == 2
    assert "the recordings do not say all: Which mass was added, in kg? Give --added-mass" in capsys.readouterr().err


def test_a_damaged_table_is_refused_by_its_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = TABLE.splitlines()
    lines[100] = "0.990\toops\toops"
    (tmp_path / "run").write_text("\n".join(lines), encoding="utf-8")
    assert run(["diagnose", str(tmp_path / "run")]) == 2
    assert "run, line 101: is no row like the others" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (MANIFEST.read_text(encoding="utf-8").replace('file = "', 'file = "missing '), "missing "),
        ("name = lab\n", "is no manifest of a campaign (not TOML"),
        ('[{"t": 0.5, "x": 1.5}]', "is no manifest of a campaign but JSON"),
        ("weights = [\n" + "0.5,\n" * 20 + "]\n", "lists no experiments"),
    ],
)
def test_a_manifest_of_any_name_stays_one(
    content: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "lab").write_text(content, encoding="utf-8")
    assert not holds_records(tmp_path / "lab")
    assert run(["diagnose", str(tmp_path / "lab")]) == 2
    assert told in " ".join(capsys.readouterr().err.split())


def test_one_recording_alone_is_cut_into_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = TABLE + "".join(f"{2 + t:.3f}\t{8:.4f}\t0.5\n" for t in T)
    (tmp_path / "run").write_text(table, encoding="utf-8")
    asked = ["diagnose", str(tmp_path / "run"), "--position-unit", "mm", "--added-mass", "0"]
    assert run(asked) == 2
    assert "can be cut: campaign.in_parts(3), or --parts 3" in " ".join(capsys.readouterr().err.split())
    assert run([*asked, "--parts", "1"]) == 2
    assert "the number of parts is 1" in " ".join(capsys.readouterr().err.split())
    assert run([*asked, "--parts", "4", "--effort", "quick"]) == 0
    out, err = capsys.readouterr()
    assert ": 4 runs" in err
    assert "run, part 1" in out


def test_pictures_and_missing_files_are_no_recordings(tmp_path: Path) -> None:
    (tmp_path / "photo.png").write_bytes(bytes(range(256)) * 20)
    assert not holds_records(tmp_path / "photo.png")
    assert not holds_records(tmp_path / "nothing")


@pytest.mark.parametrize("first", ['name = "lab"\n', "[[experiment]]\nname = a\n"])
def test_a_slip_in_a_manifest_beside_many_values_is_said(
    first: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "lab").write_text(first + "step = [\n" + "0.5,\n" * 20 + "]\nfile = a.csv\n", encoding="utf-8")
    assert run(["diagnose", str(tmp_path / "lab")]) == 2
    assert "not TOML" in capsys.readouterr().err
