"""Write the catalogue's table into docs/diagnosis.md. Run with ``python docs/make_catalogue.py``."""

from __future__ import annotations

from pathlib import Path

from stepid.effects import CATALOGUE

PAGE = Path(__file__).parent / "diagnosis.md"
BEGIN, END = "<!-- catalogue: made by docs/make_catalogue.py -->\n", "<!-- end of catalogue -->\n"


def table() -> str:
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


def page(text: str) -> str:
    """The page with the table put between its marks."""
    before, rest = text.split(BEGIN)
    return before + BEGIN + table() + END + rest.split(END)[1]


def main() -> None:
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
