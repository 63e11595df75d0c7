"""Mutation testing of the core: mutants drawn by a seed, each run against the tests of its file.

    python benchmarks/mutants.py COUNT [SEED] [PART] [--ran DATA] [--most TESTS] [--only PART] [--lines FIRST LAST] …

PART draws from files whose path holds it only, as diagnosis/verdict; `--lines` from these lines. With DATA of coverage,
a mutant is run against the tests that ran its statement, and no others could tell it:

    printf '[run]\\ndynamic_context = test_function\\n' > contexts.rc
    COVERAGE_FILE=DATA coverage run --rcfile contexts.rc --source stepid -m pytest tests/fitting

A mutant is killed where a test fails that passes without it. Where its tests take longer than the patience, so may they
without it: these are run, too, and where they are as slow nothing is known.
"""

from __future__ import annotations

import argparse
import ast
import importlib.abc
import importlib.machinery
import os
import random
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "stepid"
FILES = (
    *sorted(SOURCE.glob("identification/*.py")),
    *sorted(SOURCE.glob("fitting/*.py")),
    SOURCE / "diagnosis" / "evidence.py",
    SOURCE / "diagnosis" / "verdict.py",
)
MORE = (SOURCE / "diagnosis" / "gather.py", SOURCE / "diagnosis" / "free_law.py")  # drawn from where PART names them
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
SWAPPED: dict[type, type] = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Add: ast.Sub, ast.Sub: ast.Add,
    ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
EDGE: dict[type, type] = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}


class Mutant(NamedTuple):
    """One change of one file."""

    file: Path
    line: int
    place: int  # among the file's possible changes
    words: str
    text: str  # of the whole file
    statement: range  # its lines; empty where it runs on import


def changes(tree: ast.Module) -> Iterator[tuple[ast.AST, str, Callable[[], None]]]:
    """Every change that could be made: the node, in words, and a function that makes it."""
    skipped: set[int] = set()
    for node in ast.walk(tree):
        if id(node) in skipped or isinstance(node, ast.Raise | ast.JoinedStr | ast.ImportFrom | ast.Import):
            skipped.update(id(child) for child in ast.walk(node))  # words for users, and what is imported
            continue
        if isinstance(node, ast.AnnAssign | ast.arg) and node.annotation is not None:
            skipped.update(id(child) for child in ast.walk(node.annotation))
        if isinstance(node, ast.FunctionDef) and node.returns is not None:
            skipped.update(id(child) for child in ast.walk(node.returns))
        if isinstance(node, ast.Compare):
            for table in (SWAPPED, EDGE):
                if len(node.ops) == 1 and (new := table.get(type(node.ops[0]))) is not None:
                    yield node, f"{type(node.ops[0]).__name__} -> {new.__name__}", _setter(node, "ops", [new()])
        elif isinstance(node, ast.BinOp | ast.BoolOp) and (new := SWAPPED.get(type(node.op))) is not None:
            yield node, f"{type(node.op).__name__} -> {new.__name__}", _setter(node, "op", new())
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            yield node, "without minus", _setter(node, "op", ast.UAdd())
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            yield node, "without not", _setter(node, "operand", ast.UnaryOp(ast.Not(), node.operand))
        elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
            yield node, f"{node.value} -> {not node.value}", _setter(node, "value", not node.value)
        elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            other = node.value + 1 if isinstance(node.value, int) else 1.5 * node.value + (node.value == 0)
            yield node, f"{node.value} -> {other}", _setter(node, "value", other)
        elif isinstance(node, ast.If | ast.IfExp | ast.While):
            yield node, f"not ({ast.unparse(node.test)[:40]})", _setter(node, "test", ast.UnaryOp(ast.Not(), node.test))
        elif isinstance(node, ast.Return) and node.value is not None and ast.unparse(node.value) != "None":
            yield node, "returns None", _setter(node, "value", ast.Constant(None))


def _setter(node: ast.AST, field: str, value: Any) -> Callable[[], None]:
    return lambda: setattr(node, field, value)


def statement_of(tree: ast.Module, line: int) -> range:
    """The lines of the statement of a function that holds a line, of a compound one its head; empty outside."""
    inside = [f for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) and f.body[0].lineno <= line <= _end(f)]
    found = [s for f in inside for s in ast.walk(f) if isinstance(s, ast.stmt) and s.lineno <= line <= _end(s)]
    if not found:
        return range(0)
    last = max(found, key=lambda s: (s.lineno, -_end(s)))
    body = getattr(last, "body", None)
    return range(last.lineno, max(body[0].lineno, last.lineno + 1) if body else _end(last) + 1)


def _end(node: ast.stmt) -> int:
    return node.end_lineno or node.lineno


