"""Folders as labs leave them, made by a script: names, units, separators, decimal marks, encodings, preambles."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.random import Generator

import exports
from lab_words import HELD_OUT, PRACTICE, Words

POSITION = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "in": 0.0254, "deg": np.pi / 180, "counts": None}
TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
INPUT = {"V": 1.0, "mV": 1e-3, "N": 1.0, "A": 1.0}
COUNTS_PER_METER = 56000.0


@dataclass
class Truth:
    """What is true of one run, and how the script wrote it."""

    file: str
    time: np.ndarray  # as written
    position: np.ndarray
    input: np.ndarray | None
    time_unit: str
    position_unit: str
    input_unit: str
    encoding: str = "utf-8"
    delimiter: str = ","
    decimal: str = "."
    mass: float | None = None  # kg, None where nothing says it
    weights: int | None = None
    spring: str | None = None
    said: set[str] = field(default_factory=set)  # units that the files tell
    real_mass: float = 0.0
    level: float = 0.5
    sheet: str | None = None
    format: str = "table"
    sample_time: float | None = None  # s, where no column has the times
    position_scale: float | None = None  # of counts, where a line above tells it

    @property
    def scale(self) -> float:
        """m, or rad, per unit of the position."""
        return self.position_scale or POSITION[self.position_unit] or 1 / COUNTS_PER_METER

    @property
    def seconds(self) -> np.ndarray:
        """Times in s."""
        return self.time * TIME[self.time_unit]


def make_folder(folder: Path, seed: int, *, held_out: bool = False) -> list[Truth]:
    """Write a folder of recordings; the same seed makes the same."""
    rng = np.random.default_rng([seed, 15 + held_out])
    words = HELD_OUT if held_out else PRACTICE
    folder.mkdir(parents=True, exist_ok=True)
    kind = rng.choice(["files", "files", "files", "side", "side", "ecp", "xlsx"])
    runs = _runs(rng, kind)
    _name(rng, runs, words, kind)
    if kind == "ecp":
        _write_exports(rng, folder, runs)
    else:
        _write_tables(rng, folder, runs, words, kind)
    return runs


def _runs(rng: Generator, kind: str) -> list[Truth]:
    """Step responses of one plant (closed form) at several masses, in the units of the lab."""
    base, stiffness, damping = rng.uniform(0.6, 1.8), rng.uniform(150, 500), rng.uniform(2, 6)
    level, gain = float(rng.choice([0.5, 1.0, 2.0, 3.0])), rng.uniform(3, 9)
    masses = [0.5 * i for i in range(int(rng.integers(3, 5)))]
    step = float(rng.choice([0.005, 0.01, 0.008]))
    n, quiet = int(rng.integers(240, 420)), int(rng.integers(0, 30))
    t_unit = str(rng.choice(["s", "s", "ms", "us"]))
    x_unit = "counts" if kind == "ecp" else str(rng.choice(["mm", "mm", "cm", "m", "um", "deg", "counts"]))
    u_unit = str(rng.choice(["V", "V", "V", "mV", "N"])) if kind != "ecp" else "V"
    out = []
    for mass in masses:
        t = step * np.arange(n)
        s = np.maximum(t - step * quiet, 0)
        m = base + mass
        wn, zeta = np.sqrt(stiffness / m), damping / 2 / np.sqrt(stiffness * m)
        wd = wn * np.sqrt(1 - zeta**2)
        x = gain * level / stiffness * (1 - np.exp(-zeta * wn * s) * (np.cos(wd * s) + zeta * wn / wd * np.sin(wd * s)))
        u = np.where(np.arange(n) >= quiet, level, 0.0)
        scale = POSITION[x_unit] or 1 / COUNTS_PER_METER
        written = np.round(x / scale + rng.normal(0, 1e-5 / scale, n), 0 if x_unit == "counts" else 6)
        out.append(
            Truth("", t / TIME[t_unit], written, u / INPUT[u_unit], t_unit, x_unit, u_unit, real_mass=mass, level=level)
        )
    return out


def _name(rng: Generator, runs: list[Truth], words: Words, kind: str) -> None:
    """Names of files, of which some tell masses and springs."""
    style = str(rng.choice(["mass", "mass", "weights", "plain"]))
    pool = {"mass": words.mass_files, "weights": words.weight_files, "plain": words.plain_files}[style]
    pattern = str(rng.choice(pool))
    spring = words.springs[int(rng.integers(len(words.springs)))] if rng.random() < 0.3 else None
    for i, run in enumerate(runs, 1):
        mass = f"{run.real_mass:g}"
        if rng.random() < 0.0:
            mass = mass.replace(".", "p")
        stem = pattern.format(m=mass, g=f"{1000 * run.real_mass:g}", n=i - 1, i=i)
        if spring and kind in ("files", "ecp"):
            stem, run.spring = f"{spring[0]}_{stem}", spring[1]
        if style == "mass":
            run.mass = run.real_mass
        elif style == "weights":
            run.weights = i - 1
        run.file = stem
    if kind in ("side", "xlsx"):  # one file for all: its name tells no mass
        for run in runs:
            run.file, run.mass, run.weights = "all_runs", None, None


def _write_exports(rng: Generator, folder: Path, runs: list[Truth]) -> None:
    for run in runs:
        period = exports.PERIOD
        n = run.time.size
        run.file, run.format, run.said = f"{run.file}.txt", "ecp", {"time", "input"}
        counts = run.position
        data = {"s": np.arange(n), "t": np.arange(n) * period, "c": counts, "1": counts, "u": run.input}
        data["c"] = np.concatenate(([counts[0]], np.rint(0.6 * counts[1:] + 0.4 * counts[:-1])))
        run.time, run.time_unit = np.arange(n) * period, "s"
        exports.write(folder / run.file, exports.export_bytes("stc1u", rows=exports.rows_of(data)))


def _titled(name: str, unit: str, style: str) -> str:
    return style.format(name=name, unit=unit) if style else name


def _write_tables(rng: Generator, folder: Path, runs: list[Truth], words: Words, kind: str) -> None:
    name = {role: str(rng.choice(getattr(words, role))) for role in ("time", "position", "input")}
    said = str(rng.choice(["header", "header", "header", "row", "preamble", "partly"]))
    style = str(rng.choice(words.unit_styles)) if said in ("header", "partly") else ""
    with_input = bool(rng.random() < 0.8)
    beside = [str(rng.choice(words.beside))] if rng.random() < 0.4 and kind == "files" else []
    encoding = str(rng.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "cp1252"]))
    decimal = str(rng.choice([".", ".", ","]))
    delimiter = str(rng.choice([";", "\t"] if decimal == "," else [",", ";", "\t", " "]))
    if delimiter == " ":
        name = {role: text.replace(" ", "_") for role, text in name.items()}
        style = "{name}_{unit}" if style else ""
    lines = [str(line) for line in rng.permutation(words.preamble)[: int(rng.choice([0, 0, 2, 4]))]]
    mass_line = (
        str(rng.choice(words.mass_line)) if kind == "files" and rng.random() < 0.4 and not runs[0].weights else ""
    )
    if any(run.weights is not None for run in runs):
        mass_line = ""
    first = runs[0]
    units = {"time": first.time_unit, "position": first.position_unit, "input": first.input_unit}
    roles = ["time", "position"] + (["input"] if with_input else [])
    told = {"time", "position", "input"} if said != "partly" else {"position"}
    if said == "preamble":
        lines += [f"{name[role]}: {units[role]}" for role in roles]
    for run in runs:
        run.encoding, run.delimiter, run.decimal = encoding, delimiter, decimal
        run.said = {role for role in roles if role in told}
        if not with_input:
            run.input = None

    def title(role: str) -> str:
        return _titled(name[role], units[role], style if role in told else "")

    if kind == "files":
        for run in runs:
            top = list(lines)
            if mass_line:
                text = mass_line.format(m=f"{run.real_mass:g}".replace(".", decimal), g=f"{1000 * run.real_mass:g}")
                top, run.mass = [*top, text], run.real_mass
            run.file += str(rng.choice([".csv", ".txt"]))
            heads = [title(role) for role in roles]
            columns = [getattr(run, role) for role in roles]
            for extra in beside:
                heads.append(extra)
                columns.append(_extra(extra, run))
            second = [units[role] for role in roles] + [""] * len(beside) if said == "row" else None
            _write_text(folder / run.file, top, heads, second, columns, run)
        return
    pattern = str(rng.choice(words.side_styles))
    if delimiter == " ":
        pattern = "{name}{i}"
    heads, columns, second = [title("time")], [first.time], [units["time"]]
    for i, run in enumerate(runs, 1):
        short = len(run.position) - 20 * (i - 1)
        run.time, run.position = run.time[:short], run.position[:short]
        run.input = None if run.input is None else run.input[:short]
        run.file = "all_runs" + (".xlsx" if kind == "xlsx" else ".csv")
        for role in roles[1:]:
            bare = pattern.format(name=name[role], i=i)
            heads.append(_titled(bare, units[role], style if role in told else ""))
            columns.append(getattr(run, role))
            second.append(units[role])
    below = second if said == "row" else None
    if kind == "xlsx":
        for run in runs:
            run.encoding, run.delimiter, run.decimal = "xlsx", "\t", "."
        write_workbook(folder / "all_runs.xlsx", [[line] for line in lines], heads, below, columns)
    elif delimiter == " ":  # blanks cannot leave a cell empty
        shortest = min(c.size for c in columns)
        for run in runs:
            run.time, run.position = run.time[:shortest], run.position[:shortest]
            run.input = None if run.input is None else run.input[:shortest]
        _write_text(folder / "all_runs.csv", lines, heads, below, [c[:shortest] for c in columns], first)
    else:
        _write_text(folder / "all_runs.csv", lines, heads, below, columns, first)


def _extra(name: str, run: Truth) -> np.ndarray | list[str]:
    n = run.position.size
    if name in ("n", "sample"):
        return np.arange(n, dtype=float)
    if name in ("status", "Kommentar", "comment"):
        return ["ok" if i % 50 else "" for i in range(n)]
    if name in ("setpoint", "reference"):
        return np.zeros(n)
    return np.round(np.gradient(run.position, 0.01), 4)


def _cell(value: object, decimal: str) -> str:
    return value if isinstance(value, str) else f"{value:.10g}".replace(".", decimal)


def _write_text(
    path: Path, top: list[str], heads: list[str], below: list[str] | None, columns: list, run: Truth
) -> None:
    longest = max(len(c) for c in columns)
    rows = [[_cell(c[i], run.decimal) if i < len(c) else "" for c in columns] for i in range(longest)]
    if run.delimiter == " ":
        rows = [[cell or "-" for cell in row] for row in rows]
        heads = [head.replace(" ", "_") for head in heads]
        below = below and [unit or "-" for unit in below]
    lines = [*top, run.delimiter.join(heads), *([run.delimiter.join(below)] if below else [])]
    text = "\r\n".join([*lines, *(run.delimiter.join(row) for row in rows)]) + "\r\n"
    path.write_bytes(text.encode(run.encoding, errors="replace"))


def write_workbook(path: Path, top: list[list[str]], heads: list[str], below: list[str] | None, columns: list) -> None:
    """A workbook of one sheet as spreadsheets write it, with shared strings."""
    shared: list[str] = []

    def cell(value: object, row: int, column: int) -> str:
        place = f"{chr(65 + column)}{row}"
        if isinstance(value, str):
            shared.append(value)
            return f'<c r="{place}" t="s"><v>{len(shared) - 1}</v></c>'
        return f'<c r="{place}"><v>{value:.10g}</v></c>'

    longest = max(len(c) for c in columns)
    grid: list[dict[int, object]] = [dict(enumerate(line)) for line in (*top, heads, *([below] if below else []))]
    grid += [{j: c[i] for j, c in enumerate(columns) if i < len(c)} for i in range(longest)]
    rows = "".join(
        f'<row r="{i}">{"".join(cell(v, i, j) for j, v in row.items())}</row>' for i, row in enumerate(grid, 1)
    )
    space = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
    links = 'xmlns:r="http://schemas.openxmlformats.org/officeDocument/2006/relationships"'
    package = "http://schemas.openxmlformats.org/package/2006/relationships"
    escaped = [s.replace("&", "&amp;").replace("<", "&lt;") for s in shared]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr(
            "xl/workbook.xml",
            f'<workbook {space} {links}><sheets><sheet name="Tabelle1" sheetId="1" r:id="rId1"/></sheets></workbook>',
        )
        book.writestr(
            "xl/_rels/workbook.xml.rels",
            f'<Relationships xmlns="{package}"><Relationship Id="rId1" Type="{links[9:-1]}/worksheet" '
            'Target="worksheets/sheet1.xml"/></Relationships>',
        )
        book.writestr("xl/sharedStrings.xml", f"<sst {space}>{''.join(f'<si><t>{s}</t></si>' for s in escaped)}</sst>")
        book.writestr("xl/worksheets/sheet1.xml", f"<worksheet {space}><sheetData>{rows}</sheetData></worksheet>")
