"""Mutated inputs to the readers: structure-aware, and guided by coverage where atheris is installed.

python benchmarks/fuzz_readers.py CASES [SEED]       mutations of good files of every kind
python benchmarks/fuzz_readers.py atheris RUNS KIND  libFuzzer, from the same files
"""

from __future__ import annotations

import atexit
import random
import shutil
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path

TESTS = Path(__file__).parent.parent / "tests"
sys.path[:0] = [str(TESTS), str(TESTS / "io")]

import test_bad_input_fuzz as acts  # noqa: E402

import stepid  # noqa: E402
from exports import export_bytes, write  # noqa: E402
from stepid.errors import StepidError  # noqa: E402

SLOWEST = 5.0  # s
COLUMNS = {"time": "t", "position": "x", "input": "u"}
SIDE = "t;x1;x2;u\n" + "".join(f"{0.01 * i:.2f};{i % 7 / 100};{i % 5 / 100};{0.5 * (i > 5)}\n" for i in range(acts.N))
LONG = "t,x,u\n" + "".join(f"{0.01 * i:.2f},{i % 7 / 100},{0.5 * (i > 5)}\n" for i in range(150))
COMMAS = "# a logger\nt\tx\tu\n" + LONG.partition("\n")[2].replace(",", "\t").replace(".", ",")
Read = Callable[[Path], object]
KINDS: dict[str, tuple[str, bytes, Read]] = {
    **acts.KINDS,
    "long table": ("a.csv", LONG.encode(), lambda p: stepid.read_table(p, **COLUMNS)),
    "decimal commas": ("a.csv", COMMAS.encode(), lambda p: stepid.read_table(p, **COLUMNS, decimal=",")),
    "side by side": ("a.csv", SIDE.encode(), lambda p: stepid.read_tables(p, time="t", position="x", input="u")),
    "no header": (
        "a.txt",
        LONG.partition("\n")[2].replace(",", " ").encode(),
        lambda p: stepid.read_table(p, time=0, position=1, skiprows=2),
    ),
    "tabbed": (
        "a.txt",
        export_bytes(n=acts.N).replace(b"  ", b"\t"),
        lambda p: stepid.read_ecp(p, counts_per_meter=acts.SCALE, effort_scale=1.0),
    ),
    "submission": (
        "a.json",
        b'{"group": "A", "effects": ["coulomb_friction"], "parameters": {"base_mass": '
        b'{"value": 0.95, "uncertainty": 0.01, "unit": "kg"}}, "alternatives": [["free_play"]]}',
        stepid.lab.read_submission,
    ),
}


def prepared(folder: Path, kind: str) -> tuple[Path, bytes, Read]:
    """A good file in a folder with those that manifests name."""
    name, good, read = KINDS[kind]
    write(folder / "case4.txt", export_bytes(n=acts.N))
    write(folder / "run.csv", acts.TABLE)
    return folder / name, good, read


def once(file: Path, raw: bytes, read: Read) -> str:
    """Read one mutated file; return how it ended."""
    file.write_bytes(raw)
    began = time.process_time()
    try:
        read(file)
        end = "read"
    except StepidError as error:
        end = "refused" if error.cause and error.remedy else f"mute: {error!r}"
    except Exception:
        end = "foreign: " + traceback.format_exc(limit=-2)
    took = time.process_time() - began
    return f"{took:.1f} s" if took > SLOWEST else end


def mutated(cases: int, seed: int) -> None:
    """Mutate files of each kind alike often, each time a good one or the last that was read in spite of it."""
    ends: Counter[str] = Counter()
    bad = Path(tempfile.gettempdir()) / f"stepid-bad-{seed}"
    for kind in KINDS:
        with tempfile.TemporaryDirectory() as scratch:
            file, good, read = prepared(Path(scratch), kind)
            assert once(file, good, read) == "read", kind
            rng = random.Random(f"{kind} {seed}")
            raw, here = good, Counter[str]()
            for i in range(cases // len(KINDS)):
                raw = acts.corrupt(raw if rng.random() < 0.3 and len(raw) < 5 * len(good) else good, rng)
                end = once(file, raw, read)
                here[end.split("\n")[0] if end in ("read", "refused") else "bad"] += 1
                if end not in ("read", "refused"):
                    bad.mkdir(exist_ok=True)
                    (bad / f"{kind}-{i}").write_bytes(raw)
                    print(kind, i, end, flush=True)
                if end != "read":
                    raw = good
            print(kind, dict(here), flush=True)
            ends += here
    print(f"{ends.total()} cases: {dict(ends)}, {time.process_time():.0f} s CPU")


def guided(runs: int, kind: str) -> None:
    """Let libFuzzer look for new paths through a reader."""
    import atheris

    with atheris.instrument_imports(include=["stepid.io", "tomllib"]):
        pass
    for name, module in list(sys.modules.items()):
        if name.startswith(("stepid.io.", "tomllib")) and hasattr(module, "__file__"):
            for key, value in vars(module).items():
                if callable(value) and getattr(value, "__module__", "") == name and hasattr(value, "__code__"):
                    setattr(module, key, atheris.instrument_func(value))
    folder = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    (folder / "in").mkdir()
    file, good, read = prepared(folder, kind)
    (folder / "corpus").mkdir()
    (folder / "corpus" / "good").write_bytes(good)
    ends: Counter[str] = Counter()

    def target(raw: bytes) -> None:
        end = once(file, raw, read)
        ends[end if end in ("read", "refused") else "bad"] += 1
        if end not in ("read", "refused"):
            raise RuntimeError(end)
        if ends.total() == runs:
            print(f"{kind}: {ends.total()} runs guided by coverage: {dict(ends)}", flush=True)

    atheris.Setup(["fuzz", f"-runs={runs}", "-max_len=4000", "-timeout=5", "-seed=1", str(folder / "corpus")], target)
    atheris.Fuzz()


if __name__ == "__main__":
    if sys.argv[1] == "atheris":
        guided(int(sys.argv[2]), sys.argv[3])
    else:
        mutated(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1)
