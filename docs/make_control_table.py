"""Write the table of what python-control can express into docs/how-to/ecosystem.md. Run it as a script."""

from __future__ import annotations

from pathlib import Path

from stepid.effects import CATALOGUE
from stepid.transfer.express import why_not_linear, why_not_nonlinear

PAGE = Path(__file__).parent / "how-to" / "ecosystem.md"
BEGIN, END = "<!-- effects: made by docs/make_control_table.py -->\n", "<!-- end of effects -->\n"


def table() -> str:
    rows = ["| effect | nonlinear system | state space, transfer function | why not |", "| --- | --- | --- | --- |"]
    for effect in CATALOGUE:
        reasons = [why_not_nonlinear(effect), why_not_linear(effect)]
        marks = ["no" if reason else "yes" for reason in reasons]
        why = "; ".join(dict.fromkeys(reason for reason in reasons if reason)) or "–"
        rows.append(f"| `{effect.name}` | {marks[0]} | {marks[1]} | {why} |")
    return "\n".join(rows) + "\n"


def page(text: str) -> str:
    """The page with the table put between its marks."""
    before, rest = text.split(BEGIN)
    return before + BEGIN + table() + END + rest.split(END)[1]


def main() -> None:
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
