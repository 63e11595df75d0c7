"""Bad input on the command line: exit status 2, one message that names what is wrong, no traceback, nothing written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from exports import columns_of, header_of, rows_of
from stepid.cli import run

NAMES = [f"case {i}" for i in (4, 5, 6, 7)]
MASSES = [0.0, 0.5, 1.5, 2.0]
BASE, STIFFNESS, DAMPING = 0.95, 216.0, 9.0
LAYOUT = "stc1u"
Columns = dict[str, np.ndarray]


def columns(added: float, *, n: int = 700, damping: float = DAMPING, **options: float) -> Columns:
    mass = BASE + added
    frequency = np.sqrt(STIFFNESS / mass)
    ratio = damping / (2 * mass * frequency)
    return columns_of(LAYOUT, n, wn=frequency, zeta=ratio, counts=226600 * 0.036, **options)


def text(data: Columns) -> str:
    rows = rows_of(data)
    rows[0] = "[" + rows[0][1:]
    return header_of("".join(data)) + "\r\n\n" + ";\r\n".join(rows) + "]\r\n"


def entry(name: str, file: str, added: float, **more: str) -> str:
    lines = {
        "name": f'"{name}"',
        "file": f'"{file}"',
        "added_mass": f"{added}",
        "spring": '"medium"',
        "damper": '"half"',
    }
    return "\n[[experiment]]\n" + "".join(f"{k} = {v}\n" for k, v in (lines | more).items())


def make(
    folder: Path,
    change: Callable[[Columns], Columns] | None = None,
    *,
    masses: list[float] = MASSES,
    only: int | None = None,
    **options: float,
) -> Path:
    """Four good exports with a manifest; `change` is done to all of them, or to number `only`."""
    manifest = 'name = "made up"\ncounts_per_meter = 226600\n'
    for i, (name, added) in enumerate(zip(NAMES, masses, strict=False)):
        data = columns(MASSES[i], **options)
        if change is not None and only in (None, i):
            data = change(data)
        file = name.replace(" ", "") + ".txt"
        (folder / file).write_text(text(data), newline="")
        manifest += entry(name, file, added)
    (folder / "campaign.toml").write_text(manifest)
    return folder / "campaign.toml"


def refused(manifest: Path, capsys: pytest.CaptureFixture[str], *phrases: str) -> None:
    before = sorted(p.name for p in manifest.parent.iterdir())
    status = run(["identify", str(manifest), "--out", str(manifest.parent / "results")])
    out, err = capsys.readouterr()
    assert status == 2, out
    assert out == ""
    assert "Traceback" not in err
    assert err.count("stepid: ") == 1
    for phrase in phrases:
        assert phrase in err
    assert sorted(p.name for p in manifest.parent.iterdir()) == before


def test_the_good_campaign_passes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["identify", str(make(tmp_path))]) == 0
    assert "stiffness [medium]" in capsys.readouterr().out


def keep(n: int) -> Callable[[Columns], Columns]:
    return lambda data: {k: v[:n] for k, v in data.items()}


def put(letter: str, values: Callable[[np.ndarray], np.ndarray]) -> Callable[[Columns], Columns]:
    return lambda data: data | {letter: values(data[letter])}


def without(letter: str) -> Callable[[Columns], Columns]:
    return lambda data: {k: v for k, v in data.items() if k != letter}


def gap(data: Columns) -> Columns:
    return {k: np.delete(v, 300) for k, v in data.items()}


def two_periods(data: Columns) -> Columns:
    n = data["t"].size
    return data | {"t": data["t"] + 0.004 * np.maximum(np.arange(n) - n // 2, 0)}


FILES = {
    "column missing": (without("1"), ["case5.txt", "Encoder 1 Pos"]),
    "effort missing": (without("u"), ["case5.txt", "Control Effort"]),
    "two sample times": (two_periods, ["case5.txt"]),
    "gap in Sample": (gap, ["case5.txt", "Sample"]),
}


@pytest.mark.parametrize("damage", FILES)
def test_damaged_columns(damage: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change, phrases = FILES[damage]
    refused(make(tmp_path, change, only=1), capsys, *phrases)


def edit(path: Path, old: str, new: str) -> None:
    content = path.read_text()
    assert content.count(old) >= 1
    path.write_text(content.replace(old, new, 1))


TEXTS = {
    "text in a number column": lambda line: line[:20] + " " * 8 + "oops" + line[32:],
    "NaN": lambda line: line[:20] + " " * 9 + "NaN" + line[32:],
    "inf": lambda line: line[:20] + " " * 9 + "inf" + line[32:],
    "truncated row": lambda line: line[:20] + ";",
}


@pytest.mark.parametrize("damage", TEXTS)
def test_damaged_rows(damage: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    manifest = make(tmp_path)
    path = tmp_path / "case6.txt"
    lines = path.read_text().splitlines(keepends=True)
    lines[50] = TEXTS[damage](lines[50].rstrip()) + "\n"
    path.write_text("".join(lines))
    refused(manifest, capsys, "case6.txt", "line 51")


def test_empty_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    manifest = make(tmp_path)
    (tmp_path / "case7.txt").write_text("")
    refused(manifest, capsys, "case7.txt")


PHYSICS: dict[str, tuple[Callable[[Columns], Columns], list[str]]] = {
    "constant record": (put("1", lambda v: 0 * v + 12), ["case 4", "position"]),
    "no step in the input": (put("u", lambda v: 0 * v + 0.0), ["case 4"]),
    "step after the end": (lambda d: d | {"u": 0 * d["u"], "1": 0 * d["1"]}, ["case 4", "no step"]),
    "cut before its peak": (keep(20), ["case 4"]),
    "not settled": (keep(60), ["case 4"]),
}


@pytest.mark.parametrize("damage", PHYSICS)
def test_records_that_say_too_little(damage: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change, phrases = PHYSICS[damage]
    if damage == "no step in the input":  # and a position that moves, but not as a free swing does
        step = change
        change = lambda d: step(d) | {"1": np.where(np.arange(d["1"].size) > 99, 100.0, 0.0)}  # noqa: E731
    refused(make(tmp_path, change), capsys, *phrases)


def test_overdamped_records(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refused(make(tmp_path, damping=0.999 * 2 * np.sqrt(STIFFNESS * BASE), masses=MASSES[:1]), capsys, "case 4")


def test_one_bad_record_among_good_ones_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["identify", str(make(tmp_path, keep(60), only=3))]) == 0
    assert "left out: case 7: " in capsys.readouterr().out


def test_fewer_than_two_masses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refused(make(tmp_path, masses=MASSES[:1]), capsys, "made up", "Two runs")


def test_all_masses_equal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refused(make(tmp_path, masses=[0.5] * 4), capsys, "mass")


MANIFESTS = {
    "unknown label": ('spring = "medium"', 'spring = "medium"\nbase = ""', ["case 4"]),
    "negative mass": ("added_mass = 0.5", "added_mass = -0.5", ["case 5", "added_mass"]),
    "text for a mass": ("added_mass = 0.5", 'added_mass = "0.5"', ["case 5", "added_mass"]),
    "duplicate names": ('name = "case 5"', 'name = "case 4"', ["case 4"]),
    "missing file": ('file = "case5.txt"', 'file = "case55.txt"', ["case55.txt", "case 5"]),
    "unknown key": ("added_mass = 0.5", "added_mas = 0.5", ["added_mas", "added_mass"]),
    "wrong encoder": ("added_mass = 0.5", "added_mass = 0.5\nencoder = 4", ["case5.txt", "4"]),
    "encoder not in the file": ("added_mass = 0.5", "added_mass = 0.5\nencoder = 2", ["case5.txt", "Encoder 2"]),
    "no scale": ("counts_per_meter = 226600\n", "", ["counts_per_meter"]),
    "no TOML": ("[[experiment]]", "[[experiment", ["campaign.toml"]),
}


@pytest.mark.parametrize("damage", MANIFESTS)
def test_bad_manifests(damage: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old, new, phrases = MANIFESTS[damage]
    manifest = make(tmp_path)
    edit(manifest, old, new)
    refused(manifest, capsys, *phrases)


def test_springs_that_nothing_ties_are_left_out_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    manifest = make(tmp_path)
    content = manifest.read_text()
    head, _, last = content.rpartition('spring = "medium"')
    manifest.write_text(head + 'spring = "mediun"\nbase = "other"' + last)
    assert run(["identify", str(manifest)]) == 0
    out = capsys.readouterr().out
    assert "left out: case 7" in out
    assert "mediun" in out


def test_missing_manifest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refused(tmp_path / "campaign.toml", capsys, "campaign.toml")
