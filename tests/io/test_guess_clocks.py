"""Columns called positions that are clocks, and headers that do not say which column is which."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.errors import InputError
from stepid.io.guess.content import kind, rises_evenly
from stepid.io.guess.understand import draft_runs

T = np.arange(600) / 30  # s
X = 17.4 * np.exp(-0.1 * T) * np.cos(3.0 * T)  # deg
SMALL = np.full(T.size, 0.05)
RELEASED = {"step": 0.0, "added_mass": 0.0}
EVEN = "rises evenly from row to row, as a time does, and no other is the time"


def write(file: Path, head: str, mark: str, *columns: Array, digits: str = ".6g") -> Path:
    rows = [mark.join(format(value, digits) for value in row) + "\n" for row in zip(*columns, strict=True)]
    file.write_text(f"{head}\n" * bool(head) + "".join(rows), encoding="utf-8")
    return file


@pytest.mark.parametrize("digits", [".6g", ".2E"])  # of three digits, stamps repeat from ten seconds on
@pytest.mark.parametrize("tabs", [0, 1, 3])
def test_names_apart_by_blanks_above_rows_of_tabs_are_those_of_the_columns(
    digits: str, tabs: int, tmp_path: Path
) -> None:
    file = write(tmp_path / "run.txt", "x y dx dy" + tabs * "\t", "\t", T, X, SMALL, SMALL, digits=digits)
    (draft,) = draft_runs([file])
    assert dict(draft.columns) == {"time": 0, "position": 1}
    assert draft.titles["position"] == "y"
    said = {"time_unit": "s", "sample_time": 1 / 30, "position_unit": "deg"}
    run = stepid.draft_campaign(file, **said, **RELEASED).campaign()[0]
    np.testing.assert_allclose(run.position, np.deg2rad(X), atol=1e-3)
    np.testing.assert_allclose(run.time, T, atol=1e-2 if digits == ".6g" else 1e-9)


@pytest.mark.parametrize("head", ["x", "x (mm),y (mm)", "Angle (deg),foo", "x1 (mm),x2 (mm)"])
@pytest.mark.parametrize("digits", [".6g", ".2E"])
def test_a_column_that_rises_evenly_is_no_position_without_a_question(head: str, digits: str, tmp_path: Path) -> None:
    file = write(tmp_path / "run.csv", head, ",", T, X, digits=digits)
    (draft,) = draft_runs([file])
    name = head.split(",", maxsplit=1)[0]
    assert (dict(draft.columns), draft.doubts) == ({}, (f"column {name!r} {EVEN}",))
    assert (
        stepid.draft_campaign(file, sample_time=0.1, position_unit="mm", **RELEASED)
        .questions[0]
        .startswith(f"Which column is the position ({name}, ")
    )
    (said,) = draft_runs([file], {"position": name})
    assert (said.titles["position"], said.doubts) == (name, ())
    (timed,) = draft_runs([file], {"time": name, "position": "1"})
    assert not timed.doubts


def test_beside_a_clock_a_position_may_rise_evenly(tmp_path: Path) -> None:
    (draft,) = draft_runs([write(tmp_path / "run.csv", "t,x (mm)", ",", T, 3 * T)])
    assert dict(draft.columns) == {"time": "t", "position": "x (mm)"}
    rows = [f"12:03:{s:06.3f};{3 * s:.4f}\n" for s in T[:300] + 1]
    (tmp_path / "clock.csv").write_text("clock;x (mm)\n" + "".join(rows), encoding="utf-8")
    (draft,) = draft_runs([tmp_path / "clock.csv"])
    assert draft.titles["position"] == "x (mm)"


ROWS = np.arange(600.0)
CLOCKS = {
    "index": ROWS,
    "exact": 0.7 + 0.033 * ROWS,
    "three digits": np.array([float(f"{t:.3g}") for t in T]),
    "rounded": T.round(1),
    "cut off": np.floor(10 * T) / 10,
    "dropped": np.delete(T, [17, 18, 90]),
    "missing": np.where(ROWS == 40, np.nan, T),
}
OTHERS = {
    "swing": X,
    "creep": 1 - np.exp(-0.2 * T),
    "parabola": T**2,
    "stairs": np.floor(ROWS / 60),
    "falling": -T,
    "noisy": T + 0.1 * np.cos(7 * ROWS),
    "few": ROWS[:7],
}


@pytest.mark.parametrize("name", CLOCKS)
def test_clocks_rise_evenly_to_their_last_digit(name: str) -> None:
    assert rises_evenly(CLOCKS[name])
    assert kind(CLOCKS[name], 3) == "time"


@pytest.mark.parametrize("name", OTHERS)
def test_other_columns_do_not(name: str) -> None:
    assert not rises_evenly(OTHERS[name])


UNCLEAR: list[tuple[str, str, Sequence[Array], str]] = [
    ("x y dx dy", "\t", (T, X), "4 columns (x, y, dx, dy) above rows of 2"),
    ("x y dx dy", " ", (T, X), "4 columns (x, y, dx, dy) above rows of 2"),
    ("t,x,y", ",", (T, X), "3 columns (t, x, y) above rows of 2"),
    ("t\tx", "\t", (ROWS, T, X), "2 columns (t, x) above rows of 3"),  # row names have none in R's tables
]


@pytest.mark.parametrize(("head", "mark", "columns", "words"), UNCLEAR)
def test_a_header_of_more_or_fewer_names_than_columns_is_asked_about(
    head: str, mark: str, columns: Sequence[Array], words: str, tmp_path: Path
) -> None:
    file = write(tmp_path / "run.txt", head, mark, *columns)
    draft = stepid.draft_campaign(file, position_unit="deg", **RELEASED)
    assert draft.runs[0].doubts == (f"the header names {words}: say by number from 0 which is which",)
    assert [question.split(" (")[0] for question in draft.questions] == ["Which column is the position"]
    last = len(columns) - 1
    run = stepid.draft_campaign(file, time=last - 1, position=last, position_unit="deg", **RELEASED).campaign()[0]
    np.testing.assert_allclose(run.position, np.deg2rad(X), atol=1e-5)
    np.testing.assert_allclose(run.time, T, atol=1e-4)
    with pytest.raises(InputError, match=f"hold {last + 1} values under a header of . names .*not clear") as refused:
        stepid.read_table(file, time=last - 1, position=last)
    assert "skiprows = 1 and give the columns by index" in refused.value.remedy
    run = stepid.read_table(file, time=last - 1, position=last, skiprows=1)
    np.testing.assert_allclose(run.position, X, atol=1e-4)


@pytest.mark.parametrize(
    ("head", "mark", "columns"),
    [
        ("t,x,", ",", (T, X)),
        ("x mm", ",", (X,)),
        ("Position (cm)", ",", (X,)),
        ("Made on Monday", "\t", (T, X)),
    ],
)
def test_other_lines_above_the_rows_are_no_such_header(
    head: str, mark: str, columns: Sequence[Array], tmp_path: Path
) -> None:
    (draft,) = draft_runs([write(tmp_path / "run.txt", head, mark, *columns)])
    assert not draft.doubts
    assert "position" in draft.columns
