"""Ten more folders as labs leave them, each in a style of its own; written before it was seen what becomes of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.random import Generator

from lab_folders import POSITION, TIME, Truth, write_workbook

SEED = 4077
PER_REVOLUTION = 16000
_Style = Callable[[Generator, Path, list[Truth]], list[Truth]]


def make_styled_folder(folder: Path, number: int) -> list[Truth]:
    """Write the folder of a number from 0 to 9."""
    rng = np.random.default_rng([number, SEED])
    folder.mkdir(parents=True, exist_ok=True)
    return STYLES[number](rng, folder, _runs(rng))


def _runs(rng: Generator) -> list[Truth]:
    """Step responses of one plant (closed form), in s, mm and V."""
    base, stiffness, damping = rng.uniform(0.6, 1.8), rng.uniform(150, 500), rng.uniform(2, 6)
    level, gain, step = float(rng.choice([1.0, 2.0, 3.0])), rng.uniform(3, 9), float(rng.choice([0.005, 0.01]))
    quiet, n = int(rng.integers(5, 30)), int(rng.integers(260, 420))
    out = []
    for mass in (0.5 * i for i in range(int(rng.integers(3, 5)))):
        t = step * np.arange(n)
        s, m = np.maximum(t - step * quiet, 0), base + mass
        wn, zeta = np.sqrt(stiffness / m), damping / 2 / np.sqrt(stiffness * m)
        wd = wn * np.sqrt(1 - zeta**2)
        shape = 1 - np.exp(-zeta * wn * s) * (np.cos(wd * s) + zeta * wn / wd * np.sin(wd * s))
        x = gain * level / stiffness * shape + rng.normal(0, 1e-5, n)
        u = np.where(np.arange(n) >= quiet, level, 0.0)
        out.append(Truth("", t, 1e3 * x, u, "s", "mm", "V", real_mass=mass, level=level))
    return out


def _in(run: Truth, *, position: str = "mm", time: str = "s", digits: int = 6) -> Truth:
    """The same run in other units."""
    scale = POSITION[position]
    assert scale is not None
    return replace(
        run,
        time=np.round(run.time / TIME[time], 9),
        time_unit=time,
        position=np.round(1e-3 * run.position / scale, digits),
        position_unit=position,
    )


def _write(path: Path, lines: Sequence[str], run: Truth) -> Truth:
    path.write_bytes(("\r\n".join(lines) + "\r\n").encode(run.encoding))
    return replace(run, file=path.name)


def _rows(columns: Sequence[np.ndarray], delimiter: str, decimal: str = ".", form: str = "{:.9g}") -> list[str]:
    return [delimiter.join(form.format(v).replace(".", decimal) for v in row) for row in zip(*columns, strict=True)]


def _workbook(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """A workbook a run, units in a second line below the names, a title above."""
    names = ["Time", "Cart position", "Motor command"]
    out = []
    for run in runs:
        mine = _in(run, position=str(rng.choice(["mm", "cm"])))
        mine = replace(mine, file=f"Group 4 - {run.real_mass:g} kg added.xlsx", mass=run.real_mass, encoding="xlsx")
        top = [["Mass-spring-damper, week 6"], ["Recorded by A. Student"]]
        columns = [mine.time, mine.position, mine.input]
        write_workbook(folder / mine.file, top, names, ["s", mine.position_unit, "V"], columns)
        out.append(mine)
    return out


def _german(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """UTF-16 with semicolons and decimal commas."""
    out = []
    for i, run in enumerate(runs, 1):
        mine = replace(
            _in(run, time=str(rng.choice(["s", "ms"]))), encoding="utf-16", delimiter=";", decimal=",",
            mass=run.real_mass,
        )  # fmt: skip
        mass = f"{run.real_mass:g}".replace(".", ",")
        top = [
            "Praktikum Regelungstechnik",
            f"Zusatzmasse;{mass} kg",
            "",
            f"Zeit [{mine.time_unit}];Weg [mm];Spannung [V]",
        ]
        rows = _rows([mine.time, mine.position, mine.input], ";", ",")
        out.append(_write(folder / f"Messreihe{i}.csv", [*top, *rows], mine))
    return out


def _labview(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """LabVIEW's own text files: two headers, no column of times."""
    out = []
    for run in runs:
        n, step = run.time.size, float(run.time[1])
        mine = replace(_in(run), sample_time=step, delimiter="\t", mass=run.real_mass)
        top = [
            "LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab",
            "Decimal_Separator\t.", "Multi_Headings\tYes", "X_Columns\tNo", "Time_Pref\tRelative", "Operator\tstudent",
            "Date\t2014/03/11", "Time\t10:22:51.1234567", "***End_of_Header***\t", "\t", "Channels\t2\t\t",
            f"Samples\t{n}\t{n}\t", "Date\t2014/03/11\t2014/03/11\t", "Time\t10:22:51.1234567\t10:22:51.1234567\t",
            "Y_Unit_Label\tMillimeters\tVolts\t", "X_Dimension\tTime\tTime\t", "X0\t0.0000000000E+0\t0.0000000000E+0\t",
            f"Delta_X\t{step:.6f}\t{step:.6f}\t", "***End_of_Header***\t\t\t",
            f"X_Value\t{rng.choice(['Position', 'Displacement'])}\tVoltage\tComment",
        ]  # fmt: skip
        rows = [f"\t{row}\t" for row in _rows([mine.position, mine.input], "\t", form="{:.6f}")]
        out.append(_write(folder / f"test_{1000 * run.real_mass:g}g.lvm", [*top, *rows], mine))
    return out


