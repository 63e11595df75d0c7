"""Words for people."""

from __future__ import annotations

import pytest

from stepid.core.words import capitalized


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
