"""Delimited tables: one file or several, columns by name or index."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exports import write
from stepid import StepInput, read_table
from stepid.errors import InputError
from table_text import CM, T, U, X, lines, text


def test_one_column_without_time_or_header(tmp_path):
    file = write(tmp_path / "data0000.txt", text(CM))
    run = read_table(file, position=0, position_scale=0.01, sample_time=0.005, added_mass=0.986, spring="high")
    np.testing.assert_array_equal(run.position, CM * 0.01)
    np.testing.assert_array_equal(run.time, 0.005 * np.arange(100))
    assert run.is_release
    assert (run.name, run.added_mass, run.spring, run.counts_per_meter) == ("data0000", 0.986, "high", None)


def test_files_that_continue_each_other(tmp_path):
    rows = lines(U, 0 * U, X)
    one = write(tmp_path / "data0000.txt", "\n".join(rows[:60]))
    two = write(tmp_path / "data0001.txt", "\r\n".join(rows[60:]) + "\r\n")
    run = read_table([one, str(two)], position=2, input=0, position_scale=-1 / 56000, sample_time=0.005)
    np.testing.assert_allclose(run.position, -X / 56000, rtol=1e-15)
    np.testing.assert_array_equal(run.input, U)
    assert run.time.size == 100
    part = read_table((one, two), position=2, input=0, sample_time=0.005, start=20, stop=90)
    np.testing.assert_array_equal(part.position, X[20:90])
    np.testing.assert_array_equal(part.time, T[20:90])


@pytest.mark.parametrize("mark", ["\t", ",", ";", " ", "   ", ", "])
@pytest.mark.parametrize("head", [True, False])
def test_delimiters_and_columns_by_name(tmp_path, mark, head):
    names = mark.join(["t", "x", '"u"']) if head else None
    file = write(tmp_path / "a.csv", "# made up\n\n" + text(T, X, U, mark=mark, head=names))
    columns = {"time": "t", "position": "x", "input": "u"} if head else {"time": 0, "position": 1, "input": 2}
    run = read_table(file, **columns, counts_per_meter=560)
    np.testing.assert_array_equal(run.time, T)
    np.testing.assert_array_equal(run.position, X)
    np.testing.assert_array_equal(run.input, U)
    assert run.resolution == 1 / 560
    assert read_table(file, **columns, delimiter=mark.strip(" ") or " ").position[-1] == X[-1]


def test_input_given_by_the_caller(tmp_path):
    file = write(tmp_path / "a.csv", text(T, X))
    step = read_table(file, time=0, position=1, input=StepInput(level=0.5, start=0.005), input_before=-0.5)
    assert list(step.input[:3]) == [-0.5, 0.5, 0.5]
    np.testing.assert_array_equal(read_table(file, time=0, position=1, input=U).input, U)
    np.testing.assert_array_equal(read_table(file, time=0, position=1, input=U[10:], start=10).input, U[10:])


def test_rounded_times_are_taken_or_checked(tmp_path):
    file = write(tmp_path / "a.csv", text(np.round(0.0088542 * np.arange(100), 3), X))
    np.testing.assert_array_equal(read_table(file, time=0, position=1).time, np.round(0.0088542 * np.arange(100), 3))
    run = read_table(file, time=0, position=1, sample_time=0.0088542)
    np.testing.assert_array_equal(run.time, 0.0088542 * np.arange(100))
    with pytest.raises(InputError, match=r"column|rows are about"):
        read_table(file, time=0, position=1, sample_time=0.01)


@given(st.floats(-10, 10).filter(lambda s: abs(s) > 1e-6))
@settings(max_examples=20, deadline=None)
def test_sign_of_the_scale_turns_the_record(tmp_path_factory, scale):
    file = write(tmp_path_factory.mktemp("sign") / "a.csv", text(T, CM))
    plus = read_table(file, time=0, position=1, position_scale=scale)
    minus = read_table(file, time=0, position=1, position_scale=-scale)
    np.testing.assert_array_equal(plus.position, -minus.position)


GOOD = text(T, X, U, mark=",", head="t,x,u")


def without(number):
    rows = GOOD.splitlines()
    return "\n".join(rows[: number - 1] + rows[number:])


def replaced(number, old, new):
    rows = GOOD.splitlines()
    assert old in rows[number - 1]
    rows[number - 1] = rows[number - 1].replace(old, new)
    return "\n".join(rows)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is empty"),
        ("# only a comment\n", "no rows of numbers"),
        ("t,x,u\n", "a header and no rows"),
        ("t,x,u\n0,1,0\n0.005,1,0\n", "keeps 2 of 2 rows"),
        (replaced(50, ",0.5", ""), r"line 50: the row holds 2 values for 3 columns \(t, x, u\)"),
        (replaced(50, ",0.5", ",half"), r"line 50, column 'u': 'half' is not a number"),
        (replaced(50, ",0.5", ","), r"line 50, column 'u': is empty"),
        (replaced(50, ",0.5", ",nan"), r"line 50, column 'u': nan is not a measurement"),
        (replaced(50, ",0.5", ",-inf"), r"line 50, column 'u': -inf is not a measurement"),
        (replaced(50, ",0.5", ",1e999"), r"line 50, column 'u': '1e999' is too large"),
        (replaced(50, ",0.5", ",1_0"), r"line 50, column 'u': '1_0' is not a number"),
        (replaced(50, "0.24,", "#N/A,"), r"line 50, column 't': '#N/A' is not a number"),
        (GOOD.replace("0.0,", "#VALUE!,", 1), r"line 2, column 't': '#VALUE!' is not a number"),
        (replaced(101, "0.495,", "########,"), r"line 101, column 't': '########' is not a number"),
        (replaced(50, "0.24,", "0.2,"), r"line 50: 0.2 s after 0.235 s: time does not increase"),
        (replaced(1, "t,x,u", "t,x,x"), "names a column twice"),
        (replaced(1, "t,x,u", "t,x"), r"line 2: rows hold 3 values under a header of 2 names"),
        (replaced(1, "t,x,u", "t,y,u"), r"no column 'x' for position \(t, y, u\)"),
        (
            text(T, X, U, mark=";", head="t;x;u").replace(".", ","),
            r"column 't': '0,0' has a decimal comma. Give decimal",
        ),
    ],
)
def test_damaged_tables_name_line_and_column(tmp_path, content, message):
    file = write(tmp_path / "run.csv", content)
    with pytest.raises(InputError, match=message) as caught:
        read_table(file, time="t", position="x", input="u")
    assert "run.csv" in caught.value.cause
    assert caught.value.remedy


@pytest.mark.parametrize("comment", ["#", "## t, x", "#### rows 1, 2 ####", "########", "#TODO: 5", "% 0,1,0"])
def test_comments_among_the_rows_are_left_out(tmp_path, comment):
    rows = GOOD.splitlines()
    file = write(tmp_path / "run.csv", "\n".join([*rows[:50], comment, *rows[50:]]))
    assert read_table(file, time="t", position="x", input="u").time.size == 100


def test_a_damaged_first_row_is_not_taken_for_a_header(tmp_path):
    for first in ("NaN", "-x", "0.1.2"):
        file = write(tmp_path / "a.txt", first + "\n" + text(CM))
        with pytest.raises(InputError, match="line 1"):
            read_table(file, position=0, sample_time=0.005)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "nothing says when the rows were taken"),
        ({"sample_time": 0.0}, "sample_time is 0 s"),
        ({"sample_time": -1.0}, "sample_time is -1 s"),
        ({"sample_time": float("nan")}, "sample_time is nan"),
        ({"time": 0, "sample_time": 0.006}, r"given as 0.006 s, but rows are 0.005"),
        ({"time": 5}, "no column 5 for time"),
        ({"time": -1}, "no column -1 for time"),
        ({"time": True}, "no column True for time"),
        ({"time": 2}, "time does not increase"),
        ({"time": 0, "position": "y"}, "no column 'y' for position"),
        (
            {"time": 0, "input": "volts"},
            r"no column 'volts' for input .*Correct input=…, or give StepInput.*step = \{ level = … \}",
        ),
        ({"time": 0, "position_scale": 0.0}, "position_scale is zero"),
        ({"time": 0, "input": 2, "input_scale": 0}, r"input_scale is zero. Give volts per unit"),
        ({"time": 0, "time_scale": 0.0}, "time_scale is zero. Give seconds per unit"),
        ({"time": 0, "time_scale": -0.001}, "time_scale is -0.001"),
        ({"time": 0, "time_scale": float("nan")}, "time_scale is nan"),
        ({"time": 0, "input_scale": "5"}, "input_scale is '5'"),
        ({"time": 0, "position_scale": "1"}, "position_scale is '1'"),
        ({"time": 0, "position_scale": 1e308}, "not finite"),
        ({"time": 0, "counts_per_meter": 0.0}, "counts_per_meter is zero"),
        ({"time": 0, "counts_per_meter": 10**400}, "counts_per_meter is"),
        ({"time": 0, "added_mass": -0.5}, "added_mass"),
        ({"time": 0, "added_mass": 10**400}, "added_mass"),
        ({"time": 0, "spring": ""}, "spring"),
        ({"time": 0, "delimiter": ""}, "delimiter is ''"),
        ({"time": 0, "start": 95}, "keeps 5 of 100 rows"),
        ({"time": 0, "start": 10, "stop": 5}, "keeps 0 of 100 rows"),
        ({"time": 0, "stop": 101}, "stop is 101; the record has 100 rows"),
        ({"time": 0, "start": -3}, "start is -3"),
        ({"time": 0, "input": [0.0, 1.0]}, r"input has shape \(2,\)"),
    ],
)
def test_arguments_that_cannot_be(tmp_path, options, message):
    file = write(tmp_path / "a.csv", text(T, X, U))
    with pytest.raises(InputError, match=message):
        read_table(file, **{"position": 1, **options})


def test_paths_that_cannot_be(tmp_path):
    for paths in ([], None, 3, b"a.txt", [None], "", "a\0b", tmp_path, tmp_path / "none.txt", "x" * 5000):
        with pytest.raises(InputError):
            read_table(paths, position=0, sample_time=0.005)


def test_joined_files_share_a_layout(tmp_path):
    one = write(tmp_path / "one.csv", text(T, X))
    two = write(tmp_path / "two.csv", text(T, X, U))
    with pytest.raises(InputError, match=r"two.csv, line 1: has other columns than .*one.csv"):
        read_table([one, two], position=1, sample_time=0.005)
    with pytest.raises(InputError, match=r"one.csv, line 1: 0 s after 0.495 s.*a clock of its own"):
        read_table([one, one], position=1, time=0)
    slow = write(tmp_path / "slow.csv", text(0.5 + 2 * T, X))
    assert read_table([one, slow], position=1, time=0).time[-1] == 1.49  # uneven samples


def test_a_missing_position_lists_the_columns(tmp_path):
    file = write(tmp_path / "run.csv", GOOD)
    with pytest.raises(
        InputError, match=r"run.csv: nothing says which column is the position \(t, x, u\). Give position="
    ):
        read_table(file, time="t", input="u")
    with pytest.raises(InputError, match=r"the position \(no header; columns count from 0 to 2\)"):
        read_table(write(tmp_path / "bare.csv", text(T, X, U)), time=0)


def test_all_that_nobody_said_is_named_at_once(tmp_path):
    rows = text(T, 10 * CM, U, 0 * T, mark=",", head="time_s,pos_mm,volts,note")
    file = write(tmp_path / "run.csv", rows)
    with pytest.raises(InputError) as caught:
        read_table(file)
    error = caught.value
    asked = "nothing says which column is the position, nor when the rows were taken, nor what the input is"
    assert error.cause == f"{file}: {asked} (time_s, pos_mm, volts, note)"
    assert error.remedy.startswith("Give position=…, time=… or sample_time=… (s), and input=… or StepInput(level=…)")
    told = "position='pos_mm', position_scale=0.001, time='time_s', input='volts'"
    assert error.remedy.endswith(f"By the names of the columns: {told}.")
    read = eval(f"read_table(file, {told})", {"read_table": read_table, "file": file})  # as it stands
    np.testing.assert_allclose(read.position, CM / 100, rtol=1e-12)
    np.testing.assert_array_equal(read.input, U)
    with pytest.raises(InputError, match="nor what the input is") as caught:
        read_table(file, position=1, position_scale=-0.001)
    assert caught.value.remedy.endswith("By the names of the columns: time='time_s', input='volts'.")
    still = write(tmp_path / "still.csv", text(T, X, mark=",", head="t,x"))
    with pytest.raises(InputError, match=r"position, nor when the rows were taken \(t, x\)"):
        read_table(still)
    with pytest.raises(InputError, match=r"which column is the position \(t, x\)\. Give position=…\. By the names"):
        read_table(still, sample_time=0.005)


def test_names_that_suggest_nothing_or_two_things_suggest_nothing(tmp_path):
    file = write(tmp_path / "run.csv", text(T, X, X, mark=",", head="t,x1,x2"))
    with pytest.raises(InputError, match=r"By the names of the columns: time='t'\.$"):
        read_table(file)
    with pytest.raises(
        InputError, match=r"count from 0 to 1\)\. Give position=…, and time=… or sample_time=… \(s\)\.$"
    ):
        read_table(write(tmp_path / "bare.csv", text(T, X)))


def test_time_and_input_in_units_of_their_own(tmp_path):
    """As a microcontroller's millis() and an 8-bit PWM give them."""
    file = write(tmp_path / "run.csv", text(1e3 * T, CM, 255 * U, mark=",", head="t,x,pwm"))
    run = read_table(
        file, time="t", time_scale=1e-3, position="x", position_scale=0.01, input="pwm", input_scale=6 / 255
    )
    np.testing.assert_allclose(run.time, T, rtol=1e-12)
    np.testing.assert_allclose(run.input, 6 * U, rtol=1e-12)
    whole = read_table(file, time=0, time_scale=1e-3, position=1, input=StepInput(level=0.5), input_scale=9)
    assert whole.input[-1] == 0.5  # it scales the column, not volts that were given
    same = read_table(file, time=0, time_scale=1e-3, sample_time=0.005, position=1)
    np.testing.assert_allclose(same.time, T, rtol=1e-12)


