"""The report as a page: the whole story in order, nothing from outside, no name can break it, all or nothing."""

from __future__ import annotations

import json
import re
import sys
from html import unescape
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest

import diagnosis_example as example
import report_example
import stepid
from diagnosis_example import changed
from page_text import Tags, packed
from stepid.core.estimate import Estimate
from stepid.core.latex import parameter_name
from stepid.core.words import length
from stepid.diagnosis.headline import found_sizes
from stepid.diagnosis.result import Diagnosis, Gap, RunGap
from stepid.report import captions, provenance
from stepid.report.hand import HandMethod
from stepid.report.page import Still, _tiles
from stepid.report.pictures import pictures
from stepid.report.pull import hand_method_rows
from stepid.report.story import tell
from stepid.report.write import hand_of

TITLES = [
    "What is missing",
    "The gap, before and after",
    "Parameters",
    "Where they part",
    "What to do next",
    "Notes",
    "The runs",
    "The peak method",
    "Verification responses",
    "Provenance",
]
EVIL = '</script><script>alert(1)</script><img src="http://x.test/a" onerror="alert(2)"> %{x} {{ 7*7 }} <b>'


@pytest.fixture(autouse=True)
def _no_windows() -> None:
    mpl.use("Agg")


@pytest.fixture
def page() -> str:
    return report_example.page().read_text(encoding="utf-8")


@pytest.fixture
def no_stills(monkeypatch: pytest.MonkeyPatch) -> None:
    """Still pictures take the time; where a test is not about them, leave them out."""
    monkeypatch.setattr("stepid.plot.book.save_all", lambda drawn, *_, **__: dict.fromkeys(drawn, 1.0))
    monkeypatch.setattr("stepid.report.page.inlined", lambda widths, _: dict.fromkeys(widths, Still("data:,", 96)))


def test_the_story_is_told_in_order(page: str) -> None:
    titles = re.findall(r"<h2[^>]*><span[^>]*>(\d+)</span> ([^<]+)</h2>", page)
    assert titles == [(str(i), title) for i, title in enumerate(TITLES, 1)]


def test_what_the_diagnosis_says_stands_in_the_page(page: str) -> None:
    d, text = example.named(), Tags(page).text
    for sentence in (*d.reasons, "A linear model is not adequate: Coulomb friction, ", " is missing."):
        assert sentence in text
    for rms in (d.gap.before, d.gap.after, d.gap.noise, d.gap.held_out_before, d.gap.held_out_after):
        assert rms is not None
        assert length(rms) in text
    for name in d.parameters:
        assert parameter_name(name) in text
    assert "clean and align the rails" in text


def test_what_the_named_effect_measures_stands_on_a_card_and_in_the_story(page: str) -> None:
    d = example.named()
    level = d.parameters["coulomb_friction.level"]
    number, spread = str(level).removesuffix(" N").split(" ± ")
    assert abs(float(number) - example.LEVEL) < 0.01
    assert f"<div><dt>Coulomb friction, level</dt><dd>{number} N<small>± {spread} N</small></dd></div>" in page
    said = f"A linear model is not adequate: Coulomb friction, {level}, is missing."
    assert Tags(page).text.replace("\u00a0", " ").count(said) == 2  # above all, and in the story
    assert f"Coulomb friction: level {level}." not in Tags(page).text
    assert found_sizes(example.adequate()) == []
    tiny = changed(d, parameters=d.parameters | {"coulomb_friction.level": Estimate(value=3e-11, uncertainty=2e-12)})
    open_ = changed(d, parameters=d.parameters | {"coulomb_friction.level": Estimate(value=3.0, unit="N")})
    assert _tiles(tiny)[0][1:] == ("(3.00 ± 0.20)e-11", "")
    assert _tiles(open_)[0][1:] == ("3 N (undetermined)", "")


def test_nothing_has_no_sign() -> None:
    named = example.named()
    close = {name: Estimate(value=e.value * (1 - 1e-6), unit=e.unit) for name, e in named.parameters.items()}
    d = changed(named, linear_parameters=close)
    rows = hand_method_rows(d, by_hand_of(d).found)[1]
    assert {row[-1] for row in rows} == {"0.0 %"}
    assert rows[0][-2].startswith("−")  # a minus sign, no hyphen
    alt = captions.pull(d).alt
    assert "−0.0" not in alt
    assert "base mass 0.00 %" in alt


def by_hand_of(d: Diagnosis) -> HandMethod:
    hand = hand_of(d)
    assert isinstance(hand, HandMethod)
    return hand


