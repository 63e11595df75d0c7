"""The page about the diagnosis: its catalogue is that of the code, its words are those of the figure."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import stepid
from stepid.diagnosis.phases import PHASES
from stepid.effects import CATALOGUE

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = DOCS / "diagnosis.md"


def test_the_catalogue_on_the_page_is_the_codes() -> None:
    text = PAGE.read_text(encoding="utf-8")
    made = runpy.run_path(str(DOCS / "make_tables.py"))
    assert made["page"](PAGE) == text, "run python docs/make_tables.py"
    table = text.split(made["BEGIN"])[1].split(made["END"])[0]
    rows = [re.split(r"(?<!\\)\|", line)[1:-1] for line in table.splitlines()[2:]]
    assert [row[0].strip(" `") for row in rows] == [effect.name for effect in CATALOGUE]
    assert all(len(row) == 5 and all(cell.strip() for cell in row) for row in rows)
    for row, effect in zip(rows, CATALOGUE, strict=True):
        assert re.findall(r"`(\w+)`", row[2]) == [q.name for q in (*effect.parameters, *effect.run_parameters)]


def test_the_page_explains_verdicts_and_phases() -> None:
    text = PAGE.read_text(encoding="utf-8")
    for verdict in ("adequate", "named", "ambiguous", "unexplained"):
        assert f"| `{verdict}` |" in text
    paragraph = text.split("**Phases.**")[1].split("\n\n")[0].lower()
    assert all(phase in paragraph for phase in PHASES if phase != "driven")


def test_the_numbers_on_the_page_about_evidence_are_the_codes() -> None:
    text = (DOCS / "evidence.md").read_text(encoding="utf-8")
    made = runpy.run_path(str(DOCS / "make_tables.py"))
    assert made["page"](DOCS / "evidence.md") == text, "run python docs/make_tables.py"
    for model in (stepid.Criteria, stepid.Effort):
        assert made["explained"](model).keys() == model.model_fields.keys()
        assert all(words.endswith(".") for words in made["explained"](model).values())
        assert all(f"| `{name}` |" in text for name in model.model_fields)


def test_the_page_about_moves_names_places_that_are() -> None:
    text = (DOCS / "how-to" / "add-a-move-or-rule.md").read_text(encoding="utf-8")
    places = re.findall(r"`(stepid/[\w/]+(?:\.py)?/?)`", text)
    assert len(places) >= 8
    assert all((DOCS.parent / "src" / place).exists() for place in places)
