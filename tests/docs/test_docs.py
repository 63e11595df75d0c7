"""Docs that cannot lie: every code block runs, the notebook runs, the site builds without a warning."""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import matplotlib as mpl
import nbformat
import numpy as np
import pytest
from matplotlib import pyplot as plt
from nbclient import NotebookClient

import stepid
from stepid.cli import run

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
LONG = {"why-your-model-does-not-fit.ipynb", "your-own-rig.ipynb", "instructor.ipynb", "lab-handout.ipynb"}
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(page: Path) -> list[tuple[str, str]]:
    return BLOCK.findall(page.read_text(encoding="utf-8"))


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with lab/campaign.toml and the tables run1.csv, …, as the pages speak of them; no windows."""
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    campaign = stepid.datasets.lab_campaign()
    stepid.write_campaign(campaign, tmp_path / "lab")
    for i, name in enumerate(("case 4", "case 5"), start=1):
        run = campaign[name]
        table = np.column_stack([run.time, 1e3 * run.position, run.input])
        np.savetxt(f"run{i}.csv", table, fmt="%.6f", delimiter=",", header="time_s,position_mm,voltage_V", comments="")
    return tmp_path


SLOW = ("report.md", "tutorial.md", "torsion.md", "diagnosis.md")  # every picture, or a diagnosis


@pytest.mark.parametrize(
    "page", [pytest.param(p, marks=[pytest.mark.slow] * (p.name in SLOW), id=p.name) for p in PAGES]
)
def test_code_blocks_run(page: Path, lab: Path) -> None:
    names: dict[str, object] = {"__name__": "__main__"}
    for language, text in blocks(page):
        if language == "python":
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(text, f"{page.name}", "exec"), names)
        elif language == "console":
            for line in re.findall(r"^\$ (.+)$", text, re.MULTILINE):
                program, *arguments = shlex.split(line)
                assert program == "stepid", f"{page.name} runs something else: {line}"
                with contextlib.redirect_stdout(io.StringIO()):
                    assert run(arguments) == 0, line
        elif language == "toml":
            tomllib.loads(text)
        else:
            assert language in {"bash", "text"}, f"{page.name} has an unchecked block of {language}"
    plt.close("all")


def test_the_readmes_table_manifest_reads_as_its_python_does(lab: Path) -> None:
    (manifest,) = [text for language, text in blocks(ROOT / "README.md") if language == "toml" and "table" in text]
    (script,) = [text for language, text in blocks(ROOT / "README.md") if language == "python" and "read_table" in text]
    (lab / "campaign.toml").write_text(manifest, encoding="utf-8")
    names: dict[str, object] = {"stepid": stepid}
    exec(script, names)
    rig = stepid.read_campaign(lab)
    other = names["rig"]
    assert isinstance(other, stepid.Campaign)
    assert [e.added_mass for e in rig.experiments] == [0.0, 0.5]
    for mine, theirs in zip(rig.experiments, other.experiments, strict=True):
        np.testing.assert_array_equal(mine.position, theirs.position)
        np.testing.assert_array_equal(mine.input, theirs.input)
    assert stepid.identify(rig).stiffness["medium"] == pytest.approx(stepid.identify(other).stiffness["spring"])


def test_readme_has_its_commands() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = dict(re.findall(r"<!-- command: (\w+) -->\n```bash\n(.+)\n```", text))
    assert commands.keys() == {"paper", "tests", "docs"}
    assert commands["paper"].endswith("stepid paper --out out")
    assert commands["tests"].endswith("pytest -n auto")
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert all(f"readme {name})" in ci for name in commands)  # run there in fresh environments
    shown = subprocess.run(
        ["bash", "-c", re.search(r"^readme\(\).*$", ci, re.MULTILINE)[0] + "; readme tests"],  # type: ignore[index]
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    assert shown.stdout.strip() == commands["tests"]


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda p: p.name)
def test_commands_install_what_there_is_with_the_pip_that_python_brings(page: Path) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    text = page.read_text(encoding="utf-8")
    commands = [body for language, body in blocks(page) if language == "bash"]
    commands += [words for words in re.findall(r"`([^`\n]+)`", text) if words.startswith(("pip ", "python -m pip"))]
    for command in commands:
        extras = [name for part in re.findall(r"(?:stepid|\.)\[([\w,]+)\]", command) for name in part.split(",")]
        assert set(extras) <= project["project"]["optional-dependencies"].keys(), command
        first, *groups = re.split(r"--group +(?=\w)", command)
        assert {re.match(r"\w+", group)[0] for group in groups} <= project["dependency-groups"].keys(), command  # type: ignore[index]
        assert not groups or "python -m pip install --upgrade pip" in first, "a group needs pip 25.1: upgrade it first"


def test_pictures_of_the_pages_exist() -> None:
    for page in PAGES:
        for target in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).is_file(), f"{page.name} shows {target}"


def test_misprints_page_lists_what_the_code_lists() -> None:
    page = (ROOT / "docs" / "misprints.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1].strip() for line in page.splitlines() if line.startswith("| ")][1:]
    spoken = [re.sub(r"\$([^$]*)\$", lambda m: m[1].replace("s^2", "s²"), row) for row in rows if row != "---"]
    assert spoken == [m.where for m in stepid.rebuild_paper().misprints]


def test_every_equation_links_to_its_function() -> None:
    page = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
    for number in ["1", "2", "3", "4", "6", "7", "8", "9", "10", "11"]:
        assert f"\\tag{{{number}}}" in page, f"Eq. {number} is missing"
    for target in re.findall(r"\{py:(?:func|class)\}`([^`]+)`", page):
        module, _, name = target.rpartition(".")
        assert getattr(__import__(module, fromlist=[name]), name) is not None


def test_reference_lists_every_public_name() -> None:
    page = (ROOT / "docs" / "reference.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"auto(?:function|class|module):: stepid\.([\w.]+)", page))
    missing = set(stepid.__all__) - listed - {"characteristics"}
    assert not missing, f"missing in reference.md: {sorted(missing)}"
    assert stepid.characteristics.__name__.removeprefix("stepid.") in listed


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.name)
def test_notebooks_carry_no_output(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    assert notebook.cells
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=pytest.mark.slow if p.name in LONG else ()) for p in NOTEBOOKS],
    ids=lambda p: p.name,
)
@pytest.mark.filterwarnings("ignore::DeprecationWarning:jupyter_client.*", "ignore::DeprecationWarning:zmq.*")
def test_notebooks_run(path: Path, tmp_path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3"}
    done = NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [o for cell in done.cells if cell.cell_type == "code" for o in cell.outputs]
    assert any("image/png" in o.get("data", {}) for o in outputs), "the notebook draws nothing"
    assert not [o for o in outputs if o.output_type == "stream" and o.name == "stderr"]


def test_slow_notebooks_exist() -> None:
    assert {p.name for p in NOTEBOOKS} >= LONG


@pytest.mark.slow
def test_site_builds_without_a_warning(tmp_path: Path) -> None:
    quick = ["-D", "nb_execution_mode=off"]  # the notebooks run in a test of their own
    command = [sys.executable, "-m", "sphinx", "-n", "-W", "--keep-going", "-q", *quick, "docs", str(tmp_path / "site")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, env={**os.environ})
    assert done.returncode == 0, done.stderr
    assert "_static/mathjax/" in (tmp_path / "site" / "theory.html").read_text(encoding="utf-8")
    assert (tmp_path / "site" / "_static" / "mathjax" / "tex-chtml.js").is_file()
    loads = re.compile(r'<(?:script|link)\b[^>]*(?:src|href)="https?:')  # the site is to be read without network
    for page in (tmp_path / "site").rglob("*.html"):
        assert not loads.search(page.read_text(encoding="utf-8")), page.name
