"""Mutation testing of the core: mutants drawn by a seed, each run against the tests of its file.

    python benchmarks/mutants.py COUNT [SEED] [PART] [--ran DATA] [--times TEXT --within SECONDS] [--numbers N …] …

PART draws from files whose path holds it only, as diagnosis/verdict; `--lines` from these lines. With DATA of coverage,
a mutant is run against the tests that ran its statement, and no others could tell it. With the TEXT that pytest printed
of their times the quickest are first, as many as take the SECONDS together (a test alone if it takes more):

    printf '[run]\\ndynamic_context = test_function\\n' > contexts.rc
    export COVERAGE_FILE=DATA
    coverage run --rcfile contexts.rc --source stepid -m pytest --durations=0 -vv tests/fitting > TEXT

`--numbers` runs these of the draw alone, `--tests` against these tests: so survivors are run again after new tests.
A mutant is killed where a test fails that passes without it. Where its tests take longer than the patience, so may they
without it: these are run, too, and where they are as slow nothing is known. With CI=1 hypothesis draws the same each
time.
"""

from __future__ import annotations

import argparse
import importlib.abc
import importlib.machinery
import itertools
import os
import re
import signal
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

from mutations import FILES, MORE, ROOT, SOURCE, Mutant, drawn

PATIENCE = 120  # s CPU; who needs longer is in an endless loop
TESTS = {  # of a room, the first to fail most often first; `-x` ends at the first failure
    "identification": ("tests/identification",),
    "fitting": ("tests/fitting", "tests/simulation/test_derivatives.py"),
    "evidence": (
        "tests/diagnosis/test_evidence.py",
        "tests/diagnosis/test_gather_edges.py",
        "tests/diagnosis/test_moves.py",
    ),
    "verdict": ("tests/diagnosis/test_verdict.py", "tests/diagnosis/test_answer.py"),
    "gather": (
        "tests/diagnosis/test_gather.py",
        "tests/diagnosis/test_gather_edges.py",
        "tests/diagnosis/test_verdict.py",
    ),
    "free_law": ("tests/diagnosis/test_free_law.py",),
}


class _Loader(importlib.abc.MetaPathFinder, importlib.machinery.SourceFileLoader):
    """Gives a mutated text where its file is imported."""

    def __init__(self, mutant: Mutant) -> None:
        parts = mutant.file.relative_to(SOURCE.parent).with_suffix("").parts
        importlib.machinery.SourceFileLoader.__init__(self, ".".join(parts), str(mutant.file))
        self.mutant = mutant

    def find_spec(self, name: str, *_: Any) -> Any:
        if name != self.name:
            return None
        return importlib.machinery.ModuleSpec(name, self, origin=str(self.mutant.file))

    def get_code(self, _: str) -> Any:
        return compile(self.mutant.text, str(self.mutant.file), "exec")


class Ran:
    """Which tests ran which lines, as coverage saw it; how long they took."""

    def __init__(self, data: Path, times: Path | None, within: float) -> None:
        from coverage import CoverageData

        self.data = CoverageData(str(data))
        self.data.read()
        self.within = within
        self.seconds: Counter[str] = Counter()
        for line in times.read_text().splitlines() if times else ():
            if told := re.match(r"([\d.]+)s (?:call|setup) +((tests/\S+?\.py)::\w+)", line):
                for name in told.group(2, 3):
                    self.seconds[str(ROOT / name)] += float(told.group(1))  # type: ignore[assignment]

    def quickest(self, tests: list[str]) -> list[str]:
        """The quickest tests, as many as take the given seconds together."""
        if not self.seconds:
            return tests
        ordered = sorted(tests, key=lambda test: self.seconds[test])
        sums = list(itertools.accumulate(self.seconds[test] for test in ordered))
        return [test for test, so_far in zip(ordered, sums, strict=True) if so_far <= max(self.within, sums[0])]

    def tests(self, mutant: Mutant) -> list[str]:
        """Those that ran the statement; of what runs on import, those that ran any line of the file."""
        by_line = self.data.contexts_by_lineno(str(mutant.file))
        some = mutant.statement or by_line
        found = {name for line in some for name in by_line.get(line, ()) if name}
        if not found and any(line in by_line for line in some):  # in fixtures only
            found = {name for names in by_line.values() for name in names if name}
        out = {f"{file}::{name.rpartition('.')[2]}" for name in found if (file := _file_of(name)) is not None}
        if any(_file_of(name) is None for name in found):  # of hypothesis, which calls tests by a name of its own
            rooms = {
                ROOT / room
                for rooms in TESTS.values()
                for room in rooms
                if mutant.file.relative_to(SOURCE).parts[0] in room
            }
            out |= {str(file) for room in rooms for file in room.rglob("test_*.py") if "@given" in file.read_text()}
        return self.quickest(sorted(out, key=lambda test: ("::" not in test, mutant.file.stem not in test, test)))


def _file_of(context: str) -> Path | None:
    file = ROOT.joinpath(*context.split(".")[:-1]).with_suffix(".py")
    return file if file.exists() else None


