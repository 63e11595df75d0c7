"""The public surface: every name resolves, is documented, and agrees with its docstring; the house keeps its sizes."""

from __future__ import annotations

import ast
import importlib.metadata
import inspect
import re
import tomllib
import types
from pathlib import Path
from typing import Any

import pytest
import yaml
from numpydoc.docscrape import NumpyDocString

import stepid

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "stepid"
FILES = sorted([*SOURCE.rglob("*.py"), *(ROOT / "tests").rglob("*.py"), *(ROOT / "benchmarks").rglob("*.py")])


def public_objects() -> list[tuple[str, Any]]:
    """Every public function and class, those of the public modules included."""
    found: dict[str, Any] = {}
    for name in stepid.__all__:
        item = getattr(stepid, name)
        if isinstance(item, types.ModuleType):
            inner = getattr(item, "__all__", None) or [n for n in vars(item) if not n.startswith("_")]
            for other in inner:
                member = getattr(item, other)
                if (inspect.isfunction(member) or inspect.isclass(member)) and member.__module__.startswith(
                    item.__name__
                ):
                    found[f"{name}.{other}"] = member
        else:
            found[name] = item
    return [(n, o) for n, o in found.items() if inspect.isfunction(o) or inspect.isclass(o)]


PUBLIC = public_objects()


def documented(section: list[Any]) -> list[str]:
    names = [name.strip().lstrip("*") for entry in section for name in entry.name.split(",")]
    return [name for name in names if name]


def test_every_public_name_resolves() -> None:
    assert len(stepid.__all__) >= 10
    assert len(set(stepid.__all__)) == len(stepid.__all__)
    for name in stepid.__all__:
        assert getattr(stepid, name) is not None
    assert set(stepid.__all__) <= set(dir(stepid))


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="nonsense"):
        stepid.nonsense  # noqa: B018


@pytest.mark.parametrize(("name", "item"), PUBLIC, ids=[n for n, _ in PUBLIC])
def test_docstring_agrees_with_signature(name: str, item: Any) -> None:
    text = inspect.getdoc(item)
    assert text, f"{name} has no docstring"
    parsed = NumpyDocString(text)
    assert parsed["Summary"], f"{name} has no summary line"
    if inspect.isclass(item) and issubclass(item, BaseException):
        return  # errors are raised by the library, not made by its users
    parameters = [
        p.name
        for p in inspect.signature(item).parameters.values()
        if p.name not in {"self", "cls"} and not p.name.startswith("_")
    ]
    listed = documented([*parsed["Parameters"], *parsed["Other Parameters"]])
    assert sorted(listed) == sorted(parameters), f"{name}: docstring lists {listed}, signature takes {parameters}"
    if inspect.isfunction(item) and inspect.signature(item).return_annotation not in {None, "None"}:
        assert parsed["Returns"] or parsed["Yields"], f"{name} does not say what it returns"


@pytest.mark.parametrize(("name", "item"), PUBLIC, ids=[n for n, _ in PUBLIC])
def test_public_methods_are_documented(name: str, item: Any) -> None:
    if not inspect.isclass(item):
        return
    own = {n: m for n, m in vars(item).items() if not n.startswith("_")}
    for method, member in own.items():
        function = getattr(member, "fget", None) or getattr(member, "func", None) or getattr(member, "__func__", member)
        if inspect.isfunction(function) and function.__module__.startswith("stepid"):
            assert inspect.getdoc(function), f"{name}.{method} has no docstring"


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_files_stay_short(path: Path) -> None:
    if path == SOURCE / "simulation" / "kernel.py":  # one loop, read as a whole
        return
    lines = len(path.read_text(encoding="utf-8").splitlines())
    assert lines <= 300, f"{lines} lines: make two files of it; what tests share goes to the top of `tests`"


@pytest.mark.parametrize("room", ["simulation", "fitting"])
def test_functions_fit_on_a_screen(room: str) -> None:
    for path in sorted((SOURCE / room).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                words = (ast.get_docstring(node, clean=False) or "").count("\n")
                assert node.end_lineno is not None
                assert node.end_lineno - node.lineno - words < 60, f"{path.name}: {node.name}"


@pytest.mark.parametrize("path", sorted(SOURCE.rglob("*.py")), ids=lambda p: str(p.relative_to(SOURCE)))
def test_modules_say_what_they_are(path: Path) -> None:
    assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))


def test_version_is_one() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert stepid.__version__ == project["version"] == importlib.metadata.version("stepid") == citation["version"]
    headings = re.findall(r"^## (\S+) - \d{4}-\d{2}-\d{2}$|^## Unreleased", changelog, flags=re.MULTILINE)
    assert stepid.__version__ in headings  # dated


def test_python_has_no_upper_cap() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["requires-python"] == ">=3.11"


def test_package_is_typed() -> None:
    assert (SOURCE / "py.typed").is_file()
