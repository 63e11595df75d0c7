"""Answers as people type them."""

from __future__ import annotations

import re

from stepid.errors import InputError

_NUMBERS = ("weight", "counts_per_meter", "sample_time", "step")


def numbers(text: str, flag: str) -> tuple[float, ...]:
    """Read numbers parted by commas; where semicolons or blanks part them, commas are decimal marks."""
    parts = text.split(";") if ";" in text else text.split(",")
    if ";" not in text and len(text.split()) > 1 and not re.search(r",\s", text):
        parts = text.split()
    try:
        return tuple(float(re.sub(r"\s*kg\s*$", "", part).strip().replace(",", ".")) for part in parts)
    except ValueError:
        raise InputError(f"{flag} is {text!r}", "Give numbers parted by commas: 0,0.5,1.5.") from None


def spoken(key: str, answer: str) -> object:
    """Return what was typed to a question as the value of its field of `Answers`; InputError where it is none."""
    if key == "added_mass":
        return numbers(answer, "the answer")
    if key in _NUMBERS:
        found = numbers(answer.replace(",", "."), "the answer")
        if len(found) != 1:
            raise InputError(f"the answer is {answer!r}", "Give one number.")
        return found[0]
    return answer