def test_the_stacked_system_and_its_solution_are_shown(page: str) -> None:
    d, text = example.named(), Tags(page).text
    hand = hand_of(d)
    assert isinstance(hand, HandMethod)
    rows = re.findall(r'<tr><th scope="row">([^<]*)</th>(.*?)</tr>', page)
    cells = {unescape(name): re.findall(r"<td[^>]*>([^<]*)</td>", rest) for name, rest in rows}
    for label, row, right in zip(hand.system.row_labels, hand.system.matrix, hand.system.rhs, strict=True):
        shown = [float(cell.replace("−", "-")) for cell in cells[label][:-1]]
        assert cells[label][-1] == ("kg" if right else "N/m")
        assert shown == pytest.approx([*row, right], rel=1e-4)
    units = [cell.split()[1] for cell in cells["solution"][:-2]]
    assert units == ["kg"] * len(hand.found.masses) + ["N/m"] * len(hand.found.stiffness)
    solution = [float(cell.split()[0]) for cell in cells["solution"][:-2]]
    assert solution == pytest.approx([*hand.found.masses.values(), *hand.found.stiffness.values()], rel=1e-4)
    residual = hand.system.matrix @ np.array(solution) - hand.system.rhs
    assert np.abs(residual).max() < 20  # N/m: the columns are those of the labels
    for label in (*hand.system.column_labels, *(f"fit {run.fit_percent:.1f} %" for run in hand.verified.runs)):
        assert label in text


def test_nothing_comes_from_outside(page: str) -> None:
    tags = Tags(page).tags
    assert not [tag for tag, _ in tags if tag in {"iframe", "object", "embed", "base"}]
    linked = [a[key] or "" for _, a in tags for key in ("src", "href", "srcset", "action") if key in a]
    assert linked
    assert all(link.startswith(("data:", "#")) for link in linked)
    (policy,) = [a["content"] for tag, a in tags if tag == "meta" and a.get("http-equiv")]
    assert policy is not None
    assert policy.startswith("default-src 'none'")
    assert "@import" not in page
    assert not re.search(r"url\(\s*['\"]?http", page)


def test_pictures_hold_what_was_measured(page: str) -> None:
    d, drawn = example.named(), json.loads(packed(page, "pictures"))
    wanted = {"records", "residuals", "phases", "velocity", "position", "gap", "ring-down", "candidates", "pull"}
    wanted |= {f"{name}-{i}" for name in ("run", "verification") for i in range(len(d.runs))}
    assert set(drawn) == wanted
    assert set(re.findall(r'data-picture="([^"]+)"', page)) == wanted
    for i, run in enumerate(d.runs):
        measured, linear, model = drawn[f"run-{i}"]["data"][:3]
        assert measured["x"] == pytest.approx(run.time, rel=1e-4)
        assert measured["y"] == pytest.approx(1e3 * run.measured, rel=1e-4, abs=1e-9)
        assert linear["y"] == pytest.approx(1e3 * run.linear, rel=1e-4, abs=1e-9)
        assert model["y"] == pytest.approx(1e3 * run.model, rel=1e-4, abs=1e-9)
        assert drawn["records"]["data"][i]["name"] == run.name
    assert "plotly.js" in packed(page, "plotly")[:200]


def test_the_noise_is_named_where_it_lies() -> None:
    named = example.named()
    louder = changed(named, gap=Gap(**named.gap.model_dump() | {"noise": 3 * named.gap.noise}))
    for d in (named, louder, named):  # one report leaves nothing behind for the next
        drawn = pictures(d, ())
        (across,), (upright,) = (drawn[name]["layout"]["annotations"] for name in ("phases", "candidates"))
        assert across["text"] == upright["text"] == "noise"
        assert across["y"] == pytest.approx(1e6 * d.gap.noise)
        assert 10 ** upright["x"] == pytest.approx(1e6 * d.gap.noise)  # places on a logarithmic axis are exponents
        low, high = drawn["candidates"]["layout"]["xaxis"]["range"]
        assert low < upright["x"] < high
    silent = pictures(changed(named, gap=Gap(before=1e-4, after=1e-5, noise=0.0)), ())
    assert "annotations" not in silent["candidates"]["layout"]


def test_candidates_tell_what_they_explain_and_how_probable_they_are(page: str) -> None:
    drawn = json.loads(packed(page, "pictures"))["candidates"]["data"]
    told = {name: words for bars in drawn for name, words in zip(bars["y"], bars["customdata"], strict=True)}
    assert told["quadratic damping and<br>input delay,<br>start times differ"] == (
        "explains 84 % of the misfit<br>probability &lt;1 %"
    )
    assert all("customdata" in bars["hovertemplate"] for bars in drawn)
    text = Tags(page).text
    assert "The probability that this answer is right is 98 %." in text
    assert "candidate explained RMS [µm] probability" in text
    assert "evidence lost" not in text


