"""Tables as loggers write them: decimal commas, a title and a date above the header."""

import numpy as np
import pytest

from exports import write
from stepid import draft_campaign, read_campaign, read_table
from stepid.errors import InputError
from table_text import CM, T, U, text

NAMED = {"time": "t", "position": "x", "input": "u"}
PREAMBLE = "Logger 3000;\nrecorded: 2026-03-02 14:05\n\n"


def commas(*columns, mark=";", head="t;x;u"):
    return text(*columns, mark=mark, head=head).replace(".", ",")


@pytest.mark.parametrize(("mark", "head"), [(";", "t;x;u"), ("\t", "t\tx\tu"), ("  ", "t x u"), (" ; ", "t ; x ; u")])
def test_decimal_commas(tmp_path, mark, head):
    file = write(tmp_path / "a.csv", commas(T, CM, U, mark=mark, head=head))
    run = read_table(file, **NAMED, decimal=",", position_scale=0.01)
    np.testing.assert_array_equal(run.time, T)
    np.testing.assert_array_equal(run.position, 0.01 * CM)
    np.testing.assert_array_equal(run.input, U)
    with pytest.raises(InputError, match=r"a.csv, line 2, column 't': '0,0' has a decimal comma") as caught:
        read_table(file, **NAMED)
    assert 'Give decimal = ","' in caught.value.remedy


def quoted(head="t,x,u", index=False):
    """As pandas writes a frame with decimal="," and commas between its cells."""
    rows = (
        [*([str(i)] if index else []), f'"{t}"', f'"{x}"', f'"{u}"']
        for i, (t, x, u) in enumerate(zip(T, CM, U, strict=True))
    )
    return head + "\n" + "\n".join(",".join(cell.replace(".", ",") for cell in row) for row in rows) + "\n"


@pytest.mark.parametrize("index", [False, True])
def test_quoted_decimal_commas_between_commas(tmp_path, index):
    file = write(tmp_path / "a.csv", quoted(",t,x,u" if index else "t,x,u", index=index))
    for options in ({}, {"delimiter": ","}):
        run = read_table(file, **NAMED, decimal=",", position_scale=0.01, **options)
        np.testing.assert_array_equal(run.position, 0.01 * CM)
    with pytest.raises(InputError, match=r"line 2, column 't': '0,0' has a decimal comma. Give decimal = \",\""):
        read_table(file, **NAMED)
    draft = draft_campaign(write(tmp_path / "b.csv", quoted("t [s],x [cm],u [V]")), added_mass=0.0)
    assert draft.runs[0].layout == {"decimal": ","}
    np.testing.assert_allclose(draft.campaign()[0].position, 0.01 * CM)


def test_quoted_names_may_hold_the_separator(tmp_path):
    rows = text(T, CM, U, mark=",", head='"t, s","x, cm",u')
    run = read_table(write(tmp_path / "a.csv", rows), time="t, s", position="x, cm", input="u", position_scale=0.01)
    np.testing.assert_array_equal(run.position, 0.01 * CM)
    odd = text(T, CM, U, mark=",", head='"t,x,u')  # a mark too many
    assert read_table(write(tmp_path / "b.csv", odd), **NAMED, position_scale=0.01).time.size == T.size


def test_a_single_column_with_decimal_commas(tmp_path):
    file = write(tmp_path / "a.csv", commas(CM, head="x"))
    np.testing.assert_array_equal(read_table(file, position="x", sample_time=0.005, decimal=",").position, CM)
    with pytest.raises(InputError, match=r"line 2: rows hold 2 values under a header of 1 names. Give decimal = \",\""):
        read_table(file, position="x", sample_time=0.005)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0,005;", "0.005;", r"line 3, column 't': '0.005' has a decimal point. Leave out decimal"),
        ("0,005;", "1.000,5;", r"line 3, column 't': '1.000,5' has marks between its thousands. Export"),
        ("0,005;", "1 000,5;", r"line 3, column 't': '1 000,5' has marks between its thousands. Export"),
        ("0,005;", "1.00,5;", r"line 3, column 't': '1.00,5' is not a number. Restore the line"),
        ("0,005;", "-1,#IND;", r"line 3, column 't': -1,#IND is not a measurement"),
        ("0,005;", "1e999;", r"line 3, column 't': '1e999' is too large"),
    ],
)
def test_numbers_that_do_not_fit_decimal_commas(tmp_path, old, new, message):
    file = write(tmp_path / "a.csv", commas(T, CM, U).replace(old, new, 1))
    with pytest.raises(InputError, match=message):
        read_table(file, **NAMED, decimal=",")


