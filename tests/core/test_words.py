"""Words for people."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import stepid
from stepid.core.quantities import Quantities
from stepid.core.words import capitalized, counted, length


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("dry friction", "Dry friction"),
        ("k of Burchett", "K of Burchett"),
        ("Coulomb friction", "Coulomb friction"),
        ("", ""),
    ],
)
def test_only_the_first_letter_changes(words: str, said: str) -> None:
    assert capitalized(words) == said


@pytest.mark.parametrize(
    ("meters", "said"),
    [(1234.5, "1234500 mm"), (0.1234, "123 mm"), (-0.0123, "-12.3 mm"), (4.4e-8, "0.044 µm"), (2.5e-10, "0.00025 µm")],
)
def test_lengths_of_any_size_have_no_exponent(meters: float, said: str) -> None:
    assert length(meters) == said
    assert Quantities("rotation", "V").text(f"off by {length(meters)}.") == f"off by {said[:-1]}rad."


def test_texts_write_lengths_in_one_way() -> None:
    for file in Path(stepid.__file__).parent.rglob("*.py"):
        found = re.search(r"(?<!%)\{[^{}]*:\.\d[gf]\} (?:mm|µm)", file.read_text(encoding="utf-8"))
        assert found is None, f"{file.name}: {found and found[0]}"


def test_numbers_have_their_nouns() -> None:
    assert [counted(n, "run") for n in (0, 1, 2)] == ["0 runs", "1 run", "2 runs"]