def test_every_picture_says_what_it_shows(page: str) -> None:
    tags = Tags(page).tags
    plots = [a for tag, a in tags if tag == "div" and a.get("class") == "plot"]
    assert len(plots) == 9 + 2 * len(example.RUNS)
    assert all(a["tabindex"] == "0" and len(a["aria-label"] or "") > 30 for a in plots)
    stills = [a for tag, a in tags if tag == "img"]
    assert len(stills) == 7
    assert all((a["src"] or "").startswith("data:image/webp;base64,") and len(a["alt"] or "") > 30 for a in stills)


def called(name: str) -> Diagnosis:
    """The example with a name put before all of its names."""
    d = example.named()
    assert d.data is not None
    runs = tuple(type(r)(**r.model_dump() | {"name": f"{name} {r.name}"}) for r in d.data.experiments)
    return changed(
        d,
        campaign=name,
        runs=tuple(RunGap(**r.model_dump() | {"name": f"{name} {r.name}"}) for r in d.runs),
        data=stepid.Campaign(name=name, experiments=runs),
        notes=(name,),
    )


@pytest.mark.usefixtures("no_stills")
def test_no_name_can_break_the_page(tmp_path: Path) -> None:
    page = called(EVIL).to_html(tmp_path / "evil.html").read_text(encoding="utf-8")
    harmless = Tags(called("good").to_html(tmp_path / "good.html").read_text(encoding="utf-8"))
    told = Tags(page)
    assert [tag for tag, _ in told.tags] == [tag for tag, _ in harmless.tags]
    assert [sorted(a) for _, a in told.tags] == [sorted(a) for _, a in harmless.tags]
    assert told.text.count(EVIL) == harmless.text.count("good") > 20
    for figure in json.loads(packed(page, "pictures")).values():  # plotly reads tags in names, and %{…} in templates
        for trace in figure["data"]:
            assert "<" not in trace.get("name", "")
            assert "%{x} {{" not in trace.get("hovertemplate", "")


@pytest.mark.usefixtures("no_stills")
@pytest.mark.parametrize("kind", ["adequate", "ambiguous", "unexplained"])
def test_other_verdicts(kind: str, tmp_path: Path) -> None:
    if kind == "unexplained":
        d = changed(example.adequate(), verdict="unexplained", next_experiment="Repeat one run.")
    else:
        d = getattr(example, kind)()
    text = Tags(d.to_html(tmp_path / "page.html").read_text(encoding="utf-8")).text
    said = {
        "adequate": "Less noise or larger steps would show smaller effects.",
        "ambiguous": "record with more mass",
        "unexplained": "Repeat one run.",
    }
    assert said[kind] in text
    assert "Gap, linear model" in text


@pytest.mark.usefixtures("no_stills")
def test_without_its_campaign_the_page_says_so(tmp_path: Path) -> None:
    d = changed(example.named(), data=None)
    text = Tags(d.to_html(tmp_path / "page.html").read_text(encoding="utf-8")).text
    assert "made without its campaign at hand" in text
    assert "Stacked system" not in text
    again = Diagnosis.model_validate_json(example.named().model_dump_json())
    assert hand_of(again) == hand_of(example.named())  # what went to JSON and back still knows its campaign


def test_a_hand_method_that_refuses_says_why() -> None:
    d = example.named()
    error = stepid.errors.UndeterminedError("too few runs", "Add one.")
    chapters = {chapter.name: chapter for chapter in tell(d, error, provenance.of_data(d))}
    assert chapters["by-hand"].lead == "The peak method cannot use this campaign: too few runs. Add one."
    assert not chapters["by-hand"].tables
    assert not chapters["verification"].pictures


def test_a_page_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "report.html"
    target.write_text("before", encoding="utf-8")

    def fail(*_: Any, **__: Any) -> None:
        raise stepid.errors.InputError("the picture cannot be drawn", "Try again.")

    monkeypatch.setattr("stepid.plot.book.save_all", fail)
    with pytest.raises(stepid.errors.InputError, match="cannot be drawn"):
        example.named().to_html(target)
    assert target.read_text(encoding="utf-8") == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in [name for name in sys.modules if name.startswith(("stepid.report.p", "plotly"))]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "plotly", None)
    monkeypatch.setattr("stepid.plot.book.save_all", lambda drawn, *_, **__: dict.fromkeys(drawn, 1.0))
    with pytest.raises(stepid.errors.StepidError, match=re.escape("pip install 'stepid[report]'")):
        example.named().to_html(tmp_path / "report.html")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_nine_runs_stay_below_three_megabytes() -> None:
    assert report_example.page_of_nine().stat().st_size <= 3_000_000