def drawn(count: int, seed: int, part: str, lines: range) -> list[Mutant]:
    """Draw mutants, each possible change of all files alike likely."""
    files = [file for file in (*FILES, *(MORE if part else ())) if part in str(file.relative_to(SOURCE))]
    sites = [
        (file, i)
        for file in files
        for i, (node, _, _) in enumerate(changes(ast.parse(file.read_text())))
        if not lines or getattr(node, "lineno", 0) in lines
    ]
    chosen = random.Random(seed).sample(sites, min(count, len(sites)))
    print(f"{len(sites)} possible changes in {len(files)} files; {len(chosen)} drawn by seed {seed}", flush=True)
    out = []
    for file, i in chosen:
        tree = ast.parse(file.read_text())
        node, words, change = list(changes(tree))[i]
        line = getattr(node, "lineno", 0)
        statement = statement_of(tree, line)
        change()
        out.append(Mutant(file, line, i, words, ast.unparse(ast.fix_missing_locations(tree)), statement))
    return out


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
    """Which tests ran which lines, as coverage saw it."""

    def __init__(self, data: Path) -> None:
        from coverage import CoverageData

        self.data = CoverageData(str(data))
        self.data.read()

    def tests(self, mutant: Mutant) -> list[str]:
        """Those that ran the statement; of what runs on import, those that ran any line of the file."""
        by_line = self.data.contexts_by_lineno(str(mutant.file))
        some = mutant.statement or by_line
        found = {name for line in some for name in by_line.get(line, ()) if name}
        if not found and any(line in by_line for line in some):  # in fixtures only
            found = {name for names in by_line.values() for name in names if name}
        out = {f"{file}::{name.rpartition('.')[2]}" for name in found if (file := _file_of(name)) is not None}
        if any(_file_of(name) is None for name in found):  # of hypothesis, which calls tests by a name of its own
            rooms = {ROOT / room for rooms in TESTS.values() for room in rooms if mutant.file.parent.name in room}
            out |= {str(file) for room in rooms for file in room.rglob("test_*.py") if "@given" in file.read_text()}
        return sorted(out, key=lambda test: ("::" not in test, mutant.file.stem not in test, test))


def _file_of(context: str) -> Path | None:
    file = ROOT.joinpath(*context.split(".")[:-1]).with_suffix(".py")
    return file if file.exists() else None


def tests_of(mutant: Mutant, ran: Ran | None) -> list[str]:
    """Tests of a mutant, those with its file's name first."""
    if ran is not None:
        return ran.tests(mutant)
    file = mutant.file
    rooms = TESTS.get(file.stem) or TESTS[file.parent.name]
    found = [test for room in rooms for test in (sorted((ROOT / room).glob("test_*.py")) or [ROOT / room])]
    near = [test for test in found if file.stem in test.stem or test.stem.removeprefix("test_") in file.stem]
    return [str(test) for test in dict.fromkeys([*near, *found])]


def survives(mutant: Mutant, tests: list[str]) -> str:
    """How a mutant ends: killed, slow (as good as killed: its tests end without it), survived, not run or undecided."""
    if not tests:
        return "not run"
    end = run(mutant, tests)
    if end in ("killed", "survived"):
        return end
    return "undecided" if run(None, tests) != "survived" else end if end == "slow" else "killed"


def run(mutant: Mutant | None, tests: list[str]) -> str:
    """Run tests in a child process; return how it ended."""
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
        import pytest

        code = 70
        try:
            quick = ["-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", "--no-header"]
            code = int(pytest.main([*quick, "-o", "addopts=--import-mode=importlib", *tests]))
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return "slow"
    failed = {0: "survived", 1: "killed", 2: "killed"}  # 2: a file of tests could not be imported
    return failed.get(os.WEXITSTATUS(status), "odd")


def main() -> None:
    """Draw, run, list the survivors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, nargs="?", default=100)
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("part", nargs="?", default="")
    parser.add_argument("--ran", type=Path, help="data of coverage with a context a test")
    parser.add_argument("--only", default="", help="run those of the draw whose path holds it")
    parser.add_argument("--most", type=int, default=10_000, help="tests of a mutant, at most: the first by name")
    parser.add_argument("--lines", type=int, nargs=2, default=(0, -1))
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the mutant to go on from")
    given = parser.parse_args()
    ran = Ran(given.ran) if given.ran else None
    os.chdir(ROOT)
    sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests")]
    import control
    import numba
    import scipy.optimize
    import scipy.signal

    assert all((control, numba, scipy.optimize, scipy.signal))  # loaded once, for all children
    ends: Counter[str] = Counter()
    lines = range(given.lines[0], given.lines[1] + 1)
    mutants = drawn(given.count, given.seed, given.part, lines)
    for number, mutant in list(enumerate(mutants))[given.first :]:
        if given.only not in str(mutant.file):
            continue
        began = time.monotonic()
        tests = tests_of(mutant, ran)[: given.most]
        end = survives(mutant, tests)
        ends[end] += 1
        where = f"{mutant.file.relative_to(SOURCE)}:{mutant.line}"
        print(f"{number} {end} {where} {mutant.words} ({len(tests)}, {time.monotonic() - began:.0f} s)", flush=True)
    dead = ends["killed"] + ends["slow"]
    print(f"{ends.total()} mutants: {dict(ends)}; {100 * dead / max(ends.total(), 1):.1f} % killed")


if __name__ == "__main__":
    main()
