"""What a report rests on: the samples it shows, and the hashes of what was read."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

import diagnosis_example as example
import stepid
from report_example import changed
from stepid.diagnose.result import RunGap
from stepid.report import provenance
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
    for given in (manifest, manifest.parent):
        found = provenance.of_files(given)
        files = sorted(manifest.parent.iterdir())
        assert {s.name for s in found.sources} == {f.name for f in files}
        assert {s.sha256 for s in found.sources} == {hashlib.sha256(f.read_bytes()).hexdigest() for f in files}
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
