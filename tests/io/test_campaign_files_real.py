"""Recordings made by others, and practice campaigns: read where their folder is known, never part of the project."""

import os
from pathlib import Path

import numpy as np
import pytest

from stepid import Campaign, read_campaign, read_ecp, read_table, write_campaign
from stepid.errors import InputError

REAL = os.environ.get("STEPID_REAL_DATA")
PRACTICE = os.environ.get("STEPID_PRACTICE_DATA")
real = pytest.mark.skipif(not REAL, reason="STEPID_REAL_DATA does not name the folder of real recordings")
practice = pytest.mark.skipif(not PRACTICE, reason="STEPID_PRACTICE_DATA does not name a folder of campaigns")
SCALE = -56000.0


def in_folder(name):
    return Path(REAL or "") / name


@real
def test_every_export_reads():
    files = sorted(in_folder("ecp210-ucsd").glob("*.csv"))
    assert len(files) >= 9
    for file in files:
        head = file.read_text().splitlines()[0]
        encoders = [n for n in (1, 2, 3) if f"Encoder {n} Pos" in head]
        assert encoders
        for encoder in encoders:
            if file.stem == "closed_loop_pid":
                with pytest.raises(InputError, match=r"closed-loop move: .*from 0 to 1000"):
                    read_ecp(file, counts_per_meter=SCALE, encoder=encoder)
                continue
            run = read_ecp(file, counts_per_meter=SCALE, encoder=encoder)
            assert run.sample_time == pytest.approx(0.0088542, abs=2e-7)
            assert run.time.size == 677
            assert run.is_release == ("manual" in file.stem)
            if not run.is_release:
                assert set(run.input) == {0.0, 0.5}
                assert run.position.max() > 1e-3  # +V gives falling counts, so the sign of the scale turns them up


@real
def test_real_exports_write_and_read_back_equal(tmp_path):
    files = sorted(in_folder("ecp210-ucsd").glob("DOF1_en1*.csv"))
    campaign = Campaign(name="c", experiments=tuple(read_ecp(f, counts_per_meter=SCALE) for f in files))
    manifest = write_campaign(campaign, tmp_path / "c")
    assert len(list(manifest.parent.glob("*.txt"))) == len(files) == 3
    assert read_campaign(manifest) == campaign


@real
def test_free_releases_in_centimeters():
    folders = sorted(in_folder("ecp210-milan/free-release").iterdir())
    assert len(folders) == 12
    for folder in folders:
        run = read_table(
            sorted(folder.glob("data*.txt")), position=0, position_scale=0.01, sample_time=0.005, name=folder.name
        )
        assert run.is_release
        assert run.sample_time == pytest.approx(0.005, rel=1e-12)
        np.testing.assert_allclose(run.position, 0.01 * np.loadtxt(folder / "data0000.txt"), rtol=1e-15)
        np.testing.assert_allclose(run.time, 0.005 * np.arange(run.time.size), rtol=1e-15)


@real
def test_steps_in_counts_over_several_files():
    folders = sorted(in_folder("ecp210-milan/steps").iterdir())
    assert len(folders) == 4
    for folder in folders:
        files = sorted(folder.glob("data*.txt"))
        run = read_table(files, input=0, position=2, position_scale=-1 / 56000, sample_time=0.005, name=folder.name)
        assert set(run.input) <= {-3.0, 0.0, 3.0}
        table = np.concatenate([np.loadtxt(file) for file in files])
        np.testing.assert_array_equal(run.input, table[:, 0])
        np.testing.assert_allclose(run.position, -table[:, 2] / 56000, rtol=1e-15)
    files = sorted(in_folder("ecp210-milan/steps/steps_kmed_nomass").glob("data*.txt"))
    options = {"input": 0, "position": 2, "position_scale": -1 / 56000, "sample_time": 0.005}
    asleep = read_table(files, **options, stop=980)
    awake = read_table(files, **options, start=980)
    assert np.ptp(asleep.position) < 1e-4 < np.ptp(awake.position)
    assert awake.time[0] == pytest.approx(4.9)


@real
def test_table_with_time_and_input_columns():
    file = in_folder("ecp210-trento") / "data_steps.txt"
    for column in (1, 2, 3):
        run = read_table(file, time=0, position=column, input=4, position_scale=1 / 226600, counts_per_meter=226600)
        assert run.time.size == 7401
        assert run.sample_time == pytest.approx(0.005, rel=1e-9)
        table = np.loadtxt(file)
        np.testing.assert_array_equal(run.time, table[:, 0])
        np.testing.assert_array_equal(run.input, table[:, 4])
        np.testing.assert_allclose(run.position, table[:, column] / 226600, rtol=1e-15)
        assert (run.input.min(), run.input.max()) == (0.0, 0.5)


@pytest.mark.slow
@practice
def test_practice_campaigns_read_and_write_back(tmp_path):
    manifests = sorted(Path(PRACTICE or "").glob("*/campaign.toml"))
    assert len(manifests) >= 54
    for manifest in manifests:
        campaign = read_campaign(manifest)
        again = write_campaign(campaign, tmp_path / manifest.parent.name)
        assert read_campaign(again) == campaign
        pairs = zip(sorted(manifest.parent.glob("case*.txt")), sorted(again.parent.glob("0*.txt")), strict=True)
        for theirs, ours in pairs:  # byte for byte, but for the sign of zero
            assert ours.read_bytes() == theirs.read_bytes().replace(b"-0 ", b" 0 ")
