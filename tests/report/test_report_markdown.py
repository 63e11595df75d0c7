"""The report as Markdown: the same story, tables that hold together, pictures beside it."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import unquote

import matplotlib as mpl
import pytest

import diagnosis_example as example
import stepid
from diagnosis_example import changed
from stepid.report.markdown import markdown
from stepid.report.provenance import of_data
from stepid.report.write import hand_of


@pytest.fixture(autouse=True)
def _no_windows() -> None:
    mpl.use("Agg")


def tables(text: str) -> list[list[str]]:
    return [block.splitlines() for block in text.split("\n\n") if block.startswith("| ")]


def cells(line: str) -> list[str]:
    return re.split(r"(?<!\\)\|", line)[1:-1]


@pytest.mark.slow
def test_the_same_story_with_pictures_beside_it(tmp_path: Path) -> None:
    d = example.named()
    target = d.to_markdown(tmp_path / "note of today.md")
    text = target.read_text(encoding="utf-8")
    assert text.startswith(
        "# cases 4 to 7: diagnosis\n\n**A linear model is not adequate: Coulomb friction, "
        f"{d.parameters['coulomb_friction.level']}, is missing.**"
    )
    assert [int(n) for n in re.findall(r"^## (\d+)\. ", text, re.MULTILINE)] == list(range(1, 11))
    linked = [unquote(name) for name in re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text)]
    names = ("candidates", "gap", "ring-down", "runs", "where", "records", "verification")
    assert linked == [f"note of today-{name}.png" for name in names]
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([target.name, *linked])
    assert all((tmp_path / name).read_bytes().startswith(b"\x89PNG") for name in linked)


def test_what_would_close_an_open_choice_stands_below_it() -> None:
    d = example.ambiguous()
    head = markdown(d, None, of_data(d), {}).split("\n\n")[1:3]
    level = d.parameters["coulomb_friction.level"]
    assert head[0].startswith(f"**Most likely Coulomb friction, {level}; these data do not tell it from load")
    assert head[1] == "Record with more mass."


def test_every_table_is_whole() -> None:
    d = example.named()
    found = tables(markdown(d, hand_of(d), of_data(d), {}))
    assert len(found) >= 12
    for header, rule, *rows in found:
        columns = len(cells(header))
        assert rows
        assert all(re.fullmatch(r" (:--|--:) ", cell) for cell in cells(rule))
        assert [len(cells(line)) for line in (rule, *rows)] == [columns] * (1 + len(rows))


def test_no_name_can_break_the_text() -> None:
    evil = "a | b\n# c *d* [e](http://x.test) <img src=x> `f` $g$"
    d = example.named()
    text = markdown(changed(d, campaign=evil, notes=(evil,)), None, of_data(d), {})
    plain = r"a \| b \# c \*d\* \[e\](http://x.test) \<img src=x\> \`f\` \$g\$"
    assert text.startswith(f"# {plain}: diagnosis\n")
    assert f"- {plain}" in text
    assert "<img" not in text.replace(r"\<img", "")


def test_it_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise stepid.errors.InputError("the picture cannot be drawn", "Try again.")

    monkeypatch.setattr("stepid.plot.gap_bars", fail)
    with pytest.raises(stepid.errors.InputError, match="cannot be drawn"):
        example.named().to_markdown(tmp_path / "note.md")
    assert list(tmp_path.iterdir()) == []
    monkeypatch.undo()
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    with pytest.raises(stepid.errors.InputError, match="is a file, not a folder"):
        example.named().to_markdown(blocked / "note.md")
