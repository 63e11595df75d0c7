"""Headers as other programs write them, and last lines that are no rows."""

import numpy as np
import pytest

from exports import write
from stepid import read_table, read_tables
from stepid.errors import InputError
from table_text import CM, T, U, text

NAMED = {"time": "time", "position": "position", "input": "input"}
ROWS = text(T, CM, U, mark=",", head="time,position,input")


def test_a_frame_with_its_index(tmp_path):
    frame = [f"{i - 1 if i else ''},{line}" for i, line in enumerate(ROWS.splitlines())]
    write(tmp_path / "run.csv", "\n".join(frame) + "\n")  # df.to_csv("run.csv")
    run = read_table(tmp_path / "run.csv", **NAMED, position_scale=0.01)
    np.testing.assert_allclose(run.position, 0.01 * CM)
    with pytest.raises(InputError, match=r"no column 'x' for position \(\(no name\), time, position, input\)"):
        read_table(tmp_path / "run.csv", time="time", position="x", input="input")


@pytest.mark.parametrize("ends", ["", ",,"])
def test_a_header_with_empty_columns_behind_it(tmp_path, ends):
    header, rows = ROWS.split("\n", 1)
    file = write(tmp_path / "run.csv", f"{header},,\n" + rows.replace("\n", f"{ends}\n"))
    np.testing.assert_allclose(read_table(file, **NAMED, position_scale=0.01).position, 0.01 * CM)
    (run,) = read_tables(write(tmp_path / "two.csv", file.read_text().replace("position", "x1", 1)), position="x",
                         time="time", input="input", position_scale=0.01)  # fmt: skip
    np.testing.assert_allclose(run.position, 0.01 * CM)


def test_a_damaged_row_below_a_header_with_empty_cells_is_named(tmp_path):
    lines = [f"{i},{line}" for i, line in enumerate(ROWS.splitlines())]
    lines[:2] = [",time,position,input", "0,0.0,oops,0.5"]
    with pytest.raises(InputError, match="line 2, column 'position': 'oops' is not a number"):
        read_table(write(tmp_path / "run.csv", "\n".join(lines)), **NAMED)


@pytest.mark.parametrize("mark", ["# ", "#", "% "])
def test_names_in_a_comment_are_said_to_stand_there(tmp_path, mark):
    file = write(tmp_path / "run.csv", f"# rig 3\n{mark}{ROWS}")
    with pytest.raises(InputError, match=r"line 2: names the column 'time' in a comment") as refused:
        read_table(file, **NAMED)
    assert "Remove the mark of the comment, or give the columns by index" in refused.value.remedy
    assert read_table(file, time=0, position=1, input=2, position_scale=0.01).time.size == T.size


@pytest.mark.parametrize("last", ["END", "\x1a", "end of file"])
@pytest.mark.parametrize("sep", [",", ";", "\t"])
def test_a_last_line_that_is_no_row_is_named(tmp_path, last, sep):
    file = write(tmp_path / "run.csv", ROWS.replace(",", sep) + last + "\n")
    with pytest.raises(InputError, match=rf"line {T.size + 2}, column 'time': .* is not a number. Restore the line"):
        read_table(file, **NAMED)
