"""A reader of one's own is one class and one entry: a manifest takes its keys from it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stepid import Experiment, read_campaign
from stepid.errors import InputError
from stepid.io.campaign_files import READERS
from stepid.io.manifest_values import check_positive

MANIFEST = """\
name = "scope"
counts_per_meter = 1000.0
added_mass = 0.5
spring = "medium"
damper = "none"
{above}
[[experiment]]
name = "one"
format = "scope"
file = "one.scope"
{own}
"""


class ScopeReader:
    """Bytes of an oscilloscope: a position in its divisions, one byte a sample, under a volt."""

    records = "records of the oscilloscope"
    hint = "bytes"
    keys = {"meters_per_division": check_positive, "rate": check_positive}  # noqa: RUF012
    required = ("rate",)

    def read(self, paths: Sequence[Path], **keys: Any) -> Experiment:
        counts = np.frombuffer(paths[0].read_bytes(), dtype=np.uint8)
        if not counts.size:
            raise InputError(f"{paths[0]}: is empty", "Record again.")
        scale, rate = keys.pop("meters_per_division", 0.01), keys.pop("rate")
        return Experiment(
            time=np.arange(counts.size) / rate, position=scale * counts, input=np.ones(counts.size), **keys
        )


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setitem(READERS, "scope", ScopeReader())
    (tmp_path / "one.scope").write_bytes(bytes(range(100)))
    return tmp_path


def written(folder: Path, *, above: str = "", own: str = "") -> Path:
    (folder / "campaign.toml").write_text(MANIFEST.format(above=above, own=own), encoding="utf-8")
    return folder


@pytest.mark.parametrize("place", ["above", "own"])
def test_a_manifest_is_read_with_it(folder: Path, place: str) -> None:
    (run,) = read_campaign(written(folder, **{place: "rate = 200\nmeters_per_division = 0.001"})).experiments
    np.testing.assert_allclose(run.position, 0.001 * np.arange(100))
    assert (run.name, run.added_mass, run.sample_time) == ("one", 0.5, pytest.approx(0.005))


@pytest.mark.parametrize(
    ("own", "words"),
    [
        ("", "run 'one': the key 'rate' is missing"),
        ("rate = -1", r"run 'one': rate is -1\. It must be above zero"),
        ("rates = 200", "run 'one': unknown key 'rates'.*Did you mean 'rate'"),
        ("rate = 200\nencoder = 2", "the key 'encoder' is for exports of the ECP program"),
    ],
)
def test_its_keys_are_checked(folder: Path, own: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_campaign(written(folder, own=own))


def test_what_it_refuses_names_the_run(folder: Path) -> None:
    (folder / "one.scope").write_bytes(b"")
    with pytest.raises(InputError, match=r"run 'one': .*one\.scope: is empty\. Record again"):
        read_campaign(written(folder, own="rate = 200"))


def test_a_format_that_nobody_reads_is_told_which_there_are(folder: Path) -> None:
    path = written(folder, own="rate = 200") / "campaign.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('"scope"', '"tape"'), encoding="utf-8")
    with pytest.raises(InputError, match=r'"ecp" \(the default\) or "table" \(CSV.*\) or "scope" \(bytes\)'):
        read_campaign(folder)


def test_its_key_in_a_run_of_another_format_is_told_whose_it_is(folder: Path) -> None:
    path = written(folder, own="rate = 200") / "campaign.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('format = "scope"\n', ""), encoding="utf-8")
    with pytest.raises(InputError, match=r"'rate' is for records of the oscilloscope\. Add format = \"scope\""):
        read_campaign(folder)
