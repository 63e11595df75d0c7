"""Large tables are read the fast way, to the same numbers as the slow one, and what is wrong is said as before."""

import random

import numpy as np
import pytest

from stepid import read_table
from stepid.errors import InputError, StepidError
from stepid.io import delimited, plain_table
from stepid.io.plain_table import Places, parse_plain

RNG = np.random.default_rng(3)
NUMBERS = RNG.standard_normal((200, 3)) * 10.0 ** RNG.integers(-12, 8, (200, 3))


def text(separator=",", newline="\n", header="t,x,u", form="{!r}", decimal="."):
    rows = [separator.join(form.format(float(v)).replace(".", decimal) for v in row) for row in NUMBERS]
    lines = ([header.replace(",", separator)] if header else []) + rows
    return newline.join(lines) + newline


def slow(monkeypatch, *args):
    with monkeypatch.context() as patch:
        patch.setattr(delimited, "parse_plain", lambda *_, **__: None)
        return delimited.parse_table(*args)


def layout(**changes):
    return delimited.Layout(**{"delimiter": None, "decimal": ".", "skiprows": 0, "used": (0, 1, 2)} | changes)


@pytest.mark.parametrize(
    ("content", "fields"),
    [
        (text(), {}),
        (text(newline="\r\n"), {}),
        (text(", "), {}),
        (text(" ; ", header=""), {}),
        (text("\t", decimal=","), {"decimal": ","}),
        (text("  ", header="", form="{:+.9e}"), {}),
        (" " + text(" ", header="", newline=" \n "), {}),
        ("# made\n" + text() + "\n \n", {}),
        ("\ufeff" + text(), {}),
        ("three\nlines\n\n" + text(), {"skiprows": 3}),
        (text("|"), {"delimiter": "|"}),
    ],
)
def test_the_fast_way_reads_the_same(tmp_path, monkeypatch, content, fields):
    file = tmp_path / "a.csv"
    file.write_bytes(content.encode())
    monkeypatch.setattr(plain_table, "_PIECE", 3000)
    called = []
    monkeypatch.setattr(delimited, "parse_plain", lambda *a, **k: called.append(parse_plain(*a, **k)) or called[-1])
    fast = delimited.parse_table(file, layout(**fields))
    assert (called[0] is None) == (fields.get("delimiter") == "|")
    plain = slow(monkeypatch, file, layout(**fields))
    assert fast.names == plain.names
    np.testing.assert_array_equal(fast.values, plain.values)
    assert list(fast.places) == list(plain.places)
    assert len(fast.values) == 200


WRONG = ["x", "1.2.3", "", "--4", "1e", "1e999", "nan", "1_0", "1;2", "4,5", "0x1", "#", '"1"', "é", "1 2", ".", "+"]


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("row", [100, 199])
def test_what_is_not_plain_goes_the_slow_way(tmp_path, monkeypatch, wrong, row):
    lines = text().splitlines()
    cells = lines[1 + row].split(",")
    lines[1 + row] = ",".join([cells[0], wrong, cells[2]])
    file = tmp_path / "a.csv"
    file.write_text("\n".join(lines), encoding="utf-8")
    ends = []
    for read in (delimited.parse_table, lambda *args: slow(monkeypatch, *args)):
        try:
            ends.append(read(file, layout()).values.tolist())
        except InputError as error:
            ends.append(str(error))
    assert ends[0] == ends[1]


def test_blanks_around_a_decimal_comma_are_no_number_either_way(tmp_path, monkeypatch):
    whole = text(";", decimal=",").replace(",", " ,")
    assert parse_plain(whole.partition("\n")[2].encode(), width=3, separator=";", decimal=",") is None
    fields = {"delimiter": ";", "decimal": ","}
    file = tmp_path / "run.csv"
    file.write_text(whole, encoding="utf-8")
    for read in (delimited.parse_table, lambda *args: slow(monkeypatch, *args)):
        with pytest.raises(InputError, match=r"run\.csv, line 2"):
            read(file, layout(**fields))


def test_random_damage_ends_alike_both_ways(tmp_path, monkeypatch):
    rng = random.Random(4)
    good = text().encode()
    file = tmp_path / "a.csv"
    read = 0
    for _ in range(25):
        raw = bytearray(good)
        for _ in range(rng.choice((1, 1, 2))):
            raw[rng.randrange(len(raw))] = rng.choice(b"0123456789.,;-+eE \t\n\r#x")
        file.write_bytes(raw)
        ends = []
        for parse in (delimited.parse_table, lambda *args: slow(monkeypatch, *args)):
            try:
                found = parse(file, layout())
                ends.append((found.values.tolist(), list(found.places)))
            except StepidError as error:
                ends.append(str(error))
        assert ends[0] == ends[1]
        read += isinstance(ends[0], tuple)
    assert 2 < read < 23


def test_a_run_that_ends_before_the_table_goes_the_slow_way(tmp_path):
    rows = [f"{i / 100},{i % 7},{i % 5 if i < 40 else ''}" for i in range(300)]
    file = tmp_path / "a.csv"
    file.write_text("t,x1,x2\n" + "\n".join(rows))
    assert read_table(file, time="t", position="x2").time.size == 40
    assert read_table(file, time="t", position="x1").time.size == 300


def test_places_name_file_and_line():
    places = Places([("a", range(2, 5)), ("b", [7, 9])])
    assert list(places) == ["a, line 2", "a, line 3", "a, line 4", "b, line 7", "b, line 9"]
    assert list(places[1:4]) == ["a, line 3", "a, line 4", "b, line 7"]
    assert places[-1] == "b, line 9"
    assert len(places[2:2]) == 0
    for wrong in (5, -6):
        with pytest.raises(IndexError):
            places[wrong]
    with pytest.raises(ValueError, match="one segment"):
        places[::2]
