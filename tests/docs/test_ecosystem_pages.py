"""The pages about other tools and the command line say what the code does."""

from __future__ import annotations

import json
import re
import runpy
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

import diagnosis_example as example
import stepid
from stepid.cli import app, run
from stepid.effects import CATALOGUE
from stepid.report.json_values import FORMAT

DOCS = Path(__file__).resolve().parents[2] / "docs"
COMMAND_LINE = (DOCS / "how-to" / "command-line.md").read_text(encoding="utf-8")


def keys_after(words: str) -> set[str]:
    """First column of the table that follows some words on the page."""
    table = COMMAND_LINE.split(words)[1].split("\n\n")[1]
    return set(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE))


def test_the_table_of_effects_is_the_codes() -> None:
    path = DOCS / "how-to" / "ecosystem.md"
    text = path.read_text(encoding="utf-8")
    made = runpy.run_path(str(DOCS / "make_tables.py"))
    assert made["page"](path) == text, "run python docs/make_tables.py"
    rows = text.split(made["BEGIN"])[1].split(made["END"])[0].splitlines()[2:]
    assert [re.search(r"`(\w+)`", row)[1] for row in rows] == [e.name for e in CATALOGUE]  # type: ignore[index]


def test_the_page_lists_every_command() -> None:
    commands = set(get_command(app).commands)  # type: ignore[attr-defined]
    assert set(re.findall(r"^\| `stepid (\w+)", COMMAND_LINE, re.MULTILINE)) == commands


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    def ready(_: stepid.Campaign, *, progress: Any, effort: Any) -> stepid.Diagnosis:
        progress(stepid.Progress("linear fit"))
        return example.named()

    monkeypatch.setattr(stepid, "diagnose", ready)
    stepid.write_campaign(example.campaign(), tmp_path / "lab")
    return tmp_path / "lab" / "campaign.toml"


def printed(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    assert run([*arguments, "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    values: dict[str, Any] = json.loads(out)
    assert (values["format"], values["stepid"]) == (FORMAT, stepid.__version__)
    return values


@pytest.mark.parametrize("command", ["identify", "diagnose", "paper"])
def test_json_has_the_keys_of_the_page(command: str, lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    values = printed([command] + [str(lab)] * (command != "paper"), capsys)
    assert values.keys() == keys_after("All four begin with:") | keys_after(f"`stepid {command}` adds")


def test_json_of_the_results_comes_back(lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = stepid.identify(stepid.read_campaign(lab))
    values = printed(["identify", str(lab)], capsys)
    assert stepid.IdentifiedParameters.from_dict(values["parameters"]) == found
    diagnosed = printed(["diagnose", str(lab)], capsys)
    assert stepid.PlantModel.from_dict(diagnosed["model"]) == example.named().model
    assert diagnosed["gap"] == example.named().gap.to_dict()
    assert keys_after("`stepid diagnose` adds") == stepid.Diagnosis.model_fields.keys() - {"data"}
    assert all("measured" not in each for each in diagnosed["runs"])
    paper = printed(["paper"], capsys)
    assert paper["parameters"]["masses"] == dict(stepid.rebuild_paper().parameters.masses)
    assert all("time" not in each for each in paper["responses"])


def test_progress_on_a_terminal_leaves_the_json_alone(
    lab: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich then takes both streams for terminals
    assert run(["diagnose", str(lab), "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["verdict"] == "named"
    assert "diagnosing: linear fit" in err
