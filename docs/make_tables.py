"""Write the tables of effects, criteria and effort into the docs. Run with ``python docs/make_tables.py``."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from pathlib import Path

import stepid
from stepid.effects import CATALOGUE
from stepid.identification.transfer.express import why_not_linear, why_not_nonlinear

DOCS = Path(__file__).parent
BEGIN, END = "<!-- table: made by docs/make_tables.py -->\n", "<!-- end of table -->\n"


def catalogue() -> str:
    rows = [
        "| effect | what it adds | parameters | seen in the lab as | what to do |",
        "| --- | --- | --- | --- | --- |",
    ]
    for effect in CATALOGUE:
        named = [f"`{q.name}` [{q.unit or '–'}]" for q in effect.parameters]
        named += [f"`{q.name}` [{q.unit or '–'}] of each run" for q in effect.run_parameters]
        cells = (f"`{effect.name}`", effect.law, ", ".join(named), effect.seen, effect.advice)
        rows.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(rows) + "\n"


def expressible() -> str:
    """What python-control can express."""
    rows = ["| effect | nonlinear system | state space, transfer function | why not |", "| --- | --- | --- | --- |"]
    for effect in CATALOGUE:
        reasons = [why_not_nonlinear(effect), why_not_linear(effect)]
        marks = ["no" if reason else "yes" for reason in reasons]
        why = "; ".join(dict.fromkeys(reason for reason in reasons if reason)) or "–"
        rows.append(f"| `{effect.name}` | {marks[0]} | {marks[1]} | {why} |")
    return "\n".join(rows) + "\n"


def explained(model: type) -> dict[str, str]:
    """What the docstring of a model says of each of its fields."""
    part = inspect.cleandoc(model.__doc__ or "").split("Parameters\n----------\n")[1]
    found = re.findall(r"^(\w+) : [^\n]*\n((?:    [^\n]*\n?)+)", part, re.MULTILINE)
    return {name: " ".join(words.split()) for name, words in found}


def numbers() -> str:
    """What decides an answer, and what only saves time, as two sections."""
    rows = ["### Criteria", "", "| `stepid.Criteria` | default | what it is, and why |", "| --- | --- | --- |"]
    said = explained(stepid.Criteria)
    rows += [f"| `{name}` | {value:g} | {said[name]} |" for name, value in stepid.Criteria()]
    rows += ["", "### Effort", ""]
    rows += ["| `stepid.Effort` | quick | default | thorough | what it is |", "| --- | --- | --- | --- | --- |"]
    made, said = (stepid.Effort.quick(), stepid.Effort(), stepid.Effort.thorough()), explained(stepid.Effort)
    for name in stepid.Effort.model_fields:
        values = " | ".join(f"{getattr(one, name):g}" for one in made)
        rows.append(f"| `{name}` | {values} | {said[name]} |")
    return "\n".join(rows) + "\n"


TABLES: dict[Path, Callable[[], str]] = {
    DOCS / "diagnosis.md": catalogue,
    DOCS / "evidence.md": numbers,
    DOCS / "how-to" / "ecosystem.md": expressible,
}


def page(path: Path) -> str:
    """The page with its table put between the marks."""
    before, rest = path.read_text(encoding="utf-8").split(BEGIN)
    return before + BEGIN + TABLES[path]() + END + rest.split(END)[1]


def main() -> None:
    for path in TABLES:
        path.write_text(page(path), encoding="utf-8")


if __name__ == "__main__":
    main()
