"""The site: theory names the functions that are, the reference every public name, and no page is lost."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path

import pytest

import stepid
from stepid.effects import CATALOGUE

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
LINK = re.compile(r"\{py:(?:func|class|attr|meth)\}`([\w.]+)`")


def text(page: str) -> str:
    return (DOCS / page).read_text(encoding="utf-8")


def rows(part: str) -> list[list[str]]:
    """Cells of all rows of the tables in a text, headings and rules left out."""
    out: list[list[str]] = []
    for line in part.splitlines():
        if line.startswith("|"):
            out.append([cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]])
    return [row for row, after in zip(out, [*out[1:], []], strict=True) if "---" not in (row + after)]


def resolve(name: str) -> object:
    """The object of a dotted name: a module's function, or an attribute of a class in it."""
    parts = name.split(".")
    for cut in range(len(parts) - 1, 0, -1):
        try:
            item: object = importlib.import_module(".".join(parts[:cut]))
        except ModuleNotFoundError:
            continue
        for part in parts[cut:]:
            item = getattr(item, part)
        return item
    raise AssertionError(f"there is no {name}")


def test_theory_has_every_equation_of_the_paper() -> None:
    page = text("theory.md")
    for number in range(1, 12):
        assert f"\\tag{{{number}}}" in page, f"Eq. {number} is missing"
    for number in range(12, 16):
        assert f"({number})" in page, f"Eq. {number} is missing"
    for case in stepid.rebuild_paper().printed:
        number = case.equation.removeprefix("Eq. ")
        shown = re.search(rf"\\frac{{([\d.]+)}}{{([\d.]+)s\^2 \+ ([\d.]+)s \+ 1}} \\;\({number}\)", page)
        assert shown is not None
        assert [float(v) for v in shown.groups()] == pytest.approx(
            [100 * case.static_gain, case.second_order_corrected, case.first_order]
        )


def test_every_formula_of_the_theory_names_a_function_that_is() -> None:
    page = text("theory.md")
    table = rows(page)
    assert len(table) > 40
    for row in table:
        assert LINK.search(row[-1]), f"no function in the row {row[0]!r}"
    names = LINK.findall(page)
    assert len(set(names)) > 40
    for name in names:
        assert callable(resolve(name)) or isinstance(resolve(name), property), name


def test_theory_covers_the_diagnosis() -> None:
    part = text("theory.md").split("## The diagnosis")[1]
    modules = {name.rsplit(".", 1)[0] for name in LINK.findall(part)}
    for module in (
        "floor",
        "diagnose.force",
        "diagnose.locate",
        "diagnose.compete",
        "diagnose.verdict",
        "diagnose.held_out",
        "diagnose.advise",
        "engine.score",
    ):
        assert f"stepid.{module}" in modules


def test_reference_agrees_with_the_stub() -> None:
    stub = ast.parse((ROOT / "src" / "stepid" / "__init__.pyi").read_text(encoding="utf-8"))
    names = {alias.asname or alias.name for n in stub.body if isinstance(n, ast.ImportFrom) for alias in n.names}
    assert len(names) > 30
    listed = set(re.findall(r"auto(?:function|class|module|data):: stepid\.([\w.]+)", text("reference.md")))
    wanted = set(names)
    for module in ("plot", "datasets", "effects"):
        members = getattr(getattr(stepid, module), "__all__", ())
        wanted |= {f"{module}.{name}" for name in members if callable(getattr(getattr(stepid, module), name))}
    assert wanted <= listed, f"missing in reference.md: {sorted(wanted - listed)}"
    for name in listed:
        assert resolve(f"stepid.{name}") is not None


def test_every_page_is_in_a_table_of_contents() -> None:
    shown: set[Path] = set()
    for page in PAGES:
        for block in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            entries = [line for line in block.splitlines() if line and not line.startswith(":")]
            for entry in entries:
                found = list(page.parent.glob(f"{entry}.md")) + list(page.parent.glob(f"{entry}.ipynb"))
                assert found, f"{page.name} lists {entry}"
                shown |= set(found)
    everything = {*PAGES, *(DOCS / "notebooks").glob("*.ipynb")}
    assert everything - shown == {DOCS / "index.md"}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_between_pages_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"(?<!!)\[[^\]]*\]\(([^)#:]+)(?:#[\w-]*)?\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).is_file(), f"{page.name} links {target}"


def test_which_tool_says_where_others_are_better() -> None:
    page = text("which-tool-when.md")
    head, *table = [line for line in page.splitlines() if line.startswith("|")]
    tools = [cell.strip() for cell in head.split("|")[2:-1]]
    assert tools == [
        "stepid",
        "MATLAB System Identification Toolbox",
        "python-control",
        "lmfit",
        "PySINDy",
        "SysIdentPy",
    ]
    body = [line for line in table if "---" not in line]
    cells = [line.split("|")[1:-1] for line in body]
    assert all(len(row) == len(tools) + 1 and all(cell.strip() for cell in row[1:]) for row in cells)
    for i in range(1, len(tools) + 1):
        assert any("**" in row[i] for row in cells), f"{tools[i - 1]} is nowhere best"
    assert sum("**" in row[1] for row in cells) < sum(any("**" in cell for cell in row[2:]) for row in cells)
    assert len(CATALOGUE) == 20
    assert "the twenty\neffects of its" in page
