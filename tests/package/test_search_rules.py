"""The search and the verdict hold no number of their own and know no effect by its name; what they may use is told."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from stepid.core.base import Model
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.moves import MOVES
from stepid.diagnosis.selection.moves.remain import Remain
from stepid.diagnosis.selection.proposal import Move
from stepid.diagnosis.verdict import RULES, Rule
from stepid.effects import CATALOGUE

DIAGNOSIS = Path(__file__).resolve().parents[2] / "src" / "stepid" / "diagnosis"
NUMBERS_LIVE_IN = DIAGNOSIS / "selection" / "effort.py"
SEARCH = sorted(p for p in (DIAGNOSIS / "selection").rglob("*.py") if p != NUMBERS_LIVE_IN)
DECIDING = [
    *SEARCH,
    *sorted(DIAGNOSIS.glob("rules_*.py")),
    *(DIAGNOSIS / f"{name}.py" for name in ("verdict", "gather", "lead", "left_out", "vetoes")),
]
TESTS = Path(__file__).resolve().parents[1] / "diagnosis"
OF_MOVES, OF_RULES = (sorted(TESTS.glob(f"test_{of}*.py")) for of in ("moves", "verdict"))
PLAIN = {0, 1, 2, 0.5}
WORDS = {e.name for e in CATALOGUE} | {q.unit for e in CATALOGUE for q in (*e.parameters, *e.run_parameters)} - {""}
LINES, BRANCHES = 60, 12
MODELS = [(Criteria, 20), (Effort, 25)]
NUMBER = "what decides is a field of `Criteria`, what saves time one of `Effort`; `wording` puts numbers into words"
WORD = "effects say what they are (`dry`, `contains`, `affine`, …): ask that, not their name or unit"
FULL = "no room for another number: use one that is there, or let one go; who raises the limit says why, here"
PAGE = DIAGNOSIS.parents[2] / "docs" / "how-to" / "add-a-move-or-rule.md"


def constants(tree: ast.AST) -> Iterator[ast.Constant]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.Constant))


def numbers(source: str) -> list[str]:
    """Numeric literals other than the plain ones, with their lines."""
    kinds = (int, float, complex)
    found = [c for c in constants(ast.parse(source)) if type(c.value) in kinds and c.value not in PLAIN]
    return [f"line {c.lineno}: {c.value}" for c in found]


def known_words(source: str) -> list[str]:
    """Strings that are an effect's name or a parameter's unit, with their lines."""
    found = [c for c in constants(ast.parse(source)) if isinstance(c.value, str) and c.value in WORDS]
    return [f"line {c.lineno}: {c.value!r}" for c in found]


def functions(path: Path) -> Iterator[ast.FunctionDef]:
    return (n for n in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(n, ast.FunctionDef))


def names(path: Path) -> str:
    return str(path.relative_to(DIAGNOSIS))


@pytest.mark.parametrize("path", DECIDING, ids=names)
def test_numbers_are_in_criteria_and_effort(path: Path) -> None:
    assert numbers(path.read_text("utf-8")) == [], NUMBER


@pytest.mark.parametrize("path", DECIDING, ids=names)
def test_no_effect_is_known_by_its_name_or_unit(path: Path) -> None:
    assert known_words(path.read_text("utf-8")) == [], WORD


def test_the_examples_on_the_page_could_be_put_in() -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), flags=re.DOTALL)
    examples = [b for b in blocks if "def propose" in b or "-> Answer" in b]
    assert len(examples) == 2
    for example in examples:
        assert (numbers(example), known_words(example)) == ([], [])


def test_a_number_and_a_name_would_be_seen() -> None:
    source = "LIMIT = 3\ndef f(x=1e-9, *, name='cogging'):\n    return -2 * x ** 0.5 if name == 'N/m' else x[:1]\n"
    assert numbers(source) == ["line 1: 3", "line 2: 1e-09"]
    assert known_words(source) == ["line 2: 'cogging'", "line 3: 'N/m'"]


@pytest.mark.parametrize("move", [*MOVES.every, Remain(frozenset())], ids=lambda move: move.name)
def test_every_move_has_a_test(move: Move) -> None:
    used = "\n".join(path.read_text("utf-8") for path in OF_MOVES)
    kind = type(move).__name__
    assert f"{kind}(" in used, f"{kind}: test what it proposes from a node, in {' or '.join(p.name for p in OF_MOVES)}"


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
def test_every_rule_has_a_test(rule: Rule) -> None:
    used = "\n".join(path.read_text("utf-8") for path in OF_RULES)
    asked = (f'ask("{rule.__name__}"', f"verdict.{rule.__name__}")
    assert any(words in used for words in asked), (
        f"{asked[0]}, …): test when it answers and when not, in test_verdict.py"
    )


@pytest.mark.parametrize("path", [*OF_MOVES, *OF_RULES], ids=lambda path: path.name)
def test_tests_of_moves_and_rules_search_nothing(path: Path) -> None:
    searching = re.findall(r"\b(?:Search\(|diagnose\(|import search\b)", path.read_text("utf-8"))
    assert searching == [], "what needs a search is tested in test_answer.py"


@pytest.mark.parametrize("path", sorted(DIAGNOSIS.rglob("*.py")), ids=names)
def test_functions_fit_on_a_screen(path: Path) -> None:
    for node in functions(path):
        words = (ast.get_docstring(node, clean=False) or "").count("\n")
        assert node.end_lineno is not None
        assert node.end_lineno - node.lineno - words < LINES, f"{node.name}: below {LINES} lines, docstring apart"


@pytest.mark.parametrize("path", DECIDING, ids=names)
def test_functions_have_few_branches(path: Path) -> None:
    kinds = (ast.If, ast.IfExp, ast.For, ast.While, ast.Try, ast.comprehension, ast.BoolOp)
    for node in functions(path):
        statements = sum(isinstance(n, (ast.If, ast.For, ast.While, ast.Try)) for n in ast.walk(node))
        every = sum(isinstance(n, kinds) for n in ast.walk(node))
        assert statements <= BRANCHES, f"{node.name}: {BRANCHES} ifs and loops at most, make a function of some"
        assert every <= 2 * BRANCHES, f"{node.name}: {2 * BRANCHES} branches at most, make a function of some"


@pytest.mark.parametrize(("model", "most"), MODELS, ids=["Criteria", "Effort"])
def test_few_numbers_each_with_its_reason(model: type[Model], most: int) -> None:
    assert len(model.model_fields) <= most, FULL
    told = dict(re.findall(r"^    (\w+) : \w+\n((?:        .+\n)+)", model.__doc__ or "", flags=re.MULTILINE))
    assert list(told) == list(model.model_fields), "each field in the docstring, as `name : type`, in their order"
    short = [name for name, words in told.items() if len(words.split()) < 4]
    assert not short, f"{short}: say the unit, the reason and where it comes from"


@pytest.mark.parametrize("model", [model for model, _ in MODELS])
def test_every_number_is_used(model: type[Model]) -> None:
    sources = "\n".join(p.read_text("utf-8") for p in DIAGNOSIS.rglob("*.py"))
    owner = model.__name__.lower()
    unused = [name for name in model.model_fields if not re.search(rf"\b{owner}\.{name}\b", sources)]
    assert unused == [], f"read as `{owner}.<name>` nowhere below stepid/diagnosis"