def test_text_beside_the_readings_is_no_matter(tmp_path):
    rows = GOOD.splitlines()
    file = write(tmp_path / "a.csv", "\n".join(["clock," + rows[0], *("12:00:01," + row for row in rows[1:])]))
    np.testing.assert_array_equal(read_table(file, time="t", position="x", input="u").position, X)
    with pytest.raises(InputError, match=r"line 2, column 'clock': '12:00:01' is not a number"):
        read_table(file, time="clock", position="x", input="u")
    bare = write(tmp_path / "b.csv", "\n".join([*(row + ",ok" for row in rows[1:60]), *rows[60:]]))
    with pytest.raises(InputError, match=r"b.csv, line 60: the row holds 3 values for 4 columns"):
        read_table(bare, time=0, position=1, input=2)


def test_a_line_of_units_is_said_to_be_one_too_many(tmp_path):
    rows = GOOD.splitlines()
    file = write(tmp_path / "a.csv", "\n".join([rows[0], "s,m,V", *rows[1:]]))
    with pytest.raises(InputError, match=r"line 2, column 't': 's' is not a number.*remove it if it holds no readings"):
        read_table(file, time="t", position="x", input="u")


def test_empty_cells_beside_the_readings_do_not_matter(tmp_path):
    rows = [
        f"{t:.17g},{x:.17g},{'' if n % 3 else 'nan'},{n if n % 2 else ''}"
        for n, (t, x) in enumerate(zip(T, X, strict=True))
    ]
    run = read_table(write(tmp_path / "a.csv", "\n".join(["t,x,note,count", *rows])), time="t", position="x")
    np.testing.assert_array_equal(run.position, X)
