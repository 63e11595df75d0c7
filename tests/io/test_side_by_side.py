"""Several runs side by side in one table, told apart by the names of their columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stepid
from stepid.errors import InputError

ROWS = 40


def table(folder: Path, header: str, *, lengths: tuple[int, ...] = (), separator: str = ",") -> Path:
    """A table whose column c holds 100·c + row; the columns in `lengths` end early. The first is time."""
    names = header.split(separator)
    ends = lengths or (ROWS,) * len(names)
    lines = [header]
    for row in range(ROWS):
        cells = [f"{0.01 * row:.2f}"]
        cells += [f"{100 * c + row}" if row < ends[c] else "" for c in range(1, len(names))]
        lines.append(separator.join(cells))
    path = folder / "all.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("header", "position", "input", "names"),
    [
        ("t,x1,x2,u1,u2", "x", "u", ["run 1", "run 2"]),
        ("t,x_1,x_2,U_1,U_2", "x", "u", ["run 1", "run 2"]),
        ("t,position run 1,position run 2,volts run 1,volts run 2", "position", "volts", ["run 1", "run 2"]),
        ("t,case 4 position [mm],case 5 position [mm],case 4 input [V],case 5 input [V]", "position", "input", None),
        ("t,Position.left,Position.right,Effort.left,Effort.right", "position", "effort", ["left", "right"]),
        ("t,run1_x_mm,run2_x_mm,run1_u_V,run2_u_V", "x", "u", ["run1", "run2"]),
        (
            "t,Position (m) Run 1,Position (m) Run 2,Drive (V) Run 1,Drive (V) Run 2",
            "position",
            "drive",
            ["Run 1", "Run 2"],
        ),
        ("t,x [mm] 1,x [mm] 2,u [mA] 1,u [mA] 2", "x [mm]", "u", ["run 1", "run 2"]),
        ("t,x (A) [mm],x (N) [mm],u (A) [V],u (N) [V]", "x", "u", ["(A)", "(N)"]),
        ("t,x(A)_mm,x(V)_mm,u(A)_V,u(V)_V", "x", "u", ["(A)", "(V)"]),
    ],
)
def test_names_tell_the_runs_apart(
    header: str, position: str, input: str, names: list[str] | None, tmp_path: Path
) -> None:
    path = table(tmp_path, header)
    runs = stepid.read_tables(path, time="t", position=position, input=input, position_scale=0.001)
    assert [run.name for run in runs] == (names or ["case 4", "case 5"])
    for i, run in enumerate(runs, 1):
        np.testing.assert_allclose(run.position, 1e-3 * (100 * i + np.arange(ROWS)))
        np.testing.assert_allclose(run.input, 100 * (i + 2) + np.arange(ROWS))
        np.testing.assert_allclose(run.time, 0.01 * np.arange(ROWS))


def test_masses_and_labels_go_by_run(tmp_path: Path) -> None:
    path = table(tmp_path, "t,x1,x2,u")
    one, two = stepid.read_tables(
        path,
        time="t",
        position="x",
        input="u",
        position_scale=0.001,
        added_mass={"run 1": 0.0, "run 2": 0.5},
        spring="medium",
        damper={"run 1": "none", "run 2": "1/2 turn"},
    )
    assert (one.added_mass, two.added_mass) == (0.0, 0.5)
    assert (one.damper, two.damper) == ("none", "1/2 turn")
    assert one.spring == two.spring == "medium"
    np.testing.assert_array_equal(one.input, two.input)  # one input for both
    with pytest.raises(InputError, match="added_mass is missing for run 'run 2'"):
        stepid.read_tables(path, time="t", position="x", input="u", position_scale=0.001, added_mass={"run 1": 0.0})
    with pytest.raises(InputError, match="spring names 'run 3', which is no run"):
        stepid.read_tables(path, time="t", position="x", input="u", position_scale=0.001, spring={"run 3": "s"})


def test_a_run_ends_where_its_cells_are_empty(tmp_path: Path) -> None:
    path = table(tmp_path, "t,x1,x2,u1,u2", lengths=(ROWS, 25, ROWS, 25, ROWS))
    one, two = stepid.read_tables(path, time="t", position="x", input="u", position_scale=0.001)
    assert (one.time.size, two.time.size) == (25, ROWS)
    alone = stepid.read_table(path, time="t", position="x1", input="u1", position_scale=0.001, name="run 1")
    assert alone == one


def test_a_lost_reading_is_still_refused(tmp_path: Path) -> None:
    path = table(tmp_path, "t,x1,u1", lengths=(ROWS, 25, ROWS))
    with pytest.raises(InputError, match="line 27"):
        stepid.read_table(path, time="t", position="x1", input="u1", position_scale=0.001)


def test_readings_that_end_early_are_refused_where_no_other_run_goes_on(tmp_path: Path) -> None:
    path = table(tmp_path, "time,position,input,temp,note", lengths=(ROWS, 30, 30, ROWS, ROWS))
    columns = {"time": "time", "position": "position", "input": "input", "position_scale": 0.001}
    with pytest.raises(InputError, match=r"line 32, column 'position': is empty from here on.*give stop = 30"):
        stepid.read_table(path, **columns)
    assert stepid.read_table(path, **columns, stop=30).time.size == 30
    with pytest.raises(InputError, match="line 32"):
        stepid.read_table(path, **columns, stop=35)


@pytest.mark.parametrize("header", ["t,left,right,a,b", "t,run 1,run 2,a,b", "t,s1,s2,a,b", "t,y_A,y_B,a,b"])
def test_a_run_of_any_name_ends_before_another(header: str, tmp_path: Path) -> None:
    path = table(tmp_path, header, lengths=(ROWS, 30, ROWS, 30, ROWS))
    names = header.split(",")
    if "left" in names:  # nothing says what these are
        with pytest.raises(InputError, match="give stop = 30"):
            stepid.read_table(path, time="t", position="left", input="a", position_scale=0.001)
    else:
        run = stepid.read_table(path, time="t", position=names[1], input="a", position_scale=0.001)
        assert run.time.size == 30


def test_a_run_whose_own_clock_ends_has_ended(tmp_path: Path) -> None:
    path = table(tmp_path, "all,t,left,b,right", lengths=(ROWS, 30, 30, ROWS, ROWS))
    run = stepid.read_table(path, time="t", position="left", position_scale=0.001)
    assert run.time.size == 30


def test_one_of_the_runs(tmp_path: Path) -> None:
    path = table(tmp_path, "t,x1,x2,x_ref,u1,u2")
    with pytest.raises(InputError, match="the column 'x_ref' is the position of run 'ref', but no column is its input"):
        stepid.read_tables(path, time="t", position="x", input="u", position_scale=0.001)
    runs = stepid.read_tables(path, time="t", position="x", input="u", position_scale=0.001, runs=("2", "run 1"))
    assert [run.name for run in runs] == ["run 2", "run 1"]
    (only,) = stepid.read_tables(path, time="t", position="x", input="u", position_scale=0.001, runs=("2",), name="a")
    assert only.name == "a"
    with pytest.raises(InputError, match="has no run '7'") as error:
        stepid.read_tables(path, time="t", position="x", input="u", runs=("7",))
    assert "'1' (x1), '2' (x2), 'ref' (x_ref)" in str(error.value)


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ("t,x1,x_1,u1,u2", "the columns 'x1' and 'x_1' are both the position of run '1'"),
        ("t,x1,x2,u1,u2,u", "the input of run '1' may be the column 'u1' or 'u', which all runs would share"),
        ("t,a,b,u1,u2", "no column is a run's 'x'"),
    ],
)
def test_what_names_do_not_tell_is_refused_with_the_columns(header: str, said: str, tmp_path: Path) -> None:
    path = table(tmp_path, header)
    with pytest.raises(InputError) as error:
        stepid.read_tables(path, time="t", position="x", input="u", position_scale=0.001)
    assert said in str(error.value)


def test_a_table_without_a_header_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bare.csv"
    path.write_text("\n".join(f"{0.01 * i},{i},{i}" for i in range(20)))
    with pytest.raises(InputError, match="has no header that would tell its runs apart"):
        stepid.read_tables(path, position="x", sample_time=0.01)


def test_a_manifest_takes_one_of_the_runs(tmp_path: Path) -> None:
    table(tmp_path, "t,x1,x2,u1,u2", lengths=(ROWS, 25, ROWS, 25, ROWS))
    (tmp_path / "campaign.toml").write_text(
        """
name = "side by side"
format = "table"
time = "t"
position = "x"
input = "u"
position_scale = 0.001
spring = "s"
damper = "d"

[[experiment]]
name = "case 4"
file = "all.csv"
run = "1"
added_mass = 0.0

[[experiment]]
name = "case 5"
file = "all.csv"
run = "2"
added_mass = 0.5
"""
    )
    campaign = stepid.read_campaign(tmp_path)
    assert [(run.name, run.added_mass, run.time.size) for run in campaign.experiments] == [
        ("case 4", 0.0, 25),
        ("case 5", 0.5, ROWS),
    ]
    assert campaign["case 5"].position[0] == pytest.approx(0.2)
