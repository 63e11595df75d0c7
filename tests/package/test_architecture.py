"""The layers hold, and `import stepid` stays light."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HEAVY = ["control", "matplotlib", "numpy", "scipy", "pydantic", "pandas", "plotly", "jinja2", "typer", "rich", "panel"]
ONE_ROOM = {
    "control": "identification",
    "pandas": "core",
    "matplotlib": "plot",
    "typer": "cli",
    "rich": "cli",
    "jinja2": "report",
    "plotly": "report",
    "panel": "webapp",
    "param": "webapp",
}


def python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT)
    return done.stdout.strip()


def test_import_contracts_hold() -> None:
    code = "from importlinter.cli import lint_imports_command as lint; lint(['--no-cache'])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"Contracts: [1-9]\d* kept, 0 broken", done.stdout)


def test_the_page_about_the_house_shows_these_layers() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    (layers,) = [contract["layers"] for contract in contracts if contract["type"] == "layers"]
    shown = "\n".join(" · ".join(name.strip() for name in layer.split("|")) for layer in layers)
    assert f"```text\n{shown}\n```" in (ROOT / "docs" / "architecture.md").read_text("utf-8")


def test_the_top_of_the_package_is_seen_at_a_glance() -> None:
    entries = [p.name for p in (ROOT / "src" / "stepid").iterdir() if p.name != "__pycache__"]
    assert {"__init__.py", "core"} <= set(entries)
    assert len(entries) <= 18


def test_importing_stepid_loads_nothing_heavy() -> None:
    loaded = python("import sys, stepid; print(*sorted(sys.modules))").split()
    assert "stepid" in loaded
    assert not set(HEAVY) & set(loaded)


def test_the_core_loads_no_optional_package() -> None:
    names = "Campaign Experiment read_campaign identify solve transfer_function verify"
    loaded = python(f"import sys, stepid; [getattr(stepid, n) for n in '{names}'.split()]; print(*sys.modules)").split()
    assert "stepid.core.experiment" in loaded
    assert not {"control", "matplotlib", "pandas", "plotly", "jinja2", "typer", "rich"} & set(loaded)


@pytest.mark.parametrize(
    "use",
    [
        "import stepid",
        "import stepid; stepid.diagnose",
        "import stepid; stepid.fit, stepid.simulate",
        "from stepid.cli import run; run(['--version'])",
    ],
)
def test_the_compiler_comes_with_the_first_simulation(use: str) -> None:
    loaded = python(f"{use}; import sys; print(*sys.modules)").split()
    assert "stepid" in loaded
    assert not {"numba", "llvmlite", "control", "scipy.optimize"} & set(loaded)


@pytest.mark.parametrize("package", ONE_ROOM)
def test_each_outside_package_has_one_room(package: str) -> None:
    source = ROOT / "src" / "stepid"
    pattern = re.compile(rf"^\s*(import|from) {package}\b", re.MULTILINE)
    rooms = {p.relative_to(source).parts[0] for p in source.rglob("*.py") if pattern.search(p.read_text("utf-8"))}
    assert rooms <= {ONE_ROOM[package]}
