"""What names of files, sheets and columns tell of a run: masses, weights, springs, dampers."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stepid.io.guess.draft import TURNS
from stepid.io.guess.words import SCALES, unit_for

_NUMBER = r"(?P<number>\d+(?:[.,p]\d+)?|[.,]\d+)"
_MASS = re.compile(
    rf"(?<![\d.,])(?:(?P<times>\d{{1,2}})\s*[x×*]\s*)?{_NUMBER}[\s_-]*"
    r"(?:(?P<kilo>kg|kilo(?:gram(?:me)?)?s?)|g|gr|gramm?e?s?|gramos|grammi)(?![a-z])",
    re.IGNORECASE,
)
_JOINED = re.compile(  # two masses, but not a mass and the volts of a step
    r"\d\s*(?:kg|g)?\s*[+&]\s*(?![\d.,]+\s*(?:m?v|volts?)(?![a-z]))[.,]?\d|\d\s*[x×*]\s*$", re.IGNORECASE
)
_POINT = re.compile(r"\d[_-]$")  # before a number: 0_3kg is 0.3 kg, or the third of its kind
_WEIGHTS = re.compile(
    r"(?<![\d.,])(?P<number>\d{1,2}|no|without|ohne|sans|zero|one|two|three|four)[\s_-]*(?:extra[\s_-]*)?"
    r"(?:mass(?:es|en)?|weights?|wts?|gewichte?|poids|pesi|pesas|bricks?|brass|lod(?:der)?)(?![a-z])",
    re.IGNORECASE,
)
_EMPTY = re.compile(r"(?<![a-z])(?:unloaded|empty|bare|nomass|noload|leer|no[\s_-]*load)(?![a-z])", re.IGNORECASE)
_SPELLED = {"no": 0, "without": 0, "ohne": 0, "sans": 0, "zero": 0, "one": 1, "two": 2, "three": 3, "four": 4}
_MASS_LINE = re.compile(
    r"(?i)(?:mass|load|weight|gewicht|last|poids|peso|carico|charge|massa)[^\d:=;,]*[:=;,\s]\s*"
    r"(?P<number>[+-]?\d+(?:[.,]\d+)?)\s*(?P<unit>kg|g)\b"
)
_ADDED = re.compile(
    r"(?i)add|extra|zus|suppl|ajout|aggiun|añad|adicion|load|last|charge|carico|weight|gewicht|poids|peso"
)
_OTHER_MASS = re.compile(
    r"(?i)cart\b|carriage|trolley|sled|slid|wagen|schlitten|chariot|carr[eio]|total|tot\b|gesamt|moving|mobile|bewegt|"
    r"base|basis|empty|leer|tare|cell|sensor|range|own|eigen|unload|equiv|effectiv"
)
_PLAIN_MASS = re.compile(r"(?i)\W*(?:the\W*)?mass[ea]?\W*(?:(?:in\W*)?k?g\W*)?")
_RATE = re.compile(
    r"(?i)(?:sampl\w*|abtast\w*|(?<![a-z])(?:data|mess|scan|frame|update)?[\s_-]*rate(?![a-z]))[^\d]*"
    r"(?P<number>[1-9]\d*(?:[.,]\d+)?|0[.,]0*[1-9]\d*)\s*(?P<unit>k?hz)\b"
)
_PERIOD = re.compile(
    r"(?:(?i:interval|sampl\w*|abtast\w*)|\bdt|\bTs)[^\d]*"
    r"(?P<number>[1-9]\d*(?:[.,]\d+)?|0[.,]0*[1-9]\d*)\s*(?P<unit>s|ms|us|µs)\b"
)
_FILTER = re.compile(r"(?i)filter|cut-?\s?off|pass|corner|grenz|tiefpass|band-?width|alias")
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
_TURN = ("rev", "turn", "umdrehung", "tour")
_PER_COUNT = ("m", "meter", "mm", "cm", "in", "inch", "rad", "deg", *_TURN)  # what an encoder may have counts of
_COUNTS_OF = (
    rf"(?:counts?|cts|ticks|inkremente|increments|impulse)\s*(?:/|per|pro|par|je)\s*(?P<unit>{'|'.join(_PER_COUNT)})"
    r"(?:ol\w*|rees?|s)?\b"
)
_ENCODER = re.compile(
    rf"(?i)(?:(?<![\d.,])(?<!\d\s)(?P<before>\d+(?:[.,]\d+)?)\s*{_COUNTS_OF}|"
    rf"{_COUNTS_OF.replace('unit', 'of')}\W*[:=;,\s]\s*(?P<after>\d+(?:[.,]\d+)?)(?!\s?\d))"
)
_SLOW = 1.0  # s, that no readings of a cart are apart
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")  # or three decimals
_LABVIEW_STEP = re.compile(r"(?:Delta_X|delta t)((?:\s+\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?)+)\s*")
_LABVIEW_TIME = re.compile(r"X_Dimension\s+Time\b|(?:waveform|t0)\t")
_STIFFNESS = r"soft|medium|stiff|hard|weak|strong|weich|mittel|hart"
_SPRING = re.compile(
    rf"(?<![a-z])(?:(?P<kind>{_STIFFNESS})(?:[\s_-]*(?:spring|feder))?|(?:spring|feder)[\s_-]*"
    rf"(?P<after>{_STIFFNESS}|\d+|[a-z]))(?![a-z])",
    re.IGNORECASE,
)
_DAMPER = re.compile(
    r"(?<![a-z])(?:(?P<before>no|without|with|ohne|mit|half|full|open|closed|low|high|\d+)[\s_-]*"
    r"(?:dampers?|dashpot|damping|dämpfer|turns?)|"
    r"(?:damper|dashpot|dämpfer)[\s_-]*(?P<after>no|off|on|low|high|half|full|\d+|[a-z])|(?P<none>undamped|nodamper))"
    r"(?![a-z])",
    re.IGNORECASE,
)
_RELEASE = re.compile(
    r"(?<![a-z])(?:(?:free[\s_-]*)?(?:release|swing|vibration|decay|oscillation)|ring[\s_-]*down|plucked?|"
    r"ausschwing\w*|freischwing\w*|free)(?![a-z])",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class FileName:
    """What a name tells: `mass` in kg, or how many `weights`; None where it tells nothing."""

    mass: float | None = None
    weights: int | None = None
    spring: str | None = None
    damper: str | None = None
    release: bool = False


def read_name(name: str) -> FileName:
    """Read a name: ``"soft_0.5kg"``, ``"2mass"``, ``"case_5"``."""
    text = name.replace("_", " ")
    masses, mass, weights = list(_MASS.finditer(text)), None, None
    if found := _WEIGHTS.search(text):
        word = found["number"].lower()
        weights = _SPELLED[word] if word in _SPELLED else int(word)
        masses = [one for one in masses if one["kilo"]]  # what is in g may be anything beside a number of weights
    if masses:
        whole = masses[0]["kilo"] is not None and masses[0]["number"].isdigit()
        may_go_on = whole and _POINT.search(name[: masses[0].start()]) is not None
        mass, weights = None if may_go_on else _one_mass(masses, text, 1 if weights is None else weights), None
    elif weights is not None and _JOINED.search(text):
        weights = None
    elif weights is None and _EMPTY.search(text):
        weights = 0
    if weights == 0:
        mass = 0.0
    spring, damper = _SPRING.search(text), _DAMPER.search(text)
    return FileName(
        mass,
        weights,
        None if spring is None else (spring["kind"] or spring["after"]).lower(),
        None if damper is None else re.sub(r"[\s_-]+", " ", damper[0].lower()),
        bool(_RELEASE.search(text)),
    )


def _one_mass(masses: Sequence[re.Match[str]], text: str, weights: int) -> float | None:
    """The mass in kg that a name tells; None, so that it is asked, where it may be a sum or one of several."""
    found = masses[0]
    if len(masses) > 1 or weights > 1 or _JOINED.search(text) or _JOINED.search(text[: found.start()]):
        return None
    return int(found["times"] or 1) * _float(found["number"]) / (1 if found["kilo"] else 1000)


def mass_above(lines: tuple[str, ...]) -> float | None:
    """Return the mass in kg that a line above a table tells, None where none does, or two differ."""
    told = set()
    for line in lines:
        if (found := _MASS_LINE.search(line)) is not None and _is_added(line, found):
            told.add(_float(found["number"]) / (1000 if found["unit"].lower() == "g" else 1))
    return told.pop() if len(told) == 1 and min(told, default=0.0) >= 0 else None


def _is_added(line: str, found: re.Match[str]) -> bool:
    """Tell an added mass from that of the cart, and from a number that may be thousands of grams."""
    label = _label(line, found)
    if found["unit"].lower() == "g" and _may_be_thousands(found["number"]):
        return False
    added = _ADDED.search(label) is not None or _PLAIN_MASS.fullmatch(label) is not None
    return added and _OTHER_MASS.search(label) is None


def _label(line: str, found: re.Match[str]) -> str:
    """What stands before a number, from the mark that parts it from what is told before."""
    return re.split(r"[;,|\t]", line[: found.start()])[-1] + line[found.start() : found.start("number")]


def sample_time_above(lines: tuple[str, ...]) -> float | None:
    """Return the sample time in s that a line above a table tells, None where none does, or two differ.

    LabVIEW's header has seconds where it says that its abscissa is a time, or is that of waveforms.
    """
    told: set[float] = set()
    labview = any(map(_LABVIEW_TIME.match, lines))
    for line in lines:
        if labview and (found := _LABVIEW_STEP.match(line)) is not None:
            told.update(map(_float, found[1].split()))
            continue
        found = _RATE.search(line) or _PERIOD.search(line)
        if found is None or _FILTER.search(_label(line, found)):
            continue
        number, unit = _float(found["number"]), found["unit"]
        period = number * _SECONDS[unit] if unit in _SECONDS else 1 / (number * (1000 if unit.lower() == "khz" else 1))
        thousands = _may_be_thousands(found["number"]) and (unit not in _SECONDS or 1000 * period < _SLOW)
        if not thousands:
            told.add(period)
    return told.pop() if len(told) == 1 else None


def encoder_above(lines: tuple[str, ...]) -> tuple[float, bool] | None:
    """Return what one count of an encoder is by the lines above a table, and whether that is an angle.

    In m or rad; None where no line tells it, or two differ.
    """
    told = set()
    for line in lines:
        if (found := _ENCODER.search(line)) is not None:
            word = (found["unit"] or found["of"]).lower()
            number = found["before"] or found["after"]
            unit = "rad" if word in _TURN else unit_for(word, "position") or ""
            size = SCALES["position"][unit] * (math.tau if word in _TURN else 1.0)
            if not _may_be_thousands(number) and _float(number) > 0:
                told.add((size / _float(number), unit in TURNS))
    return told.pop() if len(told) == 1 else None


def _may_be_thousands(number: str) -> bool:
    return _THOUSANDS.fullmatch(number) is not None


def plain_name(stem: str) -> str:
    """Return a run's name from that of its file: blanks for underscores."""
    return re.sub(r"[\s_]+", " ", stem).strip() or "run"


def _float(text: str) -> float:
    return float(re.sub("[,p]", ".", text))


def natural(file: Path) -> list[list[tuple[int, str]]]:
    """Order files by the numbers in the names of their folders and in their own."""
    return [_by_numbers(part.lower()) for part in (*file.parent.parts, file.stem)]


def _by_numbers(name: str) -> list[tuple[int, str]]:
    parts = re.split(r"(\d+(?:\.\d+)?)", name)
    return [(int(float(part) * 1000), "") if i % 2 else (0, part) for i, part in enumerate(parts)]