def test_lines_that_end_with_the_delimiter(tmp_path):
    ended = text(T, CM, U, mark=";", head="t;x;u").replace("\n", ";\n")
    for content, columns in ((ended, NAMED), (ended.split("\n", 1)[1], {"time": 0, "position": 1, "input": 2})):
        run = read_table(write(tmp_path / "a.csv", content), **columns)
        np.testing.assert_array_equal(run.position, CM)
        np.testing.assert_array_equal(run.input, U)


@pytest.mark.parametrize("above", [PREAMBLE, "# made up\nTitle\n\n", "1;2;3\n", "a;b;c\ns;m;V\n"])
def test_lines_above_the_header_are_left_out_on_request(tmp_path, above):
    plain = text(T, CM, U, mark=";", head="t;x;u")
    file = write(tmp_path / "a.csv", above + plain)
    count = above.count("\n")
    with pytest.raises(InputError, match=rf"is not the header, which comes in line {count + 1}") as caught:
        read_table(file, **NAMED)
    assert f"Give skiprows = {count} " in caught.value.remedy
    run = read_table(file, **NAMED, skiprows=count)
    np.testing.assert_array_equal(run.position, CM)
    bare = write(tmp_path / "b.csv", above + text(T, CM, U, mark=";"))
    np.testing.assert_array_equal(read_table(bare, time=0, position=1, input=2, skiprows=count).position, CM)
    both = read_table([file, file], position="x", input="u", sample_time=0.005, skiprows=count)
    np.testing.assert_array_equal(both.position, [*CM, *CM])  # of each file


def test_columns_by_index_under_a_preamble_are_told_of_skiprows(tmp_path):
    file = write(tmp_path / "a.csv", PREAMBLE + text(T, CM, U, mark=";", head="t;x;u"))
    with pytest.raises(InputError, match=r"a.csv, line 2: rows hold 3 values under a header of 2 names.*skiprows"):
        read_table(file, time=0, position=1, input=2)


def test_errors_count_the_lines_of_the_file(tmp_path):
    damaged = (PREAMBLE + text(T, CM, U, mark=";", head="t;x;u")).replace("0.005;", "oops;", 1)
    with pytest.raises(InputError, match=r"line 6, column 't': 'oops' is not a number"):
        read_table(write(tmp_path / "a.csv", damaged), **NAMED, skiprows=3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"decimal": ";"}, r"decimal is ';'. Give \"\.\" or \",\""),
        ({"decimal": None}, "decimal is None"),
        ({"decimal": ",", "delimiter": ","}, "delimiter and decimal are both ','"),
        ({"skiprows": -1}, "skiprows is -1"),
        ({"skiprows": True}, "skiprows is True"),
        ({"skiprows": [0, 1]}, r"skiprows is \[0, 1\]"),
        ({"skiprows": 1000}, "holds no rows of numbers below line 1000"),
        ({"skiprows": 1}, r"has no column 't' for time \(no header"),
    ],
)
def test_layouts_that_cannot_be(tmp_path, options, message):
    file = write(tmp_path / "a.csv", text(T, CM, U, mark=";", head="t;x;u"))
    with pytest.raises(InputError, match=message):
        read_table(file, **NAMED, **options)


def test_the_same_in_a_manifest(tmp_path):
    write(tmp_path / "a.csv", PREAMBLE + commas(T, CM, U))
    manifest = """
name = "rig"
format = "table"
time = "t"
position = "x"
position_scale = 0.01
input = "u"
decimal = ","
skiprows = 3
spring = "s"
damper = "d"
[[experiment]]
name = "a"
file = "a.csv"
added_mass = 0.5
"""
    (run,) = read_campaign(write(tmp_path / "campaign.toml", manifest)).experiments
    np.testing.assert_array_equal(run.position, 0.01 * CM)
    for old, new, message in (
        ('decimal = ","', 'decimal = "comma"', r"campaign.toml: decimal is 'comma'. It must be \"\.\""),
        ("skiprows = 3", "skiprows = 3.0", "skiprows is 3.0. It must be a whole number"),
        ("skiprows = 3\n", "", r"run 'a': .*a.csv, line 1: .*line 4. Give skiprows = 3 to leave out"),
        (
            'decimal = ","\n',
            "",
            r"run 'a': .*a.csv, line 5, column 't': '0,0' has a decimal comma. Give decimal = \",\"",
        ),
    ):
        write(tmp_path / "campaign.toml", manifest.replace(old, new))
        with pytest.raises(InputError, match=message):
            read_campaign(tmp_path)
