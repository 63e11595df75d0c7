"""Kill a process (SIGKILL) at random moments while it saves a result or writes a report, and look what is left.

    python benchmarks/kills.py            200 kills of each: saving, writing the folder of a report, making the report
    python benchmarks/kills.py --kills 20

Every file has to be whole after each kill; after the next run there is one generation and nothing left over.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

import stepid
from stepid.core.atomic_write import staged
from stepid.report.provenance import of_diagnosis
from stepid.report.write import write_all

GOLDEN = Path(__file__).parents[1] / "tests" / "golden" / f"saved-{stepid.__version__}"
Write = Callable[[Path, int], object]
Generation = Callable[[Path], int]  # of a file; raises where it is not whole


@dataclass
class Tally:
    """What was seen after the kills."""

    kills: int = 0
    broken: int = 0  # files that were not whole
    mixed: int = 0  # kills that left files of two generations, until the next run
    leftovers: int = 0  # kills that left a scratch folder, until the next run
    wrong: list[str] = field(default_factory=list)  # after the next run


def save_result(out: Path, generation: int) -> Path:
    """Save a fit that says which generation it is."""
    fit = stepid.load(GOLDEN / "fit.json", kind=stepid.Fit)
    return fit.model_copy(update={"notes": (f"generation {generation}",)}).save(out / "fit.json")


def saved_generation(path: Path) -> int:
    return int(stepid.load(path, kind=stepid.Fit).notes[0].split()[1])


def report_files() -> dict[str, bytes]:
    """The files of a real report."""
    d = stepid.load(GOLDEN / "diagnosis.json", kind=stepid.Diagnosis)
    with TemporaryDirectory() as folder:
        write_all(d, of_diagnosis(d), Path(folder))
        return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def write_folder(files: Mapping[str, bytes]) -> Write:
    """Write the files of a report, each with its generation and a hash at its end."""

    def write(out: Path, generation: int) -> None:
        with staged(out) as folder:
            for name, content in files.items():
                told = content + f"\n{name} {generation}".encode()
                (folder / name).write_bytes(told + b" " + hashlib.sha256(told).hexdigest().encode())

    return write


def folder_generation(path: Path) -> int:
    told, _, digest = path.read_bytes().rpartition(b" ")
    if hashlib.sha256(told).hexdigest().encode() != digest:
        raise ValueError(f"{path.name} is not whole")
    return int(told.rpartition(b" ")[2])


def make_report(out: Path, generation: int) -> None:
    """Make a report from its diagnosis, whose first note says which generation it is."""
    d = stepid.load(GOLDEN / "diagnosis.json", kind=stepid.Diagnosis)
    d = d.model_copy(update={"notes": (f"generation={generation};",)})
    with staged(out) as folder:
        write_all(d, of_diagnosis(d), folder)
        for path in folder.glob("*.p*"):
            with path.open("ab") as file:
                file.write(f"generation={generation};".encode())


def made_generation(path: Path) -> int:
    content = path.read_bytes()
    if path.suffix == ".html" and not content.rstrip().endswith(b"</html>"):
        raise ValueError(f"{path.name} is not whole")
    return int(content.replace(b"\\=", b"=").rpartition(b"generation=")[2].partition(b";")[0])


def killed(write: Write, out: Path, generations: Iterator[int], after: float) -> None:
    """Let a child write generation after generation, and kill it."""
    ready, begun = os.pipe()
    child = os.fork()
    if child == 0:
        os.write(begun, b"x")
        for generation in generations:
            write(out, generation)
    os.read(ready, 1)
    os.close(ready)
    os.close(begun)
    time.sleep(after)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def kill(write: Write, generation_of: Generation, *, kills: int, seed: int = 14) -> Tally:
    """Kill, look, run again, look."""
    draw, tally = random.Random(seed), Tally()
    with TemporaryDirectory() as folder:
        out = Path(folder)
        began = time.perf_counter()
        write(out, 0)
        write(out, 1)
        lasts = time.perf_counter() - began
        names = {path.name for path in out.iterdir()}
        for number in range(1, kills + 1):
            killed(write, out, count(1000 * number), draw.uniform(0, 1.5 * lasts))
            found = set()
            for name in names:
                try:
                    found.add(generation_of(out / name))
                except (ValueError, OSError) as error:
                    tally.broken += 1
                    tally.wrong.append(f"kill {number}: {error}")
            tally.mixed += len(found) > 1
            tally.leftovers += any(path.name not in names for path in out.iterdir())
            write(out, -number)
            after = {path.name: generation_of(out / path.name) for path in out.iterdir() if path.name in names}
            if after != dict.fromkeys(names, -number) or {path.name for path in out.iterdir()} != names:
                tally.wrong.append(f"after kill {number}: {sorted(path.name for path in out.iterdir())}, {after}")
            tally.kills += 1
    return tally


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--made", type=int, default=None, help="kills while a report is made, seconds each")
    given = parser.parse_args()
    made = given.kills if given.made is None else given.made
    print("saving:", kill(save_result, saved_generation, kills=given.kills))
    print("writing the folder of a report:", kill(write_folder(report_files()), folder_generation, kills=given.kills))
    print("making a report:", kill(make_report, made_generation, kills=made))


if __name__ == "__main__":
    main()
