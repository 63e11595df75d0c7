"""Answers as people type them."""

from __future__ import annotations

import re

from stepid.errors import InputError

_NUMBERS = ("weight", "counts_per_meter", "sample_time", "step")


def numbers(text: str, flag: str, *, unit: str = "kg", example: str = "0,0.5,1.5") -> tuple[float, ...]:
    """Read numbers parted by commas, with or without their unit; parted by semicolons or blanks, commas are points."""
    bare = re.sub(rf"(?<=[\d.])\s*{unit}(?=[,;\s]|$)", "", text) if unit else text
    bare = bare.strip().removesuffix(",")
    parts = bare.removesuffix(";").split(";") if ";" in bare else bare.split(",")
    if ";" not in bare and len(bare.split()) > 1 and not re.search(r",\s", bare):
        parts = bare.split()
    try:
        return tuple(float(part.strip().replace(",", ".")) for part in parts)
    except ValueError:
        raise InputError(f"{flag} is {text!r}", f"Give numbers parted by commas: {example}.") from None


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
