"""Damaged exports: each mistake is named by file, line and column, and nothing but the library's errors escapes."""

import pytest

from exports import PERIOD, columns_of, export_bytes, rows_of, write
from stepid import read_ecp
from stepid.errors import InputError

SCALE = 56000.0
GOOD = export_bytes(newline="\n").decode()
LINES = GOOD.split("\n")  # header, blank, row of Sample 0 on line 3


def changed(line, old, new):
    lines = list(LINES)
    assert old in lines[line - 1]
    lines[line - 1] = lines[line - 1].replace(old, new, 1)
    return "\n".join(lines)


def removed(line, count=1):
    return "\n".join(LINES[: line - 1] + LINES[line - 1 + count :])


def two_periods():
    data = columns_of("stc1u")
    data["t"][150:] += 0.0004 * (data["s"][150:] - 150)
    return export_bytes(rows=rows_of(data))


def jump_in_time():
    data = columns_of("stc1u")
    data["t"][150:] += 0.1
    return export_bytes(rows=rows_of(data))


def dropped(letter):
    return export_bytes("stc1u".replace(letter, ""))


DAMAGED = {
    "empty": (b"", "is empty"),
    "blank": (b" \r\n\r\n", "is empty"),
    "header only": (LINES[0], "no rows of numbers"),
    "prose": ("Dear all,\nthe file will follow.\n", "no rows of numbers"),
    "no rows": (LINES[0] + "\n\n[\n]\n", "line 3: no rows between the brackets"),
    "few rows": ("\n".join(LINES[:6])[:-1] + "]", "holds 4 rows; a record needs at least 8"),
    "binary": (b"\x7fELF\x01\0\0\0" * 40, "line 1: holds a zero byte"),
    "Latin-1": ("Prüfstand\n".encode("latin-1") + GOOD.encode(), "line 1: byte 0xfc is not UTF-8"),
    "Latin-1 after BOM": (b"\xef\xbb\xbfa\n\xfc\n", "line 2: byte 0xfc is not UTF-8"),
    "UTF-16": (GOOD.encode("utf-16"), "is UTF-16 text"),
    "cut off": (GOOD[: len(GOOD) // 2], r"line \d+: no closing bracket; cut off"),
    "cut at the start": (GOOD[len(GOOD) // 2 :], "bracket without its partner"),
    "truncated row": (changed(40, "0.5000;", ""), r"line 40: the row holds 4 values for 5 columns"),
    "two rows in one": (changed(40, ";", LINES[40]), r"line 40"),
    "text": (changed(40, "0.5000", "0.5O00"), r"line 40, column 'Control Effort': '0.5O00' is not a number"),
    "comma": (changed(40, "0.5000", "0,5000"), r"line 40, column 'Control Effort': '0,5000' has a decimal comma"),
    "NaN": (changed(40, "0.5000", "NaN"), r"line 40, column 'Control Effort': NaN is not a measurement"),
    "infinity": (changed(40, "0.5000", "-Inf"), r"line 40, column 'Control Effort': -Inf is not a measurement"),
    "NaN of Windows": (changed(40, "0.5000", "1.#QNAN"), "1.#QNAN is not a measurement"),
    "overflow": (changed(40, "0.5000", "1e400"), r"line 40, column 'Control Effort': '1e400' is too large"),
    "huge": (changed(40, "0.5000", "1e300"), r"line 40, column 'Control Effort': 1e\+300 is no believable"),
    "huge sample": (changed(40, "    37 ", "  1e200 "), r"line 40, column 'Sample': 1e\+200"),
    "broken count": (changed(3, "               0          0", "             0.5          0"), "not whole counts"),
    "gap": (removed(40), r"line 40, column 'Sample': 38 follows 36"),
    "larger gap": (removed(40, 30), r"line 40, column 'Sample': 67 follows 36"),
    "doubled row": ("\n".join(LINES[:40] + LINES[39:]), r"line 41, column 'Sample': 37 follows 37"),
    "two sample times": (two_periods(), r"column 'Time': .* gap or two different sample times"),
    "jump in time": (jump_in_time(), r"line 153, column 'Time': 1.428 s does not follow"),
    "one wrong time": (changed(40, "0.328", "9.328"), r"line 40, column 'Time': 9.328 s"),
    "time stands still": (export_bytes(rows=rows_of(columns_of("stc1u") | {"t": [0.0] * 300})), "does not increase"),
    "no encoder": (dropped("1"), r"no column 'Encoder 1 Pos'.*the file has none"),
    "no effort": (dropped("u"), r"no Control Effort column.*StepInput"),
    "no time": (dropped("t"), r"has no Time column.*sample_time"),
    "no sample nor time": (export_bytes("c1u"), "neither a Sample nor a Time column"),
    "renamed column": (GOOD.replace("Encoder 1 Pos", "Encodr 1 Pos"), r"no column 'Encoder 1 Pos'"),
    "header of fewer names": (GOOD.replace("Commanded Pos", "             "), "names 4 columns .* over 5 numbers"),
    "column twice": (GOOD.replace("Commanded Pos", "Encoder 1 Pos"), "'Encoder 1 Pos' is named twice"),
    "two records": (GOOD + GOOD, "line 304: numbers after the closing bracket|numbers after the closing"),
    "row before the bracket": ("\n".join([LINES[3], *LINES]), "line 1: numbers before the opening bracket"),
    "text after the bracket": (GOOD.rstrip() + " and so on", "follows the closing bracket"),
    "no rows at all in the script": ("dat = [ % Sample Time\n", "no closing bracket"),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_damage_is_named(tmp_path, case):
    content, message = DAMAGED[case]
    file = write(tmp_path / "case4.txt", content)
    with pytest.raises(InputError, match=message) as caught:
        read_ecp(file, counts_per_meter=SCALE)
    assert caught.value.cause.startswith(str(file))
    assert caught.value.remedy


def test_files_that_cannot_be_opened(tmp_path):
    for path, message in (
        (tmp_path / "none.txt", r"none.txt: there is no such file"),
        (tmp_path, "is a folder"),
        ("x" * 5000, "cannot be read"),
        ("a\0b", "cannot be read"),
        ("", "is not a path"),
        (3, "3 is not a path"),
        (None, "None is not a path"),
        (b"case4.txt", "is not a path"),
    ):
        with pytest.raises(InputError, match=message):
            read_ecp(path, counts_per_meter=SCALE)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"encoder": 2}, r"no column 'Encoder 2 Pos'. Choose encoder=…; the file has Encoder 1 Pos"),
        ({"encoder": 0}, "encoder is 0"),
        ({"encoder": True}, "encoder is True"),
        ({"encoder": 1.0}, "encoder is 1.0"),
        ({"encoder": "1"}, "encoder is '1'"),
        ({"counts_per_meter": 0}, "is zero"),
        ({"counts_per_meter": float("inf")}, "counts_per_meter is inf"),
        ({"counts_per_meter": "226600"}, "counts_per_meter is '226600'"),
        ({"counts_per_meter": 1e-320}, "not finite"),
        ({"effort_scale": 0.0}, "is zero"),
        ({"effort_scale": 1e309}, "effort_scale is inf"),
        ({"sample_time": 0.0}, "sample_time is 0 s"),
        ({"sample_time": -PERIOD}, "sample_time is -0.00885"),
        ({"sample_time": True}, "sample_time is True"),
        ({"input_before": float("nan")}, "input_before is nan"),
        ({"added_mass": -0.5}, "added_mass: .*greater than or equal to 0"),
        ({"added_mass": float("nan")}, "added_mass"),
        ({"name": ""}, "name"),
        ({"name": 5}, "name"),
        ({"spring": ""}, "spring"),
        ({"damper": None}, "damper"),
        ({"base": 1}, "base"),
        ({"columns": ("Sample", "Time")}, "states 2 names, the rows hold 5"),
        ({"columns": "Sample"}, "columns is 'Sample'"),
        ({"columns": ("Sample", "Sample", "a", "b", "c")}, "'Sample' is named twice"),
        ({"columns": (1, 2, 3, 4, 5)}, "columns is"),
    ],
)
def test_arguments_that_cannot_be(tmp_path, options, message):
    file = write(tmp_path / "case4.txt", GOOD)
    with pytest.raises(InputError, match=message) as caught:
        read_ecp(file, **{"counts_per_meter": SCALE, **options})
    assert "case4.txt" in caught.value.cause


def test_a_record_at_rest_reads(tmp_path):
    data = columns_of("stc1u")
    for letter in "c1u":
        data[letter] = data[letter] * 0
    experiment = read_ecp(write(tmp_path / "a.txt", export_bytes(rows=rows_of(data))), counts_per_meter=SCALE)
    assert not experiment.position.any()
