"""The lab report: filled from a diagnosis, whole, with the numbers of the summary; templates of one's own."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import matplotlib as mpl
import pytest

import diagnosis_example as example
import stepid
from diagnosis_example import changed
from stepid.report.hand import Hand, by_hand
from stepid.report.lab_report import lab_report
from stepid.report.provenance import of_data

mpl.use("Agg")
FILES = {name: f"lab-{name}.png" for name in ("records", "where", "gap", "runs", "verification", "candidates")}
EVIL = r"a & b_{1} \input{x} 5 % # $y$ [z] <i>"


@cache
def hand() -> Hand:
    return by_hand(example.campaign())


def filled(d: stepid.Diagnosis, kind: str, **more: str) -> str:
    return lab_report(d, None if d.data is None else hand(), of_data(d), kind=kind, files=FILES, **more)


@pytest.mark.parametrize("kind", [".md", ".tex"])
def test_every_part_is_filled(kind: str) -> None:
    d = example.named()
    text = filled(d, kind)
    for part in (
        "Aim",
        "Model",
        "Measurements",
        "Evaluation by the peak method",
        "Parameters",
        "Discussion",
        "Data and software",
    ):
        assert f"{'## ' if kind == '.md' else chr(92) + 'section{'}{part}" in text
    assert text.count("lab-records.png") == 1
    assert r"-F_c\,\mathrm{sign}(v)" in text
    assert "A linear model is not adequate: Coulomb friction, 0.3" in text
    level = d.parameters["coulomb_friction.level"]
    shown = str(level).removesuffix(" N")
    assert shown in text.replace(r"$\pm$", "±")
    assert "(((" not in text
    assert "{{" not in text
    assert "{%" not in text.replace(r"\resizebox{\linewidth}{!}{%", "")
    assert "\n\n\n\n" not in text


@pytest.mark.parametrize("kind", [".md", ".tex"])
def test_the_discussion_says_what_would_close_an_open_choice(kind: str) -> None:
    text = filled(example.ambiguous(), kind)
    discussion = text[text.index("Discussion") :]
    assert re.search(r"not tell it from load proportional friction\.\s+Record with more mass\.\s", discussion)
    assert "\n\n\n\n" not in text


def test_latex_is_balanced_and_nothing_breaks_it() -> None:
    d = changed(example.named(), campaign=EVIL, notes=(EVIL,), reasons=("[z] first", EVIL))
    text = filled(d, ".tex")
    assert r"a \& b\_\{1\} \textbackslash{}input\{x\} 5 \% \# \$y\$ {[}z{]} \textless{}i\textgreater{}" in text
    plain = re.sub(r"\\[{}]", "", text)
    assert plain.count("{") == plain.count("}")
    begun, ended = (re.findall(rf"\\{word}\{{(\w+)\}}", text) for word in ("begin", "end"))
    assert sorted(begun) == sorted(ended)
    assert re.sub(r"\\\$", "", text).count("$") % 2 == 0
    for table in re.findall(r"\\begin\{tabular\}\{(\w+)\}(.*?)\\end\{tabular\}", text, re.S):
        columns, body = table
        for row in body.split(r"\\")[:-1]:
            assert len(re.findall(r"(?<!\\)&", row)) == len(columns) - 1


def test_a_diagnosis_without_its_campaign_or_effects_makes_a_report() -> None:
    for d in (example.adequate(), example.ambiguous()):
        for kind in (".md", ".tex"):
            assert "Discussion" in filled(d, kind)


def test_ones_own_template() -> None:
    d = changed(example.named(), data=None, ranking=())
    assert filled(d, ".md", template="{{ d.verdict }}: {{ effects }}") == "named: Coulomb friction"
    assert filled(d, ".tex", template="((( d.verdict )))") == "named"
    for wrong in ("{{ nothing }}", "{% if %}", "{{ d.verdict() }}", "{{ ().__class__.__mro__ }}"):
        with pytest.raises(stepid.errors.InputError, match="the template of the lab report"):
            filled(d, ".md", template=wrong)


def test_other_endings_are_refused(tmp_path: Path) -> None:
    with pytest.raises(stepid.errors.InputError, match=r"ends in \.md or \.tex"):
        example.named().to_lab_report(tmp_path / "report.docx")
    assert not list(tmp_path.iterdir())


def test_links_hold_whatever_the_report_is_called(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def save_all(drawn: dict[str, object], folder: Path, **_: object) -> None:
        for name in drawn:
            (folder / f"{name}.png").touch()

    monkeypatch.setattr("stepid.report.still.stills", lambda *_: dict.fromkeys(FILES))
    monkeypatch.setattr("stepid.plot.book.save_all", save_all)
    d = example.named()
    text = d.to_lab_report(tmp_path / "lab report (1).md").read_text(encoding="utf-8")
    assert "](lab%20report%20%281%29-records.png)" in text
    assert (tmp_path / "lab report (1)-records.png").exists()
    text = d.to_lab_report(tmp_path / "50 % of #2.tex").read_text(encoding="utf-8")
    linked = re.findall(r"includegraphics\[.*?\]\{(.*?)\}", text)
    assert "50-of-2-records.png" in linked
    assert all((tmp_path / name).exists() for name in linked)


def test_what_its_authors_wrote_is_kept(tmp_path: Path) -> None:
    mine = tmp_path / "lab.md"
    mine.write_text("our answers", encoding="utf-8")
    with pytest.raises(stepid.errors.InputError, match=r"lab\.md: exists already\. .* overwrite=True"):
        example.named().to_lab_report(mine)
    with pytest.raises(stepid.errors.InputError, match="overwrite is 'yes'"):
        example.named().to_lab_report(mine, overwrite="yes")  # type: ignore[arg-type]
    assert [p.name for p in tmp_path.iterdir()] == ["lab.md"]
    assert mine.read_text(encoding="utf-8") == "our answers"


def test_it_is_overwritten_on_request(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stepid.report.still.stills", lambda *_: {})
    mine = tmp_path / "lab.md"
    mine.write_text("our answers", encoding="utf-8")
    assert example.named().to_lab_report(mine, overwrite=True).read_text(encoding="utf-8").startswith("# ")


@pytest.mark.slow
def test_it_is_written_with_its_pictures(tmp_path: Path) -> None:
    own = tmp_path / "own.j2"
    own.write_text("((( answer )))", encoding="utf-8")
    d = example.named()
    for template in (None, own):
        path = d.to_lab_report(tmp_path / "out" / "lab.tex", template=template, overwrite=template is not None)
        linked = set(re.findall(r"includegraphics\[.*?\]\{(.*?)\}", path.read_text(encoding="utf-8")))
        assert linked <= {p.name for p in path.parent.iterdir()}
        assert len(linked) >= (4 if template is None else 0)
