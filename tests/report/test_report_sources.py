"""What a report rests on: the samples it shows, and the hashes of what was read."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import numpy as np

import diagnosis_example as example
import stepid
from diagnosis_example import changed
from stepid.core.provenance import made_now
from stepid.diagnosis.result import RunGap
from stepid.report import provenance, story
from stepid.report.story import tell
from stepid.report.thin import MOST, kept_samples


def test_thinning_keeps_the_extremes_and_is_said() -> None:
    d = example.named()
    first = d.runs[0]
    time = np.linspace(0.0, 1.0, 5000)
    y = np.sin(300 * time)
    y[1234], y[4321] = 9.0, -9.0
    kept = kept_samples(y)
    assert kept.size <= MOST
    assert {0, 1234, 4321, 4999} <= set(kept.tolist())
    assert np.all(np.diff(kept) > 0)
    assert kept_samples(y[:MOST]).tolist() == list(range(MOST))
    long = RunGap(**first.model_dump() | {"time": time, "measured": y, "linear": y, "model": y})
    (notes,) = [c for c in tell(changed(d, runs=(long,)), None, provenance.of_data(d)) if c.name == "notes"]
    assert any(f"{first.name} show at most {MOST} samples" in point for point in notes.points)
    (notes,) = [c for c in tell(d, None, provenance.of_data(d)) if c.name == "notes"]
    assert not [point for point in notes.points if "samples of a curve" in point]


def test_hashes_are_those_of_the_files(tmp_path: Path) -> None:
    manifest = stepid.write_campaign(example.campaign(), tmp_path / "lab")
    d = changed(example.named())
    for given in (manifest, manifest.parent):
        files = {f.name: hashlib.sha256(f.read_bytes()).hexdigest() for f in sorted(manifest.parent.iterdir())}
        read = stepid.read_campaign(given)
        found = provenance.of_diagnosis(d._bearing(made_now("diagnose", data=[read])))
        assert {s.name: s.sha256 for s in found.sources} == files
        assert found.of_files
    assert dict(found.versions)["stepid"] == stepid.__version__
    assert {"Python", "numpy", "scipy", "control"} < dict(found.versions).keys()


def test_hashes_of_data_change_with_the_data() -> None:
    d = example.named()
    sources = provenance.of_data(d).sources
    assert [s.name for s in sources] == list(example.RUNS)
    assert len({s.sha256 for s in sources}) == len(example.RUNS)
    first = d.runs[0]
    moved = RunGap(**first.model_dump() | {"measured": first.measured + 1e-9})
    other = provenance.of_data(changed(d, runs=(moved, *d.runs[1:]))).sources
    assert other[0].sha256 != sources[0].sha256
    assert other[1:] == sources[1:]


def luminance(color: str) -> float:
    """Relative luminance of WCAG 2."""
    parts = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return float(
        np.dot([0.2126, 0.7152, 0.0722], np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4))
    )


def test_every_line_stands_out_from_its_ground_light_and_dark() -> None:
    style = (Path(story.__file__).parent / "palette.css").read_text(encoding="utf-8")
    blocks = [
        dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", block))
        for block in re.findall(r":root, :host \{(.*?)\}", style, re.S)
    ]
    themes = [block for block in blocks if "run-0" in block]
    assert len(themes) == 2
    for colors in themes:
        ground = luminance(colors["card"])
        for name in (*(f"run-{i}" for i in range(7)), "measured", "before", "after", "mark"):
            line = luminance(colors[name])
            assert (max(line, ground) + 0.05) / (min(line, ground) + 0.05) >= 3.0, name  # WCAG 2, 1.4.11
