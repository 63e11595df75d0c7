"""Campaigns on disk: reading the manifest, writing, and reading back equal."""

import numpy as np
import pytest

from exports import export_bytes, motion, write
from stepid import read_campaign
from stepid.errors import InputError

X, U = motion(100)
CM = X / 560

MANIFEST = """\
name = "spring 2005"
counts_per_meter = 56000

[[experiment]]
name = "case 4"
file = "case4.txt"
added_mass = 0
spring = "medium"
damper = "1/2 turn"

[[experiment]]
name = "case 5"
file = "sub/case5.txt"
added_mass = 0.5
spring = "medium"
damper = "1/2 turn"
encoder = 2
input_between = "smooth"
sample_time = 0.0088542
base = "cart and damper"
counts_per_meter = -28000
input_before = -0.1

[[experiment]]
name = "the paper's"
file = "paper.txt"
added_mass = 1.5
spring = "medium"
damper = "4 turns"
step = { level = 0.5, start = 0.0088542, end = 0.5 }

[[experiment]]
name = "a table"
format = "table"
files = ["data0000.txt", "data0001.txt"]
position = 0
position_scale = 0.01
sample_time = 0.005
input_between = "lines"
added_mass = 0.986
spring = "high"
damper = "none"
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "sub").mkdir()
    write(tmp_path / "case4.txt", export_bytes(n=100))
    write(tmp_path / "sub" / "case5.txt", export_bytes("stc12u", n=100))
    write(tmp_path / "paper.txt", export_bytes("stc123", n=100))
    rows = [repr(float(v)) for v in CM]
    write(tmp_path / "data0000.txt", "\n".join(rows[:50]))
    write(tmp_path / "data0001.txt", "\n".join(rows[50:]))
    write(tmp_path / "campaign.toml", MANIFEST)
    return tmp_path


def test_manifest_with_every_kind_of_run(folder):
    campaign = read_campaign(folder / "campaign.toml")
    assert campaign == read_campaign(str(folder))
    assert campaign.name == "spring 2005"
    four, five, paper, table = campaign.experiments
    np.testing.assert_array_equal(four.position, X / 56000)
    np.testing.assert_array_equal(four.input, U)
    assert (four.added_mass, four.base, four.counts_per_meter, four.input_before) == (0.0, "cart", 56000.0, 0.0)
    np.testing.assert_allclose(five.position, np.rint(0.4 * X) / -28000)
    np.testing.assert_array_equal(five.time, 0.0088542 * np.arange(100))
    assert (five.base, five.counts_per_meter, five.input_before) == ("cart and damper", -28000.0, -0.1)
    assert list(paper.input[[0, 1, 55, 56, 57]]) == [0.0, 0.5, 0.5, 0.0, 0.0]
    np.testing.assert_array_equal(table.position, CM * 0.01)
    assert table.is_release
    assert (table.spring, table.sample_time, table.counts_per_meter) == ("high", 0.005, 56000.0)


def test_campaign_keys(folder):
    write(
        folder / "campaign.toml",
        MANIFEST.replace("counts_per_meter = 56000\n", "counts_per_meter = 56000\nweight_uncertainty = 0.002\n", 1),
    )
    assert read_campaign(folder).weight_uncertainty == 0.002


BAD = {
    "not TOML": ("name =", "name = = ", r"campaign.toml: is not TOML"),
    "unknown key": (
        'spring = "medium"',
        'sping = "medium"',
        r"run 'case 4': unknown key 'sping'. Did you mean 'spring'",
    ),
    "unknown key of the campaign": (
        "counts_per_meter = 56000\n",
        "counts_per_metre = 56000\n",
        r"campaign.toml: unknown key 'counts_per_metre'. Did you mean 'counts_per_meter'",
    ),
    "far from any key": (
        "encoder = 2",
        "zzzz = 2",
        r"run 'case 5': unknown key 'zzzz'. Known keys: name, format, added_mass",
    ),
    "missing file": ("case4.txt", "case44.txt", r"run 'case 4': there is no file 'case44.txt' beside"),
    "missing file of a table": ("data0001.txt", "data0002.txt", r"run 'a table': there is no file 'data0002.txt'"),
    "wrong encoder": ("encoder = 2", "encoder = 3", r"run 'case 5': .*case5.txt: has no column 'Encoder 3 Pos'"),
    "no such encoder": ("encoder = 2", "encoder = 0", r"run 'case 5': .*encoder is 0"),
    "encoder in words": (
        "encoder = 2",
        'encoder = "two"',
        r"run 'case 5': encoder is 'two'. It must be a whole number",
    ),
    "duplicate names": ('"case 5"', '"case 4"', r"campaign.toml: .*the name 'case 4' is used by more than one run"),
    "negative mass": (
        "added_mass = 0.5",
        "added_mass = -0.5",
        r"run 'case 5': added_mass is -0.5. It must be .*0 or more",
    ),
    "mass in words": (
        "added_mass = 0.5",
        'added_mass = "0.5"',
        r"run 'case 5': added_mass is '0.5'. It must be a number",
    ),
    "mass not finite": ("added_mass = 0.5", "added_mass = nan", r"added_mass is nan. It must be a finite number"),
    "mass beyond floats": ("added_mass = 0.5", "added_mass = 1" + "0" * 400, "It must be a finite number"),
    "mass is missing": ("added_mass = 0\n", "", r"run 'case 4': the key 'added_mass' is missing"),
    "name is missing": ('name = "case 5"\n', "", r"experiment 2: the key 'name' is missing"),
    "file is missing": ('file = "case4.txt"\n', "", r"run 'case 4': the key 'file' is missing"),
    "two are missing": (
        'name = "case 5"\nfile = "sub/case5.txt"\nadded_mass = 0.5\n',
        'file = "sub/case5.txt"\n',
        r"experiment 2: the keys 'name', 'added_mass' are missing. Add name = …, added_mass = …",
    ),
    "position is missing": ("position = 0\n", "", r"run 'a table': the key 'position' is missing"),
    "empty label": ('spring = "medium"', 'spring = ""', "spring is ''. It must be text that is not empty"),
    "no scale": ("counts_per_meter = 56000\n", "", r"run 'case 4': counts_per_meter is missing"),
    "scale of zero": ("56000", "0", "counts_per_meter is 0. It must be a number other than zero"),
    "sample time of zero": ("0.0088542\nbase", "0.0\nbase", r"sample_time is 0.0. It must be above zero"),
    "wrong sample time": (
        "0.0088542\nbase",
        "0.009\nbase",
        r"run 'case 5': .*given as 0.009 s, but its Time column says",
    ),
    "step without level": ("level = 0.5, ", "", r"run \"the paper's\": step is \{.*level = 0.5, start = 0.0"),
    "step in words": ("level = 0.5", 'level = "0.5"', "step is"),
    "step after the record": ("start = 0.0088542, end = 0.5", "start = 5.0", r"starts at 5 s, outside the record"),
    "step is missing": (
        "step = { level = 0.5, start = 0.0088542, end = 0.5 }",
        "",
        r"the paper's\": .*no Control Effort",
    ),
    "unknown format": ('"table"', '"excel"', r"run 'a table': format is 'excel'"),
    "table key in an export": ("encoder = 2", "position = 2", r"run 'case 5': the key 'position' is for tables"),
    "export key in a table": (
        "position_scale = 0.01",
        "encoder = 1",
        r"run 'a table': the key 'encoder' is for exports of the ECP program",
    ),
    "file and files": ("position = 0\n", 'position = 0\nfile = "data0000.txt"\n', "needs either file or files"),
    "step and input": ("position = 0\n", "position = 0\ninput = 0\nstep = { level = 1 }\n", "both step and input"),
    "files is text": (
        '["data0000.txt", "data0001.txt"]',
        '"data0000.txt"',
        "files is 'data0000.txt'. It must be a list",
    ),
    "column is a float": (
        "position = 0\n",
        "position = 0.0\n",
        "position is 0.0. It must be a column's name or its index",
    ),
    "file above the runs": (
        "counts_per_meter = 56000\n",
        'counts_per_meter = 56000\nfile = "case4.txt"\n',
        r"campaign.toml: the key 'file' stands above the runs. Move it below",
    ),
    "bad default": (
        "counts_per_meter = 56000\n",
        "counts_per_meter = 56000\nposition_scale = 0\n",
        r"campaign.toml: position_scale is 0. It must be a number other than zero",
    ),
    "bad format above the runs": (
        "counts_per_meter = 56000\n",
        'counts_per_meter = 56000\nformat = "csv"\n',
        r"campaign.toml: format is 'csv'. It must be \"ecp\" .* or \"table\" \(CSV",
    ),
    "unknown key above the runs": (
        "counts_per_meter = 56000\n",
        "counts_per_meter = 56000\nzzzz = 1\n",
        r"campaign.toml: unknown key 'zzzz'. Known keys: name, .*_uncertainty, scale_uncertainty, .*position_scale",
    ),
    "key of the campaign in a run": (
        "added_mass = 0.5",
        "added_mass = 0.5\nweight_uncertainty = 0.01",
        r"run 'case 5': 'weight_uncertainty' is a key of the campaign. Move it above the first",
    ),
    "no runs": ("[[experiment]]", "[[experiments]]", "lists no experiments but 'experiments'. Write .*experiment"),
    "no run in small letters": ("[[experiment]]", "[[Experiment]]", "lists no experiments but 'Experiment'. Write"),
    "a backslash and a letter": (
        '"sub/case5.txt"',
        '"sub\\run5.txt"',
        r"run 'case 5': there is no file .*holds the control character '\\r'. Correct it: .* write \"/\" in its place",
    ),
    "backslashes": ('"sub/case5.txt"', '"C:\\Users\\x.txt"', r"is not TOML .*in \"…\" a backslash begins an escape"),
    "a backslash in single quotes": (
        '"sub/case5.txt"',
        "'sub\\nope5.txt'",
        r"there is no file 'sub.*nope5.txt' beside the manifest. Correct its name, with \"/\" between folders",
    ),
    "one table of runs": ("[[experiment]]", "[experiment]", "not TOML|lists no experiments"),
    "deep": ("name =", "deep = " + "[" * 5000 + "]" * 5000 + "\nname =", "not TOML|unknown key"),
}


@pytest.mark.parametrize("case", BAD)
def test_wrong_manifests_name_run_and_key(folder, case):
    old, new, message = BAD[case]
    assert old in MANIFEST
    every = case in ("no runs", "no run in small letters", "one table of runs")
    write(folder / "campaign.toml", MANIFEST.replace(old, new, -1 if every else 1))
    with pytest.raises(InputError, match=message) as caught:
        read_campaign(folder / "campaign.toml")
    assert "campaign.toml" in caught.value.cause
    assert caught.value.remedy


def test_a_run_in_single_brackets_is_named(folder):
    one = MANIFEST[: MANIFEST.index("[[experiment]]", MANIFEST.index("[[experiment]]") + 1)]
    write(folder / "campaign.toml", one.replace("[[experiment]]", "[experiment]"))
    with pytest.raises(InputError, match=r"lists no experiments but one \[experiment\]. Write two brackets"):
        read_campaign(folder)


def test_damage_in_a_record_names_run_file_and_line(folder):
    text = export_bytes(n=100).decode().replace("    37    0.328", "    37    0.3x8")
    write(folder / "case4.txt", text)
    with pytest.raises(InputError, match=r"run 'case 4': .*case4.txt, line 40, column 'Time': '0.3x8' is not a number"):
        read_campaign(folder)


def test_manifests_that_cannot_be_opened(tmp_path):
    for path in (tmp_path, tmp_path / "none.toml", "a\0b", "x" * 5000, None, 3, ""):
        with pytest.raises(InputError):
            read_campaign(path)
    for content in (b"", b"\xff\xfen", b"name = '\xfc'", b"\0"):
        with pytest.raises(InputError, match=r"campaign\.toml"):
            read_campaign(write(tmp_path / "campaign.toml", content))
