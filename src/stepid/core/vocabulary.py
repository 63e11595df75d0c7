"""The words and units of a cart driven in V, and what stands for them where a disk turns or A, N or N·m drive."""

from __future__ import annotations

import re
from functools import lru_cache
from html import escape

from stepid.core.words import capitalized

_TURNED = {"kg": "kg·m²", "N": "N·m", "m": "rad", "mm": "mrad", "cm": "crad", "µm": "µrad"}
_WORDS = {  # of a cart, of a disk; the first that fits
    "mass-spring-damper plant": "torsional plant",
    "mass-spring-damper": "torsional plant",
    "moving mass m": "moving inertia J",
    "position x": "angle θ",
    "base and added weights": "base and added inertia",
    "force gain k_f": "torque gain K_T",  # looked up in small letters
    "wheels and rails": "the bearings",
    "rails": "shaft",
    "rail": "shaft",
    "tilted rail": "bent shaft",
    "weights, rack": "weights, clamps",
    "the damper's piston": "the damper",
    "weigh it again": "measure it again",
    "what the parts weigh": "the parts' moments of inertia",
    "what the cart weighs": "the disk's own inertia",
    "how fast the cart swings": "how fast the disk swings",
    "heavier": "with more inertia",
    "newton meters": "newton meters",
    "newton meter": "newton meter",
    "masses": "inertias",
    "mass": "inertia",
    "forces": "torques",
    "force": "torque",
    "positions": "angles",
    "position": "angle",
    "displacement": "angle",
    "distance": "angle",
    "cart": "disk",
    "meters": "radians",
    "meter": "radian",
    "millimeters": "milliradians",
}
_TURNED_SYMBOLS = {"m": "J", "x": r"\theta", "v": r"\omega", "K_f": "K_T"}
_SYMBOL = re.compile(r"(?<![\\A-Za-z])(?:K_f|[mxv])(?![A-Za-z])")
_TURNED_LETTERS = {"m₀": "J₀", "m": "J", "K_f": "K_T", "F_c": "T_c", "x_s": "θ_s", "x": "θ", "v": "ω"}
_LETTER = re.compile(r"(?<!\w)(?:m₀|K_f|F_c|x_s|[mxv]|a(?= =))(?!\w)")
_VOLTS = {"A": "amperes", "N": "newtons", "N·m": "newton meters"}
_ATOM = r"(?:kg|[mcµ]?m|m?[NVA]|m?s|[mcµ]?rad|1)(?:[²³]|\^\w+)?"
_PART = rf"(?:{_ATOM}|\({_ATOM}(?:[·/]{_ATOM})*\)(?:\^\w+)?)"
_UNIT = rf"{_PART}(?:[·/]{_PART})*"
_TAGS = re.compile(r"(<(?:style|script)\b.*?</(?:style|script)>|<[^>]+>)", re.DOTALL)
_SAID_BY_TAGS = re.compile(r'(?<=\s)((?:alt|title|aria-label)=")([^"]*)(?=")')


def is_word(name: str) -> bool:
    """Whether a name is nothing but one of the words or units, as the label "cart" that a base has by itself."""
    return name.lower() in _WORDS or re.fullmatch(_UNIT, name) is not None


def translated_text(text: str, motion: str, input_unit: str, kept: frozenset[str]) -> str:
    """Translate whole words and units in a text, but not in names that are `kept`."""
    return _pattern(motion, input_unit, kept).sub(lambda found: _one(found, motion, input_unit), text)


def translated_page(page: str, motion: str, input_unit: str, kept: frozenset[str]) -> str:
    """Translate what HTML shows and says, not its tags, styles and scripts."""

    def tag(text: str) -> str:
        if text.startswith(("<style", "<script")):
            return text
        return _SAID_BY_TAGS.sub(lambda found: found[1] + translated_text(found[2], motion, input_unit, kept), text)

    parts = _TAGS.split(page)
    return "".join(tag(s) if i % 2 else translated_text(s, motion, input_unit, kept) for i, s in enumerate(parts))


def translated_formula(latex: str) -> str:
    """Translate the symbols of a formula to those of a disk that turns."""
    return _SYMBOL.sub(lambda found: _TURNED_SYMBOLS[found[0]], latex)


def translated_law(law: str) -> str:
    """Translate the letters of a law or an equation in plain text to those of a disk that turns."""
    return _LETTER.sub(lambda found: _TURNED_LETTERS.get(found[0], "α"), law)


@lru_cache(maxsize=64)
def _pattern(motion: str, input_unit: str, kept: frozenset[str]) -> re.Pattern[str]:
    """One expression for names that are kept, words, and units."""
    names = sorted({form for name in kept for form in (name, escape(name))}, key=len, reverse=True)
    own = "|".join(map(re.escape, names)) or "(?!)"
    turned = motion == "rotation"
    words = "|".join(map(re.escape, sorted(_WORDS, key=len, reverse=True))) if turned else "(?!)"
    symbol = r"m(?=·ω|\[)" if turned else "(?!)"
    volts = r"volts?" if input_unit != "V" else "(?!)"
    return re.compile(
        rf"(?P<kept>(?<!\w)(?:{own})(?!\w))"
        rf"|(?<![\w/\\.'\"-])(?P<article>[Aa] )?(?P<word>(?i:{words}))(?![\w(:]|[-.]\w|\s?=)"
        rf"|(?<![\w·/\\])(?P<symbol>{symbol})"
        rf"|(?<![\w.\\-])(?P<volts>{volts})(?![\w`])"
        rf"|(?<![\w·/²³'\"\\$.-])(?P<unit>{_UNIT})(?![\w·/'\"\\$(\[{{=]|\s?=|[-.]\w)"
    )


def _one(found: re.Match[str], motion: str, input_unit: str) -> str:
    if found["word"] is not None:
        said = _WORDS[found["word"].lower()]
        if found["word"][0].isupper():
            said = capitalized(said)
        article = found["article"] or ""
        return f"{article.rstrip()}n {said}" if article and said[0].lower() in "aeio" else article + said
    if found["symbol"]:
        return "J"
    if found["volts"]:
        plural = _VOLTS[input_unit]
        return plural if found["volts"] == "volts" else plural[:-1]
    return translated_unit(found["unit"], motion, input_unit) if found["unit"] else found[0]


@lru_cache(maxsize=1024)
def translated_unit(unit: str, motion: str, input_unit: str) -> str:
    """Translate a unit, simple or compound, atom by atom; one that was translated stays as it is."""
    turns = motion == "rotation" and "N·m" not in unit and "kg·m²" not in unit

    def atom(found: re.Match[str]) -> str:
        prefix, symbol = found["prefix"], found["symbol"]
        if symbol == "V" and input_unit != "V":
            own = prefix + input_unit
            return f"({own})" if "·" in own and found.start() and unit[found.start() - 1] == "/" else own
        return _TURNED.get(prefix + symbol, found[0]) if turns else found[0]

    return re.sub(r"(?<![A-Za-zµ])(?P<prefix>[mcµ]?)(?P<symbol>kg|[mNV])(?![A-Za-z])", atom, unit)
