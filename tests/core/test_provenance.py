"""What a result says about where it comes from."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

import diagnosis_example as example
import stepid
from stepid.core.provenance import made_now, plain, versions
from stepid.core.recorded import recorded


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    stepid.write_campaign(example.campaign(), tmp_path / "lab")
    return tmp_path / "lab"


def test_hashes_are_those_of_the_bytes_that_were_read(lab: Path) -> None:
    there = {path.name: sha256(path) for path in lab.iterdir()}
    campaign = stepid.read_campaign(lab)
    for path in lab.iterdir():
        path.write_text("something else", encoding="utf-8")
    for result in (campaign, stepid.identify(campaign), stepid.Campaign(name="c", experiments=campaign.experiments)):
        told = made_now("test", data=[result])
        assert {s.name: s.sha256 for s in told.sources} | {"campaign.toml": there["campaign.toml"]} == there
        assert [s.name for s in told.records] == list(example.RUNS)
    assert campaign.provenance is not None
    assert campaign.provenance.sources[0].name == "campaign.toml"
    assert campaign.provenance.function == "read_campaign"


def test_a_slice_comes_from_the_file_of_its_record(lab: Path) -> None:
    path = sorted(lab.glob("*.txt"))[0]
    run = stepid.read_ecp(path, counts_per_meter=226600, name="a")
    for part in (run, run.slice(0, 100), stepid.characterize(run)):
        assert part.provenance is not None
        assert [(s.name, s.sha256) for s in part.provenance.sources] == [(path.name, sha256(path))]
    assert run.provenance is not None
    assert run.provenance.settings["counts_per_meter"] == 226600


def test_files_in_folders_are_named_from_the_manifest(lab: Path) -> None:
    (lab / "data").mkdir()
    text = (lab / "campaign.toml").read_text(encoding="utf-8")
    for path in lab.glob("*.txt"):
        path.rename(lab / "data" / path.name)
    (lab / "campaign.toml").write_text(text.replace('file = "', 'file = "data/'), encoding="utf-8")
    campaign = stepid.read_campaign(lab)
    assert campaign.provenance is not None
    names = [s.name for s in campaign.provenance.sources]
    assert names == ["campaign.toml", *(f"data/{path.name}" for path in sorted((lab / "data").iterdir()))]


def test_it_is_outside_equality_and_json(lab: Path) -> None:
    read, made = stepid.read_campaign(lab), example.campaign()
    read = stepid.Campaign(name=made.name, experiments=read.experiments)
    assert read == made
    assert hash(read) == hash(made)
    assert read.model_dump_json() == made.model_dump_json()
    assert read.experiments[0].provenance is not None
    assert made.provenance is None


def test_settings_are_the_keywords_with_what_none_stands_for() -> None:
    @recorded(peak=stepid.InterpolatedPeak)
    def estimate(data: object, *, peak: object = None, effort: object = None, workers: int = 1) -> stepid.Estimate:
        return stepid.Estimate(value=1.0)

    runs = tuple(stepid.Experiment(**dict(run)) for run in example.campaign().experiments)
    told = estimate(stepid.Campaign(name="made", experiments=runs), effort=stepid.Effort.quick(), workers=2).provenance
    assert told is not None
    assert told.function == "estimate"
    assert set(told.settings) == {"peak", "effort"}
    assert told.settings["peak"] == {"kind": "InterpolatedPeak"}
    assert told.settings["effort"] == {"kind": "Effort", **stepid.Effort.quick().to_dict()}
    assert [s.name for s in told.records] == list(example.RUNS)
    assert told.sources == ()
    assert told.versions["numpy"] == np.__version__
    assert told.versions == versions()


def test_only_the_outermost_function_tells_and_errors_pass() -> None:
    @recorded()
    def inner(run: stepid.Experiment) -> stepid.Estimate:
        return stepid.Estimate(value=1.0)

    @recorded()
    def outer(run: stepid.Experiment) -> tuple[stepid.Estimate, ...]:
        first = inner(run)
        assert first.provenance is None
        return (first, stepid.Estimate(value=2.0))

    (run, *_) = example.campaign().experiments
    assert [e.provenance.function for e in outer(run) if e.provenance] == ["outer", "outer"]
    with pytest.raises(TypeError):
        outer()  # type: ignore[call-arg]
    with pytest.raises(stepid.errors.InputError):
        stepid.identify(3)  # type: ignore[arg-type]


def test_settings_are_plain() -> None:
    given = {
        "array": np.arange(3.0),
        "number": np.float32(0.5),
        "nothing": float("nan"),
        "path": Path("/home/someone/lab/a.txt"),
        "effect": stepid.effects.CATALOGUE[0],
        "nested": ({"a": (1, 2)},),
        "function": print,
    }
    told = plain(given)
    assert told["array"]["shape"] == [3]
    assert (told["number"], told["nothing"], told["path"]) == (0.5, "nan", "a.txt")
    assert told["effect"] == stepid.effects.CATALOGUE[0].name
    assert told["nested"] == [{"a": [1, 2]}]
    assert "0x" not in told["function"]
