"""`stepid diagnose`: what it prints and writes, and that it leaves nothing behind when it fails."""

from __future__ import annotations

import hashlib
import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt

import diagnosis_example as example
import stepid
from stepid.cli import run
from stepid.diagnosis.progress import stage_line
from stepid.diagnosis.result import Diagnosis

LAB = Path(stepid.datasets.__file__).parent / "lab" / "campaign.toml"


@pytest.fixture(autouse=True)
def _no_windows() -> Iterator[None]:
    mpl.use("Agg")
    yield
    plt.close("all")  # what a test kept from being saved would be in the next one's way


@pytest.fixture
def manifest(tmp_path: Path) -> Path:
    stepid.write_campaign(example.campaign(), tmp_path / "lab")
    return tmp_path / "lab" / "campaign.toml"


@pytest.fixture
def stages(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Put the ready-made diagnosis in place of the search; collect the stages that are shown."""
    shown: list[str] = []

    def ready(campaign: stepid.Campaign, *, progress: Any, effort: Any) -> Diagnosis:
        assert [e.name for e in campaign.experiments] == list(example.RUNS)
        progress(stepid.Progress("linear fit"))
        shown.append("linear fit")
        return example.named()

    monkeypatch.setattr(stepid, "diagnose", ready)
    return shown


def test_prints_the_summary_and_the_hand_method(
    manifest: Path, stages: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["diagnose", str(manifest)]) == 0
    out, err = capsys.readouterr()
    assert example.named().summary() in out
    assert "The peak method beside it" in out
    assert "pulls each number" in out
    assert stages == ["linear fit"]
    assert err == f"{example.campaign().name}: 4 runs\ndiagnosing: linear fit\n"  # plain lines, for a log


@pytest.mark.parametrize("option", ["--quiet", "-q", "--json"])
def test_a_log_without_progress(
    option: str, manifest: Path, stages: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["diagnose", str(manifest), option]) == 0
    assert capsys.readouterr().err == ""
    assert stages


def test_releases_are_named_before_the_search(
    stages: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    one, *others = example.campaign().experiments
    released = one.model_copy(update={"input": 0 * one.input, "input_before": 0.0})
    stepid.write_campaign(stepid.Campaign(name="[red] rig", experiments=(released, *others)), tmp_path / "lab")
    assert run(["diagnose", str(tmp_path / "lab" / "campaign.toml")]) == 0
    assert capsys.readouterr().err.startswith(f"[red] rig: 4 runs, free releases (no input): {one.name}\n")
    assert stages


def test_progress_is_shown_on_a_terminal(
    manifest: Path,
    stages: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "500")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("FORCE_COLOR", "1")
    seen: list[str] = []
    ready = stepid.diagnose

    def search(campaign: stepid.Campaign, *, progress: Any, effort: Any) -> Diagnosis:
        progress(stepid.Progress("linear fit"))
        time.sleep(0.3)  # several times what the line needs to be drawn
        return ready(campaign, progress=progress, effort=effort)

    def draw(*_: object) -> None:
        time.sleep(0.3)
        seen.append(capsys.readouterr().err)

    monkeypatch.setattr(stepid, "diagnose", search)
    monkeypatch.setattr("stepid.plot.save", draw)
    monkeypatch.setattr("stepid.report.write.write_all", draw)
    assert run(["diagnose", str(manifest), "--out", str(tmp_path / "out [1]")]) == 0
    assert stages
    assert len(seen) == 2  # while the picture is drawn, and while the report is written
    assert "diagnosing: linear fit" in seen[0]
    assert all(f"writing {tmp_path / 'out [1]'}" in shown for shown in seen)
    capsys.readouterr()
    assert run(["diagnose", str(manifest), "--quiet"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("name", ["quick", "default", "thorough"])
def test_effort_is_handed_on(name: str, manifest: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[stepid.Effort] = []

    def ready(_: stepid.Campaign, *, progress: Any, effort: stepid.Effort) -> Diagnosis:
        asked.append(effort)
        return example.named()

    monkeypatch.setattr(stepid, "diagnose", ready)
    assert run(["diagnose", str(manifest), "--effort", name, "--quiet"]) == 0
    made = {"quick": stepid.Effort.quick(), "default": stepid.Effort(), "thorough": stepid.Effort.thorough()}
    assert asked == [made[name]]
    assert run(["diagnose", str(manifest), "--effort", "endless"]) == 2


def test_progress_tells_the_best_answer_and_what_is_left() -> None:
    assert stage_line(stepid.Progress("linear fit")) == "linear fit"
    first = stepid.Progress("cubic_stiffness", left=12, promise=0.4)
    said = "cubic stiffness | best so far: linear model | 12 left to try"
    said += "; the most promising may explain 40 % of the remaining misfit"
    assert stage_line(first) == said
    last = stepid.Progress("runs held out", best=("coulomb_friction",))
    assert stage_line(last) == "runs held out | best so far: Coulomb friction"


@pytest.mark.slow
def test_writes_text_json_and_figures(
    manifest: Path, stages: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "deep" / "out"
    assert run(["diagnose", str(manifest), "--out", str(out)]) == 0
    stills = [
        f"report-{name}.png" for name in ("candidates", "gap", "records", "ring-down", "runs", "verification", "where")
    ]
    names = ["diagnosis.json", "diagnosis.png", "diagnosis.txt", "report-pictures.pdf", "report.html", "report.md"]
    names = sorted([*names, *stills])
    assert sorted(p.name for p in out.iterdir()) == names
    printed = capsys.readouterr().out
    assert all(str(out / name) in printed for name in names)
    again = Diagnosis.model_validate_json((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert again == example.named()
    text = (out / "diagnosis.txt").read_text(encoding="utf-8")
    assert example.named().summary() in text
    assert all((out / name).read_bytes().startswith(b"\x89PNG") for name in names if name.endswith("png"))
    manifest_hash = hashlib.sha256(manifest.read_bytes()).hexdigest()
    assert all(manifest_hash in (out / name).read_text(encoding="utf-8") for name in ("report.html", "report.md"))
    assert stages


def test_json_is_all_that_is_printed(manifest: Path, stages: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["diagnose", str(manifest), "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["verdict"] == "named"
    assert values["effects"] == ["coulomb_friction"]
    assert values["parameters"]["coulomb_friction.level"]["unit"] == "N"
    assert set(values["runs"][0]) & {"time", "measured", "linear", "model"} == set()
    assert values["runs"][0]["name"] == "case 4"
    assert stages


def test_a_hand_method_that_refuses_is_no_error(
    manifest: Path, stages: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: stepid.Campaign) -> None:
        raise stepid.errors.UndeterminedError("too few runs", "Add one.")

    monkeypatch.setattr(stepid, "identify", refuse)
    assert run(["diagnose", str(manifest)]) == 0
    assert "The peak method cannot use this campaign: too few runs." in capsys.readouterr().out
    assert stages


def test_nothing_is_left_when_drawing_fails(
    manifest: Path, stages: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise stepid.errors.InputError("the picture cannot be drawn", "Try again.")

    monkeypatch.setattr("stepid.plot.save", fail)
    assert run(["diagnose", str(manifest), "--out", str(tmp_path / "out")]) == 2
    assert [p.name for p in tmp_path.iterdir()] == ["lab"]
    assert stages


@pytest.mark.parametrize("options", [[], ["--json"]])
def test_a_report_that_fails_does_not_lose_the_answer(
    options: list[str],
    manifest: Path,
    stages: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("a mistake of ours")

    monkeypatch.setattr("stepid.plot.save", fail)
    with pytest.raises(RuntimeError, match="a mistake of ours"):
        run(["diagnose", str(manifest), *options, "--out", str(tmp_path / "out")])
    printed = capsys.readouterr().out
    assert json.loads(printed)["verdict"] == "named" if options else example.named().summary() in printed
    assert stages


@pytest.mark.parametrize("under", ["file", "file/results"])
@pytest.mark.parametrize("command", ["diagnose", "identify"])
def test_out_is_looked_at_before_the_search(
    command: str,
    under: str,
    manifest: Path,
    stages: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(stepid, "identify", lambda _: stages.append("identified"))
    (tmp_path / "file").write_text("mine")
    assert run([command, str(manifest), "--out", str(tmp_path / under)]) == 2
    assert str(tmp_path / under) in capsys.readouterr().err
    assert not stages
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize(("package", "extra"), [("jinja2", "report"), ("plotly", "report"), ("matplotlib", "plot")])
def test_packages_are_looked_for_before_the_search(
    package: str,
    extra: str,
    manifest: Path,
    stages: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    assert run(["diagnose", str(manifest), "--out", str(tmp_path / "out")]) == 2
    assert f"needs the package {package!r}. Install it with: pip install 'stepid[{extra}]'" in capsys.readouterr().err
    assert not stages
    assert [path.name for path in tmp_path.iterdir()] == ["lab"]


def test_a_diagnosis_that_fails_is_status_2(
    manifest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise stepid.errors.ConvergenceError("no stable plant can be fitted", "Look at the records.")

    monkeypatch.setattr(stepid, "diagnose", fail)
    assert run(["diagnose", str(manifest), "--out", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines()[1:] == ["stepid: no stable plant can be fitted. Look at the records."]
    assert [p.name for p in tmp_path.iterdir()] == ["lab"]


def test_bad_input_is_status_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["diagnose", str(tmp_path / "nothing.toml")]) == 2
    err = capsys.readouterr().err
    assert "nothing.toml" in err
    assert "Traceback" not in err


def test_one_run_cannot_be_diagnosed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = stepid.Campaign(name="one", experiments=example.campaign().experiments[:1])
    stepid.write_campaign(one, tmp_path / "one")
    assert run(["diagnose", str(tmp_path / "one" / "campaign.toml"), "--out", str(tmp_path / "out")]) == 2
    assert "campaign 'one' has one run" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_the_made_up_campaign_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["diagnose", str(LAB), "--out", str(tmp_path / "out")]) == 0
    assert "A linear model is not adequate: Coulomb friction, 0.2" in capsys.readouterr().out
    found = Diagnosis.model_validate_json((tmp_path / "out" / "diagnosis.json").read_text(encoding="utf-8"))
    assert (found.verdict, found.effects) == ("named", ("coulomb_friction",))
    assert found.gap.after <= 1.1 * found.gap.noise
