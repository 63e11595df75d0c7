"""A report begins with its answer: reasons, equation of motion and numbers; what it rests on is folded."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path

import matplotlib as mpl
import pytest

import diagnosis_example as example
import report_example
from diagnosis_example import changed
from page_text import Tags
from stepid.report import provenance
from stepid.report.equation import equation, numbers
from stepid.report.page import Still
from stepid.report.story import tell


def test_the_answer_stands_first_with_its_equation_and_reasons() -> None:
    mpl.use("Agg")
    page = report_example.page().read_text(encoding="utf-8")
    d = example.named()
    head = page.split('<dl class="tiles">')[0]
    assert "(m₀ + added mass) a = K<sub>f</sub> u − c v − k x − F<sub>c</sub> sign(v)" in head
    told = Tags(head).text
    assert all(reason in told for reason in d.reasons)
    values = [unescape(v).replace("\u00a0", " ") for v in re.findall(r"<dt>[^\n]*</dt><dd>([^<]*)</dd>", head)]
    assert values == [value for _, value in numbers(d)] == [str(found) for found in d.parameters.values()]
    assert "coulomb_friction.level" not in Tags(page).text
    folded = re.findall(r'<section id="([\w-]+)"[^>]*>\s*<details>', page)
    assert folded == ["runs", "by-hand", "verification", "provenance"]


def test_what_would_close_an_open_choice_stands_beside_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mpl.use("Agg")
    closed = report_example.page().read_text(encoding="utf-8")  # it is kept for other tests: with its pictures
    monkeypatch.setattr("stepid.plot.book.save_all", lambda drawn, *_, **__: dict.fromkeys(drawn, 1.0))
    monkeypatch.setattr("stepid.report.page.inlined", lambda widths, _: dict.fromkeys(widths, Still("data:,", 96)))
    d = example.ambiguous()
    page = d.to_html(tmp_path / "report.html").read_text(encoding="utf-8")
    head = page.split('<dl class="tiles">')[0].replace("\u00a0", " ")
    level = d.parameters["coulomb_friction.level"]
    assert re.search(rf'<p class="verdict ambiguous">Most likely Coulomb friction, {re.escape(str(level))}; ', head)
    assert '</p>\n<p class="advice">Record with more mass.</p>' in head
    assert "<dt>Coulomb friction, level</dt>" in page
    assert 'class="advice"' not in closed


def test_laws_that_are_no_force_stand_beside_the_equation() -> None:
    d = example.named()
    first, other = equation(changed(d, effects=("coulomb_friction", "actuator_lag")))
    assert first.endswith("− F_c sign(v)")
    assert other == "with actuator lag: K_f w, τ w′ = u − w"
    own = equation(changed(d, effects=("of_my_own",)))
    assert own[1:] == ("with of my own",)


def test_next_steps_are_called_measurements_only_where_they_are() -> None:
    d = example.named()
    titles = {
        bool(a): tell(changed(d, advice=a, next_experiment="record more"), None, provenance.of_data(d))[4].title
        for a in ({}, {"coulomb_friction": "oil it"})
    }
    assert titles == {False: "What to measure next", True: "What to do next"}
