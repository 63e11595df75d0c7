"""The command line: what it prints, what it writes, and that it leaves nothing behind when it fails."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt

import stepid
from stepid.cli import run
from stepid.core.atomic_write import staged
from stepid.report.file_names import file_names

MANIFEST = Path(stepid.datasets.__file__).parent / "lab" / "campaign.toml"


@pytest.fixture(autouse=True)
def _no_windows() -> Iterator[None]:
    mpl.use("Agg")
    yield
    plt.close("all")  # what a test kept from being saved would be in the next one's way


def test_paper_prints_table_2_beside_the_printed_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["paper"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    (row,) = [line.split() for line in out.splitlines() if line.startswith("case 6  ")][:1]
    assert row == ["case", "6", "2.4356", "2.4357", "15.42", "15.42", "15.42", "0.03698", "0.03698"]
    for phrase in (
        "Eq. 15, case 7",
        "0.01385 (0.001385: misprint)",
        "<TransferFunction>: case 4",
        "3.618 there is 0.03618 m/V here",
        "(ζ₁² − 1)",
    ):
        assert phrase in out
    assert "\x1b[" not in out  # no colors in a pipe


def test_paper_writes_report_and_figures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "deep" / "out"
    assert run(["paper", "--out", str(out)]) == 0
    names = ["fig-3.png", "fig-6.png", "fig-7.png", "fig-8.png", "paper.txt"]
    assert sorted(p.name for p in out.iterdir()) == names
    printed = capsys.readouterr().out
    assert all(str(out / name) in printed for name in names)
    assert "Table 2, rebuilt beside printed" in (out / "paper.txt").read_text(encoding="utf-8")
    assert [p.name for p in tmp_path.iterdir()] == ["deep"]


def test_identify_prints_and_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert run(["identify", str(MANIFEST), "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    campaign = stepid.read_campaign(MANIFEST)
    found = stepid.identify(campaign)
    assert found.summary() in text
    assert stepid.verify(found, campaign).summary() in text
    assert "left out: case 2" in text
    added = found.base_difference("cart, no damper", "cart")
    assert f"base 'cart' minus base 'cart, no damper': {added}" in text
    assert "What mass does" in text
    names = {p.name for p in tmp_path.iterdir()}
    assert {"notes.txt", "report.txt", "parameters.json", "verification.png", "trends.png"} <= names
    assert {f"verification-{run_name.replace(' ', '-')}.png" for run_name in found.masses} <= names
    values = json.loads((tmp_path / "parameters.json").read_text(encoding="utf-8"))
    assert stepid.IdentifiedParameters.model_validate_json(json.dumps(values["parameters"])) == found


def test_json_is_all_that_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["identify", str(MANIFEST), "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    found = stepid.identify(stepid.read_campaign(MANIFEST))
    assert values["parameters"]["masses"] == pytest.approx(dict(found.masses))
    assert {v["name"] for v in values["verification"]} == set(found.masses)


@pytest.mark.parametrize("arguments", [["--help"], ["paper", "--help"], ["identify", "--help"], ["--version"]])
def test_help_and_version(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(arguments) == 0
    out = capsys.readouterr().out
    if arguments == ["--version"]:
        assert out.strip() == f"stepid {stepid.__version__}"
    elif arguments != ["--help"]:
        assert f"stepid {arguments[0]}" in out.split("Example")[1]


def test_wrong_use_is_status_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["pape"]) == 2
    assert run(["identify"]) == 2
    assert run(["identify", str(MANIFEST), "--nonsense"]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_out_that_is_a_file_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "file"
    target.write_text("mine")
    assert run(["paper", "--out", str(target)]) == 2
    assert "is a file, not a folder" in capsys.readouterr().err
    assert target.read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_nothing_is_left_when_drawing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise stepid.errors.InputError("the picture cannot be drawn", "Try again.")

    monkeypatch.setattr("stepid.plot.save", fail)
    assert run(["paper", "--out", str(tmp_path / "out")]) == 2
    assert not list(tmp_path.iterdir())


def test_staged_puts_back_what_it_replaced(tmp_path: Path) -> None:
    out = tmp_path / "a"
    (out / "c").mkdir(parents=True)  # a folder where a file shall go: the third of four cannot be moved
    (out / "a").write_text("mine")
    before = (out / "a").stat()

    def blocked() -> None:
        with staged(out) as folder:
            for name in "abcd":
                (folder / name).write_text("new")

    with pytest.raises(stepid.errors.InputError, match=r"a: cannot be written \("):
        blocked()
    assert sorted(path.name for path in out.iterdir()) == ["a", "c"]
    assert ((out / "a").read_text(), (out / "a").stat().st_mtime_ns) == ("mine", before.st_mtime_ns)
    assert (out / "c").is_dir()
    (out / "c").rmdir()
    blocked()
    assert {path.name: path.read_text() for path in out.iterdir()} == dict.fromkeys("abcd", "new")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_staged_moves_all_or_nothing(tmp_path: Path) -> None:
    def half_done() -> None:
        with staged(tmp_path / "a") as folder:
            (folder / "half").write_text("x")
            raise KeyError("stop")

    with pytest.raises(KeyError):
        half_done()
    assert not list(tmp_path.iterdir())
    with staged(tmp_path / "a") as folder:
        (folder / "whole").write_text("x")
    assert [p.name for p in (tmp_path / "a").iterdir()] == ["whole"]
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


def test_file_names_are_plain_and_unique() -> None:
    names = file_names(["case 4", "case/4", "../x", "…", "Fall 1/2 turn"])
    assert len(set(names.values())) == 5
    assert all("/" not in n and " " not in n and not n.startswith(".") for n in names.values())


def test_file_names_are_short_and_no_two_are_one_file_on_any_system() -> None:
    long = [f"{'recorded in the lab ' * 20}{end}" for end in "ab"]
    names = file_names(["Run A", "run a", "RUN-A", *long, "測" * 200])
    assert list(names.values())[:3] == ["Run-A", "run-a-2", "RUN-A-3"]
    assert len({name.casefold() for name in names.values()}) == 6
    assert all(len(name) <= 90 and len(name.encode()) <= 190 for name in names.values())


@pytest.mark.parametrize("missing", ["typer", "rich"])
def test_missing_extra_is_said_plainly(missing: str) -> None:
    code = f"import sys; sys.modules[{missing!r}] = None; from stepid.__main__ import main; main()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "pip install 'stepid[cli]'" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_console_without_greek_letters_is_no_error() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "stepid", "paper"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "Table 2, rebuilt beside printed" in done.stdout


def test_colors_on_a_terminal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert run(["paper"]) == 0
    assert "\x1b[1m" in capsys.readouterr().out
