r"""Tables of parameters for LaTeX, values and units by the package siunitx.

A document needs ``\usepackage{siunitx}`` (version 3).
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from stepid.core.estimate import format_value, outward, prefixed
from stepid.core.frames import Row
from stepid.core.quantities import spoken_now

_SPECIAL = {c: f"\\{c}" for c in "&%$#_{}"} | {
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "\\": r"\textbackslash{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "[": "{[}",  # after the end of a row, a bracket is a length
    "]": "{]}",
}
_MATH = {
    "ω_d": r"$\omega_d$",
    "ω": r"$\omega$",
    "ζ": r"$\zeta$",
    "φ": r"$\varphi$",
    "σ": r"$\sigma$",
    "µ": r"$\mu$",
    "Ω": r"$\Omega$",
    "·": r"$\cdot$",
    "×": r"$\times$",
    "±": r"$\pm$",
    "−": "$-$",
    "→": r"$\to$",
    "≤": r"$\le$",
    "≥": r"$\ge$",
    "≈": r"$\approx$",
    "√": r"$\surd$",
    "°": r"$^\circ$",
    "²": "$^2$",
    "³": "$^3$",
}
_SYMBOLS = {
    "m": r"\meter",
    "s": r"\second",
    "kg": r"\kilogram",
    "N": r"\newton",
    "V": r"\volt",
    "A": r"\ampere",
    "rad": r"\radian",
    "Hz": r"\hertz",
    "mm": r"\milli\meter",
    "ms": r"\milli\second",
    "µm": r"\micro\meter",
    "mrad": r"\milli\radian",
    "µrad": r"\micro\radian",
}
_POWERS = {"": "", "²": r"\squared", "³": r"\cubed"}
_UNIT = re.compile(r"([A-Za-zµ]+)([²³]?)")


def escaped(text: str) -> str:
    """Write a text so that LaTeX prints it as it is."""
    pattern = "|".join(map(re.escape, sorted(_MATH, key=len, reverse=True))) + r"|[][&%$#_{}~^\\<>|]"
    return re.sub(pattern, lambda found: _MATH.get(found[0]) or _SPECIAL[found[0]], " ".join(text.split()))


def number(value: float, uncertainty: float | None) -> str:
    r"""Write a value and its standard uncertainty as ``\num{216.2 +- 1.4}``, with the digits that text shows."""
    shown = format_value(value, uncertainty).replace(" ± ", " +- ")
    powered = re.fullmatch(r"\((.+)\)(e-?\d+)", shown)
    return rf"\num{{{' '.join(powered.groups()) if powered else shown}}}"


def unit(symbol: str) -> str:
    r"""Write a unit as ``\unit{\newton\second\per\meter}``; one that siunitx does not know as plain text."""
    if not symbol:
        return "--"
    over, *under = symbol.split("/")
    parts = [_power(part, "") for part in over.split("·") if part != "1"]
    parts += [_power(part, r"\per") for group in under for part in group.strip("()").split("·")]
    known = [part for part in parts if part is not None]
    return rf"\unit{{{''.join(known)}}}" if len(known) == len(parts) else escaped(symbol)


def _power(part: str, before: str) -> str | None:
    found = _UNIT.fullmatch(part)
    if found is None or found[1] not in _SYMBOLS:
        return None
    return before + _SYMBOLS[found[1]] + _POWERS[found[2]]


def parameter_name(name: str) -> str:
    """Write a parameter's name in words: ``"Coulomb friction, level"``, ``"stiffness (medium)"``, ``"input delay"``."""
    stem, bracket, label = name.partition("[")
    effect, dot, own = stem.partition(".")
    if dot and effect.endswith(f"_{own}"):  # a delay has its delay
        stem = effect
    words = stem.replace("_", " ").replace(".", ", ")
    words = words.replace("coulomb", "Coulomb").replace("stribeck", "Stribeck")
    return f"{words} ({label.removesuffix(']')})" if bracket else words


def parameter_table(rows: Iterable[Row], *, caption: str | None = None, label: str | None = None) -> str:
    """Write parameters as a LaTeX table.

    Parameters
    ----------
    rows : iterable of Row
    caption : str, optional
        With one, the table is a float with this caption.
    label : str, optional
        To refer to the float by.

    Returns
    -------
    str
        Value and standard uncertainty have the digits that the text tables have.
    """
    lines = [r"\begin{tabular}{lrl}", r"\hline", r"parameter & value & unit \\", r"\hline"]
    given, quantities = list(rows), spoken_now()
    some = any(row.uncertainty is not None for row in given)
    for row in given:
        value, symbol = _written(row, some)
        said, own = quantities.text(parameter_name(row.name)), quantities.unit(symbol)
        lines.append(rf"{escaped(said)} & {value} & {unit(own)} \\")
    lines += [r"\hline", r"\end{tabular}"]
    if caption is not None:
        named = [rf"\label{{{label}}}"] if label else []
        lines = [r"\begin{table}", r"\centering", rf"\caption{{{escaped(caption)}}}", *named, *lines, r"\end{table}"]
    return "\n".join(lines) + "\n"


def _written(row: Row, others_are_known: bool) -> tuple[str, str]:
    """A value, or the one end that the data give it, and its unit; undetermined only where others are not."""
    if row.one_sided is not None:
        words, end = row.one_sided
        value, _, symbol = prefixed(end, None, row.unit)
        return rf"{words} \num{{{outward(words, value)}}}", symbol
    value, uncertainty, symbol = prefixed(row.value, row.uncertainty, row.unit)
    remark = " (undetermined)" if others_are_known and uncertainty is None else ""
    return number(value, uncertainty) + remark, symbol
