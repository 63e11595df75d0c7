"""LabVIEW's text files: the sample time stands above the rows, and a column of comments has no cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stepid
from stepid.io.guess.understand import draft_runs

T = 0.002 * np.arange(300)
X = 8 * np.exp(-T) * np.cos(30 * T)  # mm
WAVES = "waveform\t[0]\t[1]\nt0\t01/22/2020 11:12:13\t01/22/2020 11:12:13\ndelta t\t0.002000\t{}\n\n"
MEASURED = (
    "LabVIEW Measurement\nSeparator\tTab\nX_Columns\tNo\n***End_of_Header***\n\nChannels\t1\nSamples\t300\n"
    "X_Dimension\tTime\nX0\t0.0E+0\nDelta_X\t2.000000E-3\n***End_of_Header***\nX_Value\tPosition (mm)\tComment\n"
)


def write(file: Path, head: str, decimal: str = ".", before: str = "") -> Path:
    rows = "".join(f"{before}{x:.6f}\t{float(i > 9):.6f}\n" for i, x in enumerate(X))
    file.write_text(head + rows.replace(".", decimal), encoding="utf-8")
    return file


@pytest.mark.parametrize("decimal", [".", ","])
def test_delta_t_of_waveforms_is_the_sample_time(decimal: str, tmp_path: Path) -> None:
    file = write(tmp_path / "run.txt", (WAVES.format("0.002000") + "Y [mm]\tu (V)\n").replace(".", decimal), decimal)
    (draft,) = draft_runs([file])
    assert draft.sample_time is not None
    assert (draft.sample_time.value, draft.sample_time.why) == (0.002, "the lines above")
    run = stepid.draft_campaign(file, added_mass=0.0).campaign()[0]
    assert run.time == pytest.approx(T)


@pytest.mark.parametrize("head", [WAVES.format("0.004000"), "delta t\t0.002\n"])
def test_two_or_a_bare_delta_t_tell_none(head: str, tmp_path: Path) -> None:
    (draft,) = draft_runs([write(tmp_path / "run.txt", head + "Y [mm]\tu (V)\n")])
    assert draft.sample_time is None


def test_a_column_of_comments_without_cells_keeps_the_names_of_the_others(tmp_path: Path) -> None:
    text = MEASURED + "".join(f"\t{x:.6f}\n" for x in X)
    (tmp_path / "run.lvm").write_text(text, encoding="utf-8")
    (draft,) = draft_runs([tmp_path / "run.lvm"])
    assert (draft.titles["position"], draft.units["position"].value) == ("Position (mm)", "mm")
    run = stepid.draft_campaign(tmp_path / "run.lvm", step=0.0, added_mass=0.0).campaign()[0]
    assert run.time == pytest.approx(T)
    assert run.position == pytest.approx(1e-3 * X, abs=1e-8)
