"""Mutation testing of the core: mutants drawn by a seed, each run against the tests of its file.

python benchmarks/mutants.py COUNT [SEED] [PART]    of files whose path holds PART, as diagnosis/verdict
"""

from __future__ import annotations

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
PATIENCE = 120  # s CPU; who needs longer is in an endless loop
TESTS = {  # of a room, the first to fail most often first; `-x` ends at the first failure
    "identification": ("tests/identification",),
    "fitting": ("tests/fitting", "tests/simulation/test_derivatives.py"),
    "evidence": ("tests/diagnosis/test_evidence.py", "tests/diagnosis/test_moves.py"),
    "verdict": ("tests/diagnosis/test_verdict.py", "tests/diagnosis/test_answer.py"),
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
        elif isinstance(node, ast.Return) and node.value is not None:
            yield node, "returns None", _setter(node, "value", ast.Constant(None))


def _setter(node: ast.AST, field: str, value: Any) -> Callable[[], None]:
    return lambda: setattr(node, field, value)


def drawn(count: int, seed: int, part: str) -> list[Mutant]:
    """Draw mutants, each possible change of all files alike likely."""
    files = [file for file in FILES if part in str(file.relative_to(SOURCE))]
    sites = [(file, i) for file in files for i in range(sum(1 for _ in changes(ast.parse(file.read_text()))))]
    chosen = random.Random(seed).sample(sites, min(count, len(sites)))
    print(f"{len(sites)} possible changes in {len(files)} files; {len(chosen)} drawn by seed {seed}", flush=True)
    out = []
    for file, i in chosen:
        tree = ast.parse(file.read_text())
        node, words, change = list(changes(tree))[i]
        change()
        line = getattr(node, "lineno", 0)
        out.append(Mutant(file, line, i, words, ast.unparse(ast.fix_missing_locations(tree))))
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


def tests_of(file: Path) -> list[str]:
    """Tests of a file, those with its name first."""
    rooms = TESTS.get(file.stem) or TESTS[file.parent.name]
    found = [test for room in rooms for test in (sorted((ROOT / room).glob("test_*.py")) or [ROOT / room])]
    near = [test for test in found if file.stem in test.stem or test.stem.removeprefix("test_") in file.stem]
    return [str(test) for test in dict.fromkeys([*near, *found])]


def survives(mutant: Mutant) -> str:
    """Run the tests in a child process; return how it ended: killed, survived or slow (killed, too)."""
    child = os.fork()
    if child == 0:
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, PATIENCE))
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        sys.meta_path.insert(0, _Loader(mutant))
        import pytest

        code = 70
        try:
            quick = [
                "-x",
                "-q",
                "-p",
                "no:cacheprovider",
                "-m",
                "not slow",
                "--no-header",
                "-o",
                "addopts=--import-mode=importlib",
            ]
            code = int(pytest.main([*quick, *tests_of(mutant.file)]))
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return "slow"
    return "survived" if os.WEXITSTATUS(status) == 0 else "killed"


def main() -> None:
    """Draw, run, list the survivors."""
    count, seed, part = [*sys.argv[1:4], *("100", "1", "")[len(sys.argv[1:4]) :]]
    os.chdir(ROOT)
    sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests")]
    import control
    import numba
    import scipy.optimize
    import scipy.signal

    assert all((control, numba, scipy.optimize, scipy.signal))  # loaded once, for all children
    ends: Counter[str] = Counter()
    for number, mutant in enumerate(drawn(int(count), int(seed), part)):
        began = time.monotonic()
        end = survives(mutant)
        ends[end] += 1
        where = f"{mutant.file.relative_to(SOURCE)}:{mutant.line}"
        print(f"{number} {end} {where} {mutant.words} ({time.monotonic() - began:.0f} s)", flush=True)
    dead = ends["killed"] + ends["slow"]
    print(f"{ends.total()} mutants: {dict(ends)}; {100 * dead / max(ends.total(), 1):.1f} % killed")


if __name__ == "__main__":
    main()
