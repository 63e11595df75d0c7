"""A parameter is the same number wherever it stands: report, page, summary, LaTeX, Markdown, CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
import re
import zipfile
from decimal import Decimal
from functools import cache
from html import unescape
from pathlib import Path

import pytest

import diagnosis_example as example
from stepid.core.latex import parameter_name
from stepid.report.chapter import Chapter
from stepid.report.hand import by_hand
from stepid.report.provenance import of_diagnosis
from stepid.report.story import tell
from stepid.webapp import downloads
from stepid.webapp.views.chapter import chapter

UNITS = {
    r"\kilogram": "kg",
    r"\newton\per\meter": "N/m",
    r"\newton\second\per\meter": "N·s/m",
    r"\newton\per\volt": "N/V",
    r"\newton": "N",
}
D = example.named()
PLACES = {run.name: place for place, run in enumerate(D.runs)}


def words(page: str) -> str:
    """What a page says, without its marks."""
    return unescape(re.sub(r"<(script|style)\b.*?</\1>|<[^>]+>", " ", page, flags=re.DOTALL))


@cache
def told() -> tuple[Chapter, ...]:
    return tell(D, by_hand(example.campaign()), of_diagnosis(D))


def of_page(_: Path) -> str:
    """The sentences and tables of the page in the browser."""
    panes = [pane for one in told() for pane in chapter(one, {}, PLACES).select()]
    return words(" ".join(str(pane.object) for pane in panes if hasattr(pane, "object")))


def of_csv(_: Path) -> str:
    tables = tuple(table for one in told() for table in one.tables)
    with zipfile.ZipFile(io.BytesIO(downloads.tables_zip(tables))) as files:
        texts = [files.read(name).decode("utf-8-sig") for name in files.namelist()]
    return " ".join(" ".join(row) for text in texts for row in csv.reader(io.StringIO(text)))


SHOWN = {
    "report": lambda _: words(downloads.report_html(D).decode("utf-8")),
    "page": of_page,
    "csv": of_csv,
    "summary": lambda _: D.summary(),
    "notebook": lambda _: words(D._repr_html_()),
    "markdown": lambda folder: D.to_markdown(folder / "found.md").read_text(encoding="utf-8").replace("|", " "),
}


def in_latex() -> dict[str, tuple[str, str, str]]:
    """Parameter to value, uncertainty and unit, as they stand in the LaTeX table."""
    rows = re.findall(r"^(.+?) & \\num\{(\S+) \+- (\S+)\} & \\unit\{(\S+)\}", D.to_latex(), re.MULTILINE)
    return {name: (value, reach, UNITS[unit]) for name, value, reach, unit in rows}


def test_latex_rounds_what_json_holds() -> None:
    held = json.loads(D.model_dump_json())["parameters"]
    told_there = in_latex()
    assert {parameter_name(name) for name in held} == set(told_there)
    for name, estimate in held.items():
        value, reach, unit = told_there[parameter_name(name)]
        step = Decimal(reach).as_tuple().exponent
        assert Decimal(value).as_tuple().exponent == step  # as many decimals
        for shown, exact in ((value, estimate["value"]), (reach, estimate["uncertainty"])):
            assert abs(Decimal(shown) - Decimal(exact)) <= Decimal((0, (5,), int(step) - 1))
        assert estimate["unit"] == unit


# those that draw every picture take seconds
@pytest.mark.parametrize(
    "where", [pytest.param(name, marks=[pytest.mark.slow] * (name in ("report", "markdown"))) for name in SHOWN]
)
def test_what_is_shown_is_what_stands_in_latex(where: str, tmp_path: Path) -> None:
    text = re.sub(r"\s+", " ", SHOWN[where](tmp_path))
    for name, (value, reach, unit) in in_latex().items():
        assert re.search(rf"(?<![\d.]){re.escape(f'{value} ± {reach}')} {re.escape(unit)}(?![\w/·])", text), name
