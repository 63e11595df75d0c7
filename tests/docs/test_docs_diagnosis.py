"""The page about the diagnosis: its catalogue is that of the code, its words are those of the figure."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

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
