"""Keys above the runs of a manifest: they hold for all runs, but where a run says otherwise."""

import numpy as np
import pytest

from exports import export_bytes, motion, write
from stepid import read_campaign
from stepid.errors import InputError

X, U = motion(100)
CM = X / 560

RUN = """
[[experiment]]
name = "{0}"
file = "{0}.csv"
"""
ABOVE = """\
name = "my rig"
format = "table"
time = "t"
position = "x"
input = "u"
position_scale = 0.01
time_scale = 0.5
input_scale = 2
delimiter = ","
added_mass = 0.5
spring = "medium"
damper = "none"
"""


@pytest.fixture
def tables(tmp_path):
    for name in ("a", "b", "c"):
        rows = (f"{0.005 * i:.3f},{x!r},{u!r}" for i, (x, u) in enumerate(zip(CM.tolist(), U.tolist(), strict=True)))
        write(tmp_path / f"{name}.csv", "t,x,u\n" + "\n".join(rows))
    return tmp_path


def test_keys_above_the_runs_are_theirs_unless_they_say_otherwise(tables):
    own = 'added_mass = 1.5\nposition_scale = -0.01\nspring = "stiff"\n'
    write(tables / "campaign.toml", ABOVE + RUN.format("a") + RUN.format("b") + own + RUN.format("c"))
    a, b, c = read_campaign(tables).experiments
    each = "".join(RUN.format(name) + ABOVE.split("\n", 1)[1] for name in ("a", "c"))
    write(tables / "campaign.toml", 'name = "my rig"\n' + each)
    assert read_campaign(tables).experiments == (a, c)  # as if every run had said it
    np.testing.assert_array_equal(b.position, -a.position)
    assert (a.sample_time, a.input[-1]) == (pytest.approx(0.0025), 2 * U[-1])
    assert (a.added_mass, b.added_mass, a.spring, b.spring, b.damper) == (0.5, 1.5, "medium", "stiff", "none")


@pytest.mark.parametrize(
    ("above", "own", "first"),
    [("", "step = { level = 0.25 }\n", 0.25), ("step = { level = 1 }\n", "input = 'u'\n", U[0])],
)
def test_a_run_takes_step_in_place_of_input_and_the_reverse(tables, above, own, first):
    shared = ABOVE.replace('input = "u"\n', above) if above else ABOVE
    write(tables / "campaign.toml", shared + RUN.format("a") + RUN.format("b") + own)
    a, b = read_campaign(tables).experiments
    assert b.input[0] == first
    assert not np.array_equal(a.input, b.input)


def test_what_stands_above_goes_to_the_runs_that_know_it(tables):
    write(tables / "case4.txt", export_bytes(n=100))
    above = 'counts_per_meter = 56000\ntime = "t"\ninput = "u"\nencoder = 1\nspring = "medium"\ndamper = "none"\n'
    export = RUN.format("case4").replace(".csv", ".txt") + "added_mass = 0\n"
    table = RUN.format("a") + 'format = "table"\nposition = "x"\nposition_scale = 0.01\nadded_mass = 1\n'
    write(tables / "campaign.toml", 'name = "both"\n' + above + export + table)
    one, two = read_campaign(tables).experiments
    np.testing.assert_array_equal(one.position, X / 56000)
    np.testing.assert_array_equal(two.position, CM * 0.01)
    write(tables / "campaign.toml", 'name = "both"\n' + above + export)
    with pytest.raises(InputError, match=r"campaign.toml: the key 'time' is for tables, and no run is one"):
        read_campaign(tables)
    write(tables / "campaign.toml", ABOVE + "encoder = 1\n" + RUN.format("a"))
    with pytest.raises(InputError, match=r"the key 'encoder' is for exports of the ECP program, and no run is one"):
        read_campaign(tables)


def test_a_record_in_place_of_the_manifest(tables):
    with pytest.raises(
        InputError, match=r"a\.csv: is no manifest of a campaign \(.*Give a campaign\.toml that names this"
    ):
        read_campaign(tables / "a.csv")


@pytest.mark.parametrize("name", ["run.json", "run.dat"])
@pytest.mark.parametrize("text", ['[{"t": 0.5, "x": 1.5}, {"t": 1.5, "x": 2.5}]', '{"t": [0.5, 1.5]}'])
def test_json_in_place_of_the_manifest(tmp_path, name, text):
    for content in (text, text.replace("1.5", ", ".join(["1.5"] * 4000)), *(["0" * 2_000_000] * name.endswith("json"))):
        write(tmp_path / name, content)
        with pytest.raises(
            InputError, match=r"run\.\w+: is no manifest of a campaign but JSON\. Save the record as CSV\."
        ):
            read_campaign(tmp_path / name)


def test_many_points_in_place_of_the_manifest(tmp_path):
    write(tmp_path / "wide.csv", "t" + ",x" * 4000 + "\n" + ",".join(["0.5"] * 4001) + "\n")
    with pytest.raises(InputError, match=r"line 2: holds 4001 points.* Give a campaign\.toml that names this file"):
        read_campaign(tmp_path / "wide.csv")


def test_a_free_release_among_runs_with_an_input(tables):
    rows = (f"{0.005 * i:.3f},{x!r}" for i, x in enumerate(CM[::-1].tolist()))
    write(tables / "let go.csv", "t,x\n" + "\n".join(rows))
    write(tables / "campaign.toml", ABOVE + RUN.format("a") + RUN.format("let go"))
    with pytest.raises(InputError, match=r"run 'let go': .*no column 'u' for input \(t, x\).*0.0 for a free release"):
        read_campaign(tables)
    write(tables / "campaign.toml", ABOVE + RUN.format("a") + RUN.format("let go") + "step = { level = 0.0 }\n")
    assert [e.is_release for e in read_campaign(tables).experiments] == [False, True]


def test_what_inputs_do_between_samples_is_said_for_all_runs_or_one(tables):
    write(
        tables / "campaign.toml",
        'input_between = "lines"\n' + ABOVE + RUN.format("a") + RUN.format("b") + "input_between = 'held'\n",
    )
    assert [run.input_between for run in read_campaign(tables).experiments] == ["lines", "held"]
    write(tables / "campaign.toml", 'starts = "motion"\n' + ABOVE + RUN.format("a") + "starts = 'rest'\n")
    assert [run.starts for run in read_campaign(tables).experiments] == ["rest"]
    write(tables / "campaign.toml", "starts = true\n" + ABOVE + RUN.format("a"))
    with pytest.raises(InputError, match=r"starts is True.*\"rest\" or \"motion\""):
        read_campaign(tables)
    write(tables / "campaign.toml", 'input_between = "straight"\n' + ABOVE + RUN.format("a"))
    with pytest.raises(InputError, match=r"input_between is 'straight'.*\"lines\" \(joined by straight lines\)"):
        read_campaign(tables)