def _matlab(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """Numbers alone, as `writematrix` leaves them: time, input, position."""
    position, digits = ("m", 9) if rng.random() < 0.5 else ("mm", 6)
    out = []
    for run in runs:
        mine = replace(_in(run, position=position, digits=digits), mass=run.real_mass)
        mass = f"{run.real_mass:g}".replace(".", "p")
        rows = _rows([mine.time, mine.input, mine.position], ",", form="{:.15g}")
        out.append(_write(folder / f"resp_{mass}kg.csv", rows, mine))
    return out


def _arduino(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """What a serial monitor showed, from the boot on; no column of the input."""
    out = []
    for i, run in enumerate(runs):
        mine = replace(_in(run, time="ms", digits=3), input=None, weights=i)
        top = ["ESP32 booting...", "AS5600 found", f"loop at {1 / run.time[1]:g} Hz", "t_ms,pos_mm"]
        rows = _rows([mine.time, mine.position], ",", form="{:.10g}")
        out.append(_write(folder / f"serial_{i}_weights.log.txt", [*top, *rows, "# stopped"], mine))
    return out


def _no_time(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """No column of times; a line above tells the rate."""
    delimiter = str(rng.choice([",", "\t"]))
    out = []
    for i, run in enumerate(runs, 1):
        rate = 1 / float(run.time[1])
        mine = replace(_in(run, position="cm"), sample_time=float(run.time[1]), delimiter=delimiter)
        top = ["Rig 3", f"Sampling frequency = {rate:g} Hz", "", f"cart position (cm){delimiter}motor (V)"]
        rows = _rows([mine.position, mine.input], delimiter)
        out.append(_write(folder / f"group7-{i}.txt", [*top, *rows], mine))
    return out


def _inches(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """Every cell in quotes, lengths in inches."""
    out = []
    for run in runs:
        mine = replace(_in(run, position="in"), mass=run.real_mass)
        head = ["Latest: Time (s)", "Latest: Displacement (in)", "Latest: Potential (V)"]
        rows = [
            ",".join(f'"{cell}"' for cell in row.split(","))
            for row in _rows([mine.time, mine.position, mine.input], ",")
        ]
        title = ",".join(f'"{name}"' for name in head)
        out.append(_write(folder / f"Run with {1000 * run.real_mass:g} g.csv", [title, *rows], mine))
    return out


def _micrometers(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """Quantity over unit, in the letters of Western Europe."""
    spring = str(rng.choice(["soft", "stiff"]))
    out = []
    for run in runs:
        mine = replace(
            _in(run, position="µm", digits=2), encoding="cp1252", delimiter="\t", decimal=",", mass=run.real_mass,
            spring=spring,
        )  # fmt: skip
        rows = _rows([mine.time, mine.position, mine.input], "\t", ",")
        mass = f"{run.real_mass:g}".replace(".", ",")
        out.append(_write(folder / f"{spring} {mass} kg.dat", ["t/s\ts/µm\tU/V", *rows], mine))
    return out


def _turning(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """A disk whose encoder is told in counts a revolution."""
    out = []
    for i, run in enumerate(runs, 1):
        counts = np.round(1e-3 * run.position * 20 * PER_REVOLUTION / (2 * np.pi))
        mine = replace(run, position=counts, position_unit="counts", position_scale=2 * np.pi / PER_REVOLUTION)
        top = [
            f"# encoder: {PER_REVOLUTION} counts/rev",
            f"# torsion disk, trial {i}",
            "time [s],encoder [counts],motor [V]",
        ]
        out.append(_write(folder / f"disk trial {i}.csv", [*top, *_rows([mine.time, counts, mine.input], ",")], mine))
    return out


def _beside(rng: Generator, folder: Path, runs: list[Truth]) -> list[Truth]:
    """Runs of their own times side by side: run1 t [s], run1 x [mm], run1 u [V], run2 …"""
    delimiter = str(rng.choice([",", ";"]))
    cut = [run.time.size - int(rng.integers(0, 40)) for run in runs]
    mine = []
    for run, n in zip(map(_in, runs), cut, strict=True):
        assert run.input is not None
        mine.append(
            replace(run, time=run.time[:n], position=run.position[:n], input=run.input[:n], delimiter=delimiter)
        )
    heads = [f"run{i} {name}" for i in range(1, len(mine) + 1) for name in ("t [s]", "x [mm]", "u [V]")]
    columns = [c for run in mine for c in (run.time, run.position, run.input)]
    rows = [
        delimiter.join(f"{c[k]:.9g}" if k < c.size else "" for c in columns)  # type: ignore[union-attr]
        for k in range(max(cut))
    ]
    return [_write(folder / "overview.csv", [delimiter.join(heads), *rows], run) for run in mine]


STYLES: tuple[_Style, ...] = (
    _workbook, _german, _labview, _matlab, _arduino, _no_time, _inches, _micrometers, _turning, _beside,
)  # fmt: skip
