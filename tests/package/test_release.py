"""What a release shows elsewhere: the workflow, the README on a package index, the page on citing."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = ROOT / ".github" / "workflows" / "ci.yml"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PICTURE = re.compile(r"!\[[^\]]*\]\(([^)]+)\)")


def workflow() -> Any:
    return yaml.safe_load(WORKFLOW.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "command", [("check-jsonschema", "--builtin-schema", "vendor.github-workflows"), ("zizmor", "--offline", "--quiet")]
)
def test_the_workflow_is_clean(command: tuple[str, ...]) -> None:
    program = shutil.which(command[0], path=str(Path(sys.executable).parent))
    if program is None:
        pytest.skip(f"{command[0]} is not installed")
    done = subprocess.run([program, *command[1:], str(WORKFLOW)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_workflow_runs_each_system_and_each_python() -> None:
    matrix = workflow()["jobs"]["tests"]["strategy"]["matrix"]
    assert {name.split("-")[0] for name in matrix["os"]} == {"ubuntu", "macos", "windows"}
    versions = [c.rsplit(" ", 1)[1] for c in PROJECT["project"]["classifiers"] if re.search(r"Python :: 3\.\d", c)]
    assert matrix["python"] == versions


def test_the_workflow_runs_sessions_that_are() -> None:
    text = (ROOT / "noxfile.py").read_text(encoding="utf-8")
    places = {name: where for where, name in re.findall(r"@nox.session\(python=VERSIONS(.*)\)\ndef (\w+)\(", text)}
    assert places["tests"] == ""
    versions = workflow()["jobs"]["tests"]["strategy"]["matrix"]["python"]
    for each in workflow()["jobs"]["sessions"]["strategy"]["matrix"]["include"]:
        assert each["python"] == versions[int(places[each["session"]].strip("[]"))], each


def test_a_package_index_gets_no_picture_that_it_does_not_have() -> None:
    pytest.importorskip("hatch_fancy_pypi_readme")
    command = [sys.executable, "-m", "hatch_fancy_pypi_readme"]
    shown = subprocess.run(command, cwd=ROOT, capture_output=True, check=True).stdout.decode("utf-8")
    here = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(PICTURE.findall(here)) == 2
    assert all(target.startswith("https://") for target in PICTURE.findall(shown))
    assert re.findall(r"^#.*", shown, re.MULTILINE) == re.findall(r"^#.*", here, re.MULTILINE)
    gone = [line for line in here.splitlines() if line not in shown.splitlines()]
    assert all(re.search(r"^!\[|^\*|\*$|report\.html", line) for line in gone), "more went than pictures and captions"


def test_what_is_cited_is_this_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == PROJECT["project"]["version"]
    page = (ROOT / "docs" / "citing.md").read_text(encoding="utf-8")
    for words in (citation["title"], f"{{{citation['version']}}}", f"{{{citation['date-released']}}}"):
        assert words in page
    assert citation["references"][0]["title"] in page
