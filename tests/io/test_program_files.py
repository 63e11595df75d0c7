"""Files in binary formats of programs are refused by the program's name, with the way to text."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stepid
from stepid.errors import InputError

TABLE = "t (s),x (mm)\n" + "".join(f"{0.01 * i:.2f},{8 * np.cos(0.1 * i):.4f}\n" for i in range(100))
FILES = {
    "five.mat": (b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\1IM" + bytes(400), "MATLAB.*writematrix"),
    "seven.mat": (b"MATLAB 7.3 MAT-file, Platform: PCWIN64".ljust(512) + b"\x89HDF" * 9, "MATLAB.*writetable"),
    "four.mat": (b"\0\0\0\0\1\0\0\0" * 40, "MATLAB"),
    "large.mat": (b"MATLAB 5.0 MAT-file".ljust(2_000_000), "MATLAB"),
    "run.h5": (b"\x89HDF\r\n\x1a\n" * 9, "HDF5"),
    "run.npy": (b"\x93NUMPY\1\0" * 9, r"numpy\.savetxt"),
    "run.xls": (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" * 9, r"Excel.*Save it as \.xlsx"),
    "run.tdms": (b"TDSm" + bytes(99), r"LabVIEW.*\.lvm"),
}


@pytest.mark.parametrize("name", FILES)
def test_the_program_is_named_and_the_way_out(name: str, tmp_path: Path) -> None:
    content, words = FILES[name]
    (tmp_path / name).write_bytes(content)
    for read in (
        stepid.draft_campaign,
        lambda file: stepid.read_table(file, time=0, position=1),
        lambda file: stepid.read_ecp(file, counts_per_meter=1.0),
        *([stepid.read_campaign] if len(content) < 1_000_000 else []),  # of larger ones it tells the size
    ):
        with pytest.raises(InputError, match=words) as refused:
            read(tmp_path / name)
        assert refused.value.cause.startswith(str(tmp_path / name))


def test_among_recordings_they_are_left_out(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(TABLE, encoding="utf-8")
    (tmp_path / "b.mat").write_bytes(FILES["five.mat"][0])
    draft = stepid.draft_campaign([tmp_path / "a.csv", tmp_path / "b.mat"])
    assert [run.name for run in draft.runs] == ["a"]
    assert draft.left_out == (f"{tmp_path / 'b.mat'}: is a MATLAB file (.mat), and no text",)


def test_text_that_matlab_saves_is_read(tmp_path: Path) -> None:
    (tmp_path / "ascii.mat").write_text(TABLE.replace(",", "  ").split("\n", 1)[1], encoding="utf-8")
    assert dict(stepid.draft_campaign(tmp_path / "ascii.mat").runs[0].columns) == {"time": 0, "position": 1}


def test_text_that_names_matlab_is_text(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("MATLAB 7 log of the cart\n" + TABLE, encoding="utf-8")
    assert stepid.draft_campaign(tmp_path / "run.csv").runs[0].columns["position"] == "x (mm)"
