"""Writing campaigns: they read back equal, nothing is overwritten and nothing is left half-written."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exports import PERIOD, export_bytes, motion, write
from stepid import Campaign, Experiment, read_campaign, write_campaign
from stepid.errors import InputError

X, U = motion(100)


def experiment(**fields):
    standard = {
        "name": "case 5",
        "time": PERIOD * np.arange(100),
        "position": X / 56000,
        "input": U,
        "added_mass": 0.5,
        "spring": "medium",
        "damper": "1/2 turn",
        "counts_per_meter": 56000.0,
    }
    return Experiment(**{**standard, **fields})


def test_whole_counts_become_the_raw_export_byte_for_byte(tmp_path):
    campaign = Campaign(name="c", experiments=(experiment(),))
    manifest = write_campaign(campaign, tmp_path / "new" / "folder")
    assert manifest == tmp_path / "new" / "folder" / "campaign.toml"
    assert sorted(p.name for p in manifest.parent.iterdir()) == ["01-case-5.txt", "campaign.toml"]
    raw = (manifest.parent / "01-case-5.txt").read_bytes()
    # laid out by hand after the format's description, but for Commanded Pos, which the writer lets follow at once
    lines = export_bytes(n=100).split(b"\n")
    for mine, line in zip(raw.split(b"\n"), lines, strict=True):
        assert mine[:15] + mine[31:] == line[:15] + line[31:]
    assert raw.startswith(b" Sample   Time     Commanded Pos   Encoder 1 Pos   Control Effort\r\n\n[    0    0.000  ")
    assert raw.endswith(b"          0.5000]\r\n")
    assert read_campaign(manifest) == campaign


@pytest.mark.parametrize(
    ("fields", "suffix"),
    [
        ({}, ".txt"),
        ({"counts_per_meter": -226600.0, "position": X / -226600}, ".txt"),
        ({"input_before": 0.25}, ".txt"),
        ({"input_between": "lines"}, ".txt"),
        ({"starts": "motion"}, ".txt"),
        ({"starts": "rest", "counts_per_meter": None}, ".csv"),
        ({"input_between": "smooth", "counts_per_meter": None}, ".csv"),
        ({"time": PERIOD * np.arange(7, 107)}, ".txt"),
        ({"time": 0.1 + PERIOD * np.arange(100)}, ".csv"),
        ({"time": PERIOD * np.arange(-7, 93)}, ".csv"),
        ({"time": PERIOD * np.arange(200_000, 200_100)}, ".csv"),
        ({"position": X / 56000 + 1e-9}, ".csv"),
        ({"position": X * 1e12 / 56000}, ".csv"),
        ({"input": U + 1e-5}, ".csv"),
        ({"input": U * 100}, ".csv"),
        ({"counts_per_meter": None}, ".csv"),
        ({"counts_per_meter": 1e-300}, ".csv"),
        ({"position": -0.0 * X}, ".txt"),
    ],
)
def test_reads_back_equal(tmp_path, fields, suffix):
    campaign = Campaign(name="c", experiments=(experiment(**fields), experiment(name="other")), weight_uncertainty=0.01)
    manifest = write_campaign(campaign, tmp_path)
    assert [p.suffix for p in sorted(tmp_path.glob("01*"))] == [suffix]
    assert read_campaign(manifest) == campaign


names = st.text(min_size=1, max_size=12)
floats = st.floats(allow_nan=False, allow_infinity=False)
scales = floats.filter(bool)


@st.composite
def experiments(draw, name):
    n = draw(st.integers(8, 24))
    period = draw(st.floats(1e-5, 10.0))
    counts = np.array(draw(st.lists(st.integers(-(2**40), 2**40), min_size=n, max_size=n)), dtype=float)
    scale = draw(st.none() | st.floats(1.0, 1e7) | st.floats(-1e7, -1.0))
    whole = draw(st.booleans())
    volts = draw(st.lists(st.integers(-120_000, 120_000), min_size=n, max_size=n))
    return Experiment(
        name=name,
        time=(draw(st.integers(-10, 1000)) + np.arange(n)) * period,
        position=counts / (scale or 1.0) if whole else np.array(draw(st.lists(floats, min_size=n, max_size=n))),
        input=np.round(np.array(volts) * 1e-4, 4 if whole else 9),
        added_mass=draw(st.floats(0, allow_infinity=False)),
        spring=draw(names),
        damper=draw(names),
        base=draw(names),
        counts_per_meter=scale,
        input_before=draw(floats),
    )


@st.composite
def campaigns(draw):
    runs = draw(st.lists(names, min_size=1, max_size=3, unique=True))
    return Campaign(
        name=draw(names),
        experiments=tuple(draw(experiments(name)) for name in runs),
        weight_uncertainty=draw(st.floats(min_value=1e-12, allow_infinity=False)),
    )


@given(campaigns())
@settings(max_examples=60, deadline=None)
def test_any_campaign_reads_back_equal(tmp_path_factory, campaign):
    folder = tmp_path_factory.mktemp("campaign") / "new"
    assert read_campaign(write_campaign(campaign, folder)) == campaign
    assert Campaign.model_validate_json(campaign.model_dump_json()) == campaign


def test_names_of_any_kind_read_back(tmp_path):
    odd = [
        "\x7f",
        "\x00\x1f",
        'a "quoted" \\ name',
        "tab\tand\r\nline",
        "München ½ 🛒",
        "../up",
        "  ",
        "CON",
        "x" * 300,
    ]
    runs = tuple(experiment(name=name, spring=name, damper=name, base=name) for name in odd)
    campaign = Campaign(name=odd[0], experiments=runs)
    assert read_campaign(write_campaign(campaign, tmp_path / "new")) == campaign
    assert len(list((tmp_path / "new").iterdir())) == len(odd) + 1


def test_nothing_is_overwritten(tmp_path):
    campaign = Campaign(name="c", experiments=(experiment(),))
    for name in ("campaign.toml", "01-case-5.txt"):
        file = write(tmp_path / name, "mine")
        with pytest.raises(InputError, match=f"{name}: exists already"):
            write_campaign(campaign, tmp_path)
        assert [p.name for p in tmp_path.iterdir()] == [name]
        assert file.read_text() == "mine"
        file.unlink()
    write(tmp_path / "notes.md", "mine")
    write_campaign(campaign, tmp_path)
    assert (tmp_path / "notes.md").read_text() == "mine"
    with pytest.raises(InputError, match="exists already"):
        write_campaign(campaign, tmp_path)
    assert read_campaign(tmp_path) == campaign


@pytest.mark.parametrize("broken", ["write_bytes", "replace"])
@pytest.mark.parametrize("after", [0, 1, 2])
def test_nothing_is_left_half_written(tmp_path, monkeypatch, broken, after):
    original, calls = getattr(Path, broken), []

    def fails(self, *args):
        calls.append(self)
        if len(calls) > after:
            raise OSError(28, "No space left on device")
        return original(self, *args)

    campaign = Campaign(name="c", experiments=(experiment(), experiment(name="other")))
    monkeypatch.setattr(Path, broken, fails)
    for folder in (tmp_path / "new" / "deep", tmp_path):
        calls.clear()
        with pytest.raises(InputError, match=r"cannot be written \(No space left"):
            write_campaign(campaign, folder)
        assert list(tmp_path.iterdir()) == []
        assert len(calls) == after + 1


def test_folders_that_cannot_be(tmp_path):
    campaign = Campaign(name="c", experiments=(experiment(),))
    file = write(tmp_path / "file", "x")
    for folder in (file, file / "below", "a\0b", "x" * 5000, None, ""):
        with pytest.raises(InputError):
            write_campaign(campaign, folder)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
