"""CPU time and memory of reading large tables and identifying from them: four runs of 2.5·10⁶ samples.

    python benchmarks/large_tables.py [--samples 2500000] [--folder FOLDER]

Writes four tables of time, position and volts (60 MB each; steps of the paper's plant, 20 µm of white noise), reads
them and calls `stepid.identify` in a process of its own. Memory is the largest resident set of that process above its
own after the imports; the folder is kept, and its tables are used again, where it is named.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

BASE, K, C, REACH, SECONDS = 0.95, 216.0, 12.0, 0.018, 6.0  # kg, N/m, N s/m, m, s
WEIGHTS = (0.0, 0.5, 1.0, 1.5)  # kg
LINES = 100_000  # written at once
CPU, MEMORY = 20.0, 10.0  # asked: s, bytes for each byte of the files


def write(file: Path, samples: int, added: float, seed: int) -> None:
    """One run: the step comes after a hundredth of the record."""
    period = SECONDS / samples
    rng = np.random.default_rng(seed)
    mass = BASE + added
    rate, ratio = np.sqrt(K / mass), C / (2 * np.sqrt(K * mass))
    root = np.sqrt(1 - ratio**2)
    with file.open("w", encoding="ascii", newline="") as out:
        out.write("time,position,volts\n")
        for first in range(0, samples, LINES):
            t = period * np.arange(first, min(first + LINES, samples))
            since = np.maximum(t - SECONDS / 100, 0.0)
            phase = rate * root * since
            x = REACH * (1 - np.exp(-ratio * rate * since) * (np.cos(phase) + ratio / root * np.sin(phase)))
            x += 20e-6 * rng.standard_normal(t.size)
            rows = np.column_stack([t, x, 0.5 * (t >= SECONDS / 100)])
            out.write("%.7f,%.7f,%.1f\n" * t.size % tuple(rows.ravel().tolist()))


def resident() -> int:
    """Bytes that this process had at most."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def measure(files: list[Path]) -> None:
    import stepid
    import stepid.identification.identify
    import stepid.io.table

    before, began = resident(), time.process_time()
    runs = [
        stepid.read_table(
            file, time="time", position="position", input="volts", added_mass=added, spring="medium", damper="plug"
        )
        for file, added in zip(files, WEIGHTS, strict=True)
    ]
    read = time.process_time() - began
    found = stepid.identify(stepid.Campaign(name="large", experiments=runs))
    spent, held = time.process_time() - began, resident() - before
    size = sum(file.stat().st_size for file in files)
    mass, sure = found.masses[runs[0].name], found.uncertainty.masses[runs[0].name]
    print(f"{len(files)} runs of {runs[0].time.size} samples, {size / 1e6:.0f} MB of tables")
    print(f"CPU: {read:.1f} s to read, {spent:.1f} s in all (asked: {CPU:g})")
    print(f"memory: {held / 1e6:.0f} MB, {held / size:.1f} bytes a byte of the files (asked: {MEMORY:g})")
    print(f"base mass {mass:.4f} ± {sure:.4f} kg, the truth is {BASE:g}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=2_500_000)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--write", type=Path, nargs="*", help=argparse.SUPPRESS)
    parser.add_argument("--read", type=Path, nargs="*", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.write or given.read:
        for i, file in enumerate(given.write or ()):
            if not file.exists():
                write(file, given.samples, WEIGHTS[i], i)
        if given.read:
            measure(given.read)
        return
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.folder or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        files = [folder / f"run{i}-{given.samples}.csv" for i in range(len(WEIGHTS))]
        # processes of their own: the most that one held is passed on to those that it starts
        again = [sys.executable, __file__, "--samples", str(given.samples)]
        subprocess.run([*again, "--write", *map(str, files)], check=True)
        subprocess.run([*again, "--read", *map(str, files)], check=True)


if __name__ == "__main__":
    main()
