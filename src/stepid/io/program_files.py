"""Files in formats of programs, told by how they begin: what each is, and how it becomes text."""

from __future__ import annotations

from pathlib import Path

from stepid.errors import InputError

_BEGINS = (
    (b"MATLAB 5.0 MAT-file", "MATLAB"),
    (b"MATLAB 7.3 MAT-file", "MATLAB"),
    (b"\x89HDF\r\n\x1a\n", "HDF5"),
    (b"\x93NUMPY", "NumPy"),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "Excel"),
    (b"TDSm", "LabVIEW"),
)
_KINDS = {
    "MATLAB": (
        "a MATLAB file (.mat)",
        'Save its columns as CSV in MATLAB: writematrix([t x u], "run.csv"), or writetable to keep their names.',
    ),
    "HDF5": ("an HDF5 file", "Save its columns as CSV."),
    "NumPy": ("a NumPy file (.npy)", 'Save its columns as CSV: numpy.savetxt("run.csv", columns, delimiter=",").'),
    "Excel": ("a workbook of an old Excel (.xls)", "Save it as .xlsx or CSV."),
    "LabVIEW": ("a LabVIEW file (.tdms)", "Save its channels as text (.lvm) or CSV."),
}


class ProgramFileError(InputError):
    """A file is in a binary format of a program."""


def check_no_program_file(path: Path, begin: bytes) -> None:
    """Refuse a file in a format of a program by its first bytes; ProgramFileError tells the program and the way out."""
    kind = next((kind for mark, kind in _BEGINS if begin.startswith(mark)), None)
    if kind is None and path.suffix.lower() == ".mat" and b"\0" in begin:  # version 4 begins with numbers
        kind = "MATLAB"
    if kind is not None:
        words, remedy = _KINDS[kind]
        raise ProgramFileError(f"{path}: is {words}, and no text", remedy)
