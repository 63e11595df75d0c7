"""Words for people."""

from __future__ import annotations


def capitalized(words: str) -> str:
    """Words as they begin a sentence: a first letter that is large, the others as they are."""
    return words[:1].upper() + words[1:]