def tests_of(mutant: Mutant, ran: Ran | None) -> list[str]:
    """Tests of a mutant, those with its file's name first."""
    if ran is not None:
        return ran.tests(mutant)
    file = mutant.file
    rooms = TESTS.get(file.stem) or TESTS[file.relative_to(SOURCE).parts[0]]
    found = [test for room in rooms for test in (sorted((ROOT / room).rglob("test_*.py")) or [ROOT / room])]
    near = [test for test in found if file.stem in test.stem or test.stem.removeprefix("test_") in file.stem]
    return [str(test) for test in dict.fromkeys([*near, *found])]


class Failures:
    """A plugin of pytest that tells which test failed first."""

    def __init__(self, where: int) -> None:
        self.where = where

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            os.write(self.where, report.nodeid.encode())


class Referee:
    """Runs tests against mutants; what fails without one, too, is no proof."""

    def __init__(self) -> None:
        self.clean: dict[str, str] = {}

    def end(self, mutant: Mutant, tests: list[str]) -> str:
        """How a mutant ends: killed, slow (its tests end without it), survived, not run or undecided."""
        if not tests:
            return "not run"
        end, failed = run(mutant, tests)
        if end == "survived":
            return end
        if failed:
            if failed not in self.clean:
                self.clean[failed] = run(None, [failed])[0]
            return f"killed by {failed}" if self.clean[failed] == "survived" else f"undecided {failed}"
        if run(None, tests)[0] != "survived":
            return "undecided"
        return end if end == "slow" else "killed"  # on import


def run(mutant: Mutant | None, tests: list[str]) -> tuple[str, str]:
    """Run tests in a child process; return how it ended, and which test failed."""
    told, tell = os.pipe()
    child = os.fork()
    if child == 0:
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, PATIENCE))
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        if mutant is not None:
            sys.meta_path.insert(0, _Loader(mutant))
        os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # these tests need none
        import pytest

        code = 70
        try:
            quick = ["-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", "--no-header"]
            quick += ["-o", "python_files=test_*.py"]  # pytest itself would load score_test.py, without the change
            code = int(pytest.main([*quick, "-o", "addopts=--import-mode=importlib", *tests], [Failures(tell)]))
        finally:
            os._exit(code)
    os.close(tell)
    _, status = os.waitpid(child, 0)
    with os.fdopen(told, "rb") as pipe:
        failed = pipe.read().decode()
    if os.WIFSIGNALED(status):
        return "slow", ""
    ends = {0: "survived", 1: "killed", 2: "killed"}  # 2: a file of tests could not be imported
    return ends.get(os.WEXITSTATUS(status), "odd"), failed


def load() -> None:
    """What no mutant changes is loaded and compiled once, for all children."""
    for name in ("control", "hypothesis", "pytest", "matplotlib", "numba", "scipy.optimize", "scipy.signal"):
        importlib.import_module(name)
    import stepid
    from stepid.effects import CATALOGUE
    from stepid.simulation.laws import law

    for effect in CATALOGUE:
        law(effect)
    none, many = [0.0] * 50, [0.01 * i for i in range(50)]
    told: Any = {"name": "r", "time": many, "position": none, "input": [0.0] + [1.0] * 49, "added_mass": 0.0}
    run_ = stepid.Experiment(**told, spring="s", damper="d")
    model = stepid.PlantModel(base_mass={"cart": 1.0}, stiffness={"s": 200.0}, damping={"d": 4.0}, force_gain=8.0)
    stepid.simulate(model, stepid.Campaign(name="c", experiments=(run_,)))
    mutated = {".".join(file.relative_to(SOURCE.parent).with_suffix("").parts) for file in (*FILES, *MORE)}
    assert not mutated & set(sys.modules)


def main() -> None:
    """Draw, run, list the survivors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, nargs="?", default=100)
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("part", nargs="?", default="")
    parser.add_argument("--ran", type=Path, help="data of coverage with a context a test")
    parser.add_argument("--times", type=Path, help="what pytest --durations=0 -vv printed")
    parser.add_argument("--within", type=float, default=1e9, help="seconds of a mutant's tests, at most")
    parser.add_argument("--numbers", type=int, nargs="+", help="run those of the draw alone")
    parser.add_argument("--tests", nargs="+", default=(), help="run these tests instead")
    parser.add_argument("--lines", type=int, nargs=2, default=(0, -1))
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the mutant to go on from")
    given = parser.parse_args()
    ran = Ran(given.ran, given.times, given.within) if given.ran else None
    os.chdir(ROOT)
    sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests")]
    load()
    ends: Counter[str] = Counter()
    referee = Referee()
    lines = range(given.lines[0], given.lines[1] + 1)
    mutants = drawn(given.count, given.seed, given.part, lines)
    for number, mutant in list(enumerate(mutants))[given.first :]:
        if given.numbers and number not in given.numbers:
            continue
        began = time.monotonic()
        tests = list(given.tests) or tests_of(mutant, ran)
        end = referee.end(mutant, tests)
        ends[end.split()[0]] += 1
        where = f"{mutant.file.relative_to(SOURCE)}:{mutant.line}"
        took = f"{len(tests)} tests, {time.monotonic() - began:.0f} s"
        print(f"{number} {where} {mutant.words} ({took}): {end}", flush=True)
    dead = ends["killed"] + ends["slow"]
    print(f"{ends.total()} mutants: {dict(ends)}; {100 * dead / max(ends.total(), 1):.1f} % killed")


if __name__ == "__main__":
    main()
