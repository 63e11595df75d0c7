"""Words for people."""

from __future__ import annotations

import math
from collections.abc import Sequence

_SMALL, _LEAST = 0.095, 1e-4  # µm
_NAMED = 6  # samples named in a sentence


def capitalized(words: str) -> str:
    """Words as they begin a sentence: a first letter that is large, the others as they are."""
    return words[:1].upper() + words[1:]


def counted(number: int, noun: str) -> str:
    """A number with its noun: ``"1 run"``, ``"3 runs"``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def length(meters: float) -> str:
    """Write a length with three digits in µm or mm, never with an exponent: ``"637 µm"``, ``"1.20 mm"``."""
    micro = 1e6 * meters
    if abs(micro) >= 999.5:
        return f"{digits(1e3 * meters)} mm"
    if _LEAST <= abs(micro) < _SMALL:  # of fine sensors; two digits
        return f"{micro:.{1 - math.floor(math.log10(abs(micro)))}f} µm"
    return f"{digits(micro)} µm"


def digits(value: float) -> str:
    """Write three significant digits without an exponent; two decimals at most."""
    size = abs(value)
    places = 0 if size >= 99.95 else 1 if size >= 9.995 else 2
    return f"{value:.{places}f}"


def listed(parts: Sequence[str], word: str) -> str:
    """Write a list as people speak: ``"a, b and c"``."""
    return f" {word} ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def at_samples(numbers: Sequence[int]) -> str:
    """Name the first few of some samples: ``"sample 4"``, ``"samples 1, 2, 3, 5, 8, 13, …"``."""
    told = ", ".join(map(str, numbers[:_NAMED])) + (", …" if len(numbers) > _NAMED else "")
    return f"sample{'s' * (len(numbers) > 1)} {told}"


def runs_named(names: Sequence[str]) -> str:
    """Name some runs: ``"run 'a'"``, ``"runs 'a', 'b' and 'c'"``."""
    return f"run{'s' * (len(names) > 1)} {listed([repr(name) for name in names], 'and')}"
