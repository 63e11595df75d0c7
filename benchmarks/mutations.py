"""The changes of which `mutants.py` draws mutants: one operator, number, condition or result of one file each."""

from __future__ import annotations

import ast
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "stepid"
FILES = (
    *sorted(SOURCE.glob("identification/**/*.py")),
    *sorted(SOURCE.glob("fitting/**/*.py")),
    SOURCE / "diagnosis" / "evidence.py",
    SOURCE / "diagnosis" / "verdict.py",
)
MORE = (SOURCE / "diagnosis" / "gather.py", SOURCE / "diagnosis" / "free_law.py")  # drawn from where PART names them
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
