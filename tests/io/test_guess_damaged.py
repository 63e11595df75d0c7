"""Damaged recordings are refused by line when they are drafted: no sample is dropped unsaid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lab_folders import write_workbook
from stepid.errors import InputError
from stepid.io.guess.understand import draft_runs

HEAD = "time [s],position [m],voltage [V]"
ROWS = [f"{0.005 * n:.3f},{0.01 * np.sin(0.1 * n):.6f},{1.0 if n > 20 else 0.0:.2f}" for n in range(400)]


def drafted(folder: Path, lines: list[str]):
    file = folder / "run.csv"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    (draft,) = draft_runs([file])
    return draft


@pytest.mark.parametrize(
    ("row", "damage", "line"),
    [
        (50, ["0.250,NaN,1.00"], 52),
        (50, ["0.250,x.5,1.00"], 52),
        (50, ["NaN,0.001,1.00"], 52),
        (0, ["0.000,NaN,0.00"], 2),
        (0, ["NaN,0.0,0.00"], 2),
        (150, ["0.750,0.005"], 152),
        (250, ["1.250,0.005"], 252),
        (50, ["#N/A,0.001,1.00"], 52),
        (50, ["########,0.001,1.00"], 52),
        (0, ["#VALUE!,0.001,0.00"], 2),
        (399, ["#DIV/0!,0.001,1.00"], 401),
        (50, [HEAD, ROWS[50]], 52),
        (250, [HEAD, ROWS[250]], 252),
        (50, ["END", ROWS[50]], 52),
        (399, ["1.995,0.0"], 401),
        (399, ["1.995"], 401),
        (399, ["1.995,NaN,1.00"], 401),
    ],
)
def test_a_damaged_row_is_named_wherever_it_stands(row: int, damage: list[str], line: int, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=rf"run\.csv, line {line}: is no row like the others") as refused:
        drafted(tmp_path, [HEAD, *ROWS[:row], *damage, *ROWS[row + 1 :]])
    assert "Restore the line" in refused.value.remedy


@pytest.mark.parametrize(
    ("above", "below", "layout"),
    [
        (
            ["Lab 3", "400", "# 1,2,3"],
            ["Mean,3.2,0.5", "measured by hand", "END"],
            {"delimiter": ",", "skiprows": 3, "stop": 400},
        ),
        (["Samples,400,400"], [], {"skiprows": 1}),
    ],
)
def test_lines_that_are_no_readings_are_still_left_out(
    above: list[str], below: list[str], layout: dict[str, object], tmp_path: Path
) -> None:
    draft = drafted(tmp_path, [*above, HEAD, *ROWS, *below])
    assert draft.layout == layout
    assert draft.readings["position"].size == 400
    assert dict(draft.columns) == {"time": "time [s]", "position": "position [m]", "input": "voltage [V]"}


def test_a_sheet_is_named_by_its_row(tmp_path: Path) -> None:
    t = np.arange(40) * 0.01
    x = [*np.sin(t)]
    x[10] = "lost"
    write_workbook(tmp_path / "book.xlsx", [], ["t [s]", "x [mm]"], None, [t, x])
    with pytest.raises(InputError, match=r"book\.xlsx, line 12: is no row"):
        draft_runs([tmp_path / "book.xlsx"])
    write_workbook(tmp_path / "error.xlsx", [], ["t [s]", "x [mm]"], None, [[*t[:9], "#SPILL!", *t[10:]], np.sin(t)])
    with pytest.raises(InputError, match=r"error\.xlsx, line 11: is no row"):
        draft_runs([tmp_path / "error.xlsx"])
