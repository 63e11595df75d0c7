"""The site: theory names the functions that are, the reference every public name, and no page is lost."""

from __future__ import annotations

import ast
import importlib
import re
import runpy
from pathlib import Path
from types import ModuleType

import matplotlib as mpl
import pytest

import stepid
from stepid.effects import CATALOGUE

ROOT = Path(__file__).resolve().parents[2]
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


def path_of(name: str) -> str:
    """The path below stepid of a public name: a module's own, which may lie in a room."""
    item = getattr(stepid, name)
    return item.__name__.removeprefix("stepid.") if isinstance(item, ModuleType) else name


def same_but_for_last_digits(one: str, two: str) -> bool:
    """Tell whether texts agree: words exactly, numbers within 1 %, uncertainties within 15 %; widths do not count."""
    pattern = re.compile(r"(±\s*)?(-?\d+\.?\d*(?:e[+-]?\d+)?)")
    plain = [" ".join(re.sub(r"-{3,}", " ", pattern.sub(r"\1#", text)).split()) for text in (one, two)]
    numbers = [pattern.findall(text) for text in (one, two)]
    if plain[0] != plain[1] or len(numbers[0]) != len(numbers[1]):
        return False
    return all(
        float(a) == pytest.approx(float(b), rel=0.15 if plus else 0.01, abs=1e-9)
        for (plus, a), (_, b) in zip(*numbers, strict=True)
    )


@pytest.mark.slow
def test_outputs_on_the_pages_are_what_the_code_prints(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    made = runpy.run_path(str(DOCS / "make_outputs.py"))
    for page in made["PAGES"]:
        said = page.read_text(encoding="utf-8")
        assert said.count(made["MARK"]) >= 5
        assert not re.search(r"```text\n```", said)
        assert same_but_for_last_digits(made["fill"](said), said), "run python docs/make_outputs.py"


def test_comparison_of_outputs_sees_what_matters() -> None:
    assert same_but_for_last_digits("mass 1.000 ± 0.010 kg\n-----", "mass  1.004 ± 0.011 kg\n------")
    assert not same_but_for_last_digits("mass 1.000 ± 0.010 kg", "mass 1.020 ± 0.010 kg")
    assert not same_but_for_last_digits("mass 1.000 kg", "mass 1.000 g")
    assert not same_but_for_last_digits("1 2", "1 2 3")


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
        "fitting.noise_floor",
        "diagnosis.residual_force",
        "diagnosis.locate",
        "diagnosis.selection.search",
        "diagnosis.evidence",
        "diagnosis.remainder",
        "diagnosis.verdict",
        "fitting.cross_validation",
        "diagnosis.experiment_design",
        "fitting.score_test",
    ):
        assert f"stepid.{module}" in modules


def test_reference_agrees_with_the_stub() -> None:
    stub = ast.parse((ROOT / "src" / "stepid" / "__init__.pyi").read_text(encoding="utf-8"))
    names = {alias.asname or alias.name for n in stub.body if isinstance(n, ast.ImportFrom) for alias in n.names}
    assert len(names) > 30
    listed = set(re.findall(r"auto(?:function|class|module|data):: stepid\.([\w.]+)", text("reference.md")))
    wanted = {path_of(name) for name in names}
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
    assert len(CATALOGUE) == 23
    assert "the twenty-three\neffects of its" in page


def test_limits_page_gives_the_numbers_of_the_tutorial() -> None:
    numbers = r"base mass of ([\d.]+) kg,\nthe fit with friction ([\d.]+) ± ([\d.]+) kg; ([\d.]+) kg was put in"
    found = re.search(numbers, text("limits.md"))
    assert found is not None
    hand, joint, spread, truth = map(float, found.groups())
    assert stepid.datasets.lab_truth().base_mass["cart"] == truth
    tutorial = text("tutorial.md")  # whose outputs are tested above
    fitted = re.search(r"^base_mass: ([\d.]+) ± ([\d.]+) kg", tutorial, re.MULTILINE)
    by_hand = re.search(r"^base mass \[cart\] +([\d.]+) ±", tutorial, re.MULTILINE)
    assert fitted is not None
    assert by_hand is not None
    assert (round(float(fitted[1]), 4), round(float(fitted[2]), 4)) == (joint, spread)
    assert round(float(by_hand[1]), 2) == hand
