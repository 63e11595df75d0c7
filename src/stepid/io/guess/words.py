"""What columns are called in laboratories (in the languages of Western Europe), and their units."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Collection, Sequence
from typing import Literal, NamedTuple

Role = Literal["time", "position", "input", "other"]
COUNTS = "counts"

SCALES: dict[str, dict[str, float]] = {  # SI units per unit; rad stands for m where a plant turns
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "position": {
        "m": 1.0,
        "cm": 1e-2,
        "mm": 1e-3,
        "um": 1e-6,
        "nm": 1e-9,
        "in": 0.0254,
        "rad": 1.0,
        "mrad": 1e-3,
        "deg": math.pi / 180,
    },
    "input": {"V": 1.0, "mV": 1e-3, "N": 1.0, "mN": 1e-3, "A": 1.0, "mA": 1e-3, "N·m": 1.0},
}
_ALSO = {  # other spellings, lower case
    "time": {
        "s": "sec secs second seconds sekunde sekunden seconde secondes secondi segundos",
        "ms": "msec msecs millis millisecond milliseconds millisekunden",
        "us": "µs μs usec micros microsecond microseconds mikrosekunden",
        "min": "minute minutes minuten",
    },
    "position": {
        "m": "meter meters metre metres mètre mètres metri metros",
        "mm": "millimeter millimeters millimetre millimetres",
        "cm": "centimeter centimeters centimetre centimetres zentimeter",
        "um": "µm μm micron microns micrometer micrometers mikrometer",
        "in": "inch inches zoll",
        "deg": "° degree degrees grad gradi grados graus degrés",
        "rad": "radian radians rads",
        COUNTS: "count cts cnt counts pulses ticks inc inkremente incr impulse",
    },
    "input": {
        "V": "volt volts v",
        "mV": "millivolt millivolts mv",
        "N": "newton newtons",
        "A": "amp amps ampere",
        "N·m": "Nm N*m N.m",
        COUNTS: "pwm dac % counts cts lsb",
    },
}
_SPELLED = {
    role: {
        **{unit: unit for unit in SCALES[role]},
        **{word: unit for unit, words in spellings.items() for word in words.split()},
    }
    for role, spellings in _ALSO.items()
}
_SHORT = {"in", "min", "inc", "grad", "v", "n", "a", "%"}  # too much like words to be units unless in brackets
_ALONE = {"m", "cm", "mm", "um", "rad", "mrad", "deg"}  # a column that is called so is a position in it; nm may be N·m
_BRACKETS = re.compile(r"\s*[\[({<]\s*([^\])}>]{1,14}?)\s*[\])}>]")
_RATE = re.compile(r"(?P<unit>.+?)\s*(?:/\s*(?:s|ms|min|h)\s*(?:\^?2|²)?|[\s·*]\s*s\s*(?:\^?-[12]|⁻[¹²]))")
_RATE_TAIL = re.compile(r"^(?P<stem>.*[^\s\d,/])(?:\s*[,/]\s*|\s+in\s+|\s+)(?P<unit>[^\s,/]+\s*/\s*[^\s/]+)$")
_TAIL = re.compile(r"^(?P<stem>.*[^\s,/_])(?:\s*[,/]\s*|\s+in\s+|[_ ])(?P<unit>[^\s,/_\[\]()]{1,12})$")

_WORDS: dict[Role, tuple[str, str]] = {  # whole words, and how longer words begin
    "other": (
        "v n i nr no idx index sample samples set sp soll sollwert ref reference desired target wanted error err "
        "status state flag comment comments remark remarks note notes kommentar date datum fecha velocity speed "
        "vel acc a ax temperature label commentaire event marker counter row line zeile xref rref r gyro gyr rate "
        "rates omega ω rpm sigma stdev unc",
        "veloc vitess geschw snelh accel beschl setp consig referen kommentar remark comment temperat veloci sollw "
        "gyro uncert unsich incert",
    ),
    "time": (
        "t time times zeit tid tijd temps tempo tiempo sec secs seconds millis micros ms clock timestamp elapsed "
        "uhr zeitpunkt uhrzeit timestamps tempi",
        "zeit timest elaps",
    ),
    "input": (
        "u volt volts voltage spannung tension tensione tensión motor effort control command cmd input eingang "
        "entrada ingresso entrée entree drive dac pwm force kraft current strom torque actuator excitation "
        "stimulus forza fuerza stellgröße stellgrösse stellgroesse commande comando ue uin moment amp amplifier "
        "out output volty jännite",
        "volt spann tensi eingang stell actua excit moment",
    ),
    "position": (
        "x y pos position weg auslenkung deflection enc encoder lage travel distance dist angle winkel theta phi "
        "θ ϑ φ ϕ abstand strecke laser lvdt height cart elongation hub stroke extension ort displ disp spostamento "
        "posizione lvdt1 q z läge laege lege stand amplitude positie plaats pot sensor measured messwert mass1 "
        "alpha yaw pitch roll tilt",
        "pos displ depl dépl spost despl auslenk deflect encod versch weg elong allong winkel angul",
    ),
}
_HEADS = ("angle", "winkel", "position", "auslenkung")  # how longer words of a position end: "Hubangle"
_RATE_HEADS = ("speed", "velocity", "acceleration", "geschwindigkeit", "beschleunigung")
_AXIS = r"(?<=\b[XYZ])(?=(?:Acc|Ang|Gyr|Pos|Rate|Vel))"  # "ZGyro", but not "VIn" or "IMotor"
_RATES = re.compile(r"(?:angle|dreh|gier|nick|pitch|roll|sample|turn|wank|winkel|yaw)rate")  # not "substrate"
_NO_HEAD = re.compile(r"(?:tri|rect)angle|(?:com|dis|ex)position")
_COMMANDED = {"commanded", "command", "cmd", "desired", "target", "ref", "reference", "soll", "set", "setpoint"}
_SETS = re.compile(rf"(?:soll\w*|set|ref|reference|target|command|commanded|desired)(?:{'|'.join(_HEADS)})")
_BODIES, _SENSORS = {"cart", "hub", "mass1"}, {"sensor", "encoder", "enc", "laser", "pot", "lvdt", "lvdt1"}
_VOLTAGE = ("v", "spann", "tens", "out", "u")
RUN_WORDS = frozenset(
    {"run", "case", "test", "trial", "exp", "experiment", "versuch", "messung", "messreihe", "rep", "lauf", "probe"}
    | {"essai", "prova", "ensayo", "fall", "rec", "record", "series", "measurement", "nr", "no", "take"}
)


class Title(NamedTuple):
    """What a column's name says: its role, its unit, and what is left of the name."""

    role: Role | None
    unit: str | None
    rest: str
    doubtful: bool  # a unit is named that stepid does not know


def is_unit(text: str) -> bool:
    """Say whether a cell holds a unit and nothing else."""
    bare = text.strip().strip("[](){}<>").strip()
    return bare in ("-", "1") or any(_unit_of(bare, role, bracketed=True) is not None for role in SCALES)


def unit_for(text: str, role: str) -> str | None:
    """Return the unit that a text is for a role, as `SCALES` spells it, ``"counts"``, or None."""
    return _unit_of(text.strip().strip("[](){}<>").strip(), role, bracketed=True)


def read_title(name: str) -> Title:
    """Read a column's name.

    Parameters
    ----------
    name : str

    Returns
    -------
    Title
    """
    brackets = _unit_brackets(name)
    if _names_rate(name, brackets):
        return Title("other", None, name, False)
    stem, unit, bracketed, role = _parts(name, brackets)
    if not unit:
        alone = None if role else _unit_of(name.strip(), "position", bracketed=False)
        return Title("position", alone, stem, False) if alone in _ALONE else Title(role, None, stem, False)
    for one in (role,) if role in SCALES else SCALES:
        if (known := _unit_of(unit, str(one), bracketed=bracketed)) is not None and (role != "other"):
            return Title(role or _role_by_unit(known), known, stem, False)
    if bracketed and not any(char.isdigit() for char in unit):
        return Title(role, None, stem, doubtful=True)
    return _numbered(name) or Title(role_of(name), None, name, False)


class _Parts(NamedTuple):
    """What a column's name is made of: its words, its unit, whether that stands in brackets, and the words' role."""

    stem: str
    unit: str
    bracketed: bool
    role: Role | None


def _parts(name: str, brackets: re.Match[str] | None) -> _Parts:
    """Part a column's name into its words and its unit, in brackets or at the end; '' without a unit."""
    if brackets:
        words, unit = _split_brackets(brackets[1])
        bare = name[: brackets.start()] + name[brackets.end() :]
        role = role_of(bare + words)
        if role != "other":  # what stands in brackets tells only what the name leaves open
            role = role_of(bare) or role
        return _Parts(bare + words, unit, True, role)
    tail = _TAIL.match(name)
    stem, unit = (tail["stem"], tail["unit"]) if tail is not None else (name, "")
    return _Parts(stem, unit, False, role_of(stem))


def _numbered(name: str) -> Title | None:
    """Read a name that ends in a number after its unit, as in x_mm_1; None where it does not."""
    numbered = re.fullmatch(r"(.*[^\W\d_])[ _.-]?(\d+)\s*", name)
    inner = read_title(numbered[1]) if numbered is not None else None
    if numbered is None or inner is None or inner.unit is None:
        return None
    return inner._replace(rest=f"{inner.rest} {numbered[2]}")


def _names_rate(name: str, brackets: re.Match[str] | None) -> bool:
    """Tell whether what may be a position is in a unit of length or angle by time: a velocity or an acceleration."""
    tail = _RATE_TAIL.match(name)
    unit = brackets[1] if brackets else tail["unit"] if tail else name
    rate = _RATE.fullmatch(unit)
    known = rate is not None and _unit_of(rate["unit"], "position", bracketed=True) is not None
    return known and role_of(name) in (None, "position")


def _split_brackets(inside: str) -> tuple[str, str]:
    """Part what stands in brackets into words and their unit: "(theta in rad)"; a size such as 5 m is none."""
    tail = None if is_unit(inside) or re.search(r"[\d/]", inside) else _TAIL.match(inside)
    return (f" {tail['stem']}", tail["unit"]) if tail and is_unit(tail["unit"]) else ("", inside)


def _unit_brackets(name: str) -> re.Match[str] | None:
    """The brackets that hold a unit, or what stands in its place at the end of a name."""
    found = list(_BRACKETS.finditer(name))
    known = [one for one in found if is_unit(_split_brackets(one[1])[1])]
    return known[-1] if known else next((one for one in found if one.end() == len(name)), None)


def role_of(name: str) -> Role | None:
    """Return the role that the words of a column's name give it, None where they give none."""
    words = tokens(name)
    if "V" in re.split(r"[\W_\d]+", name):
        words = ["volts" if word == "v" else word for word in words]
    found = {role for role in _WORDS for word in words if _is_word(word, role)}
    if "other" in found and not ({"v", "n", "no", "nr", "i", "a", "r"} >= {w for w in words if _is_word(w, "other")}):
        return "other"
    if _is_aside(words, found):
        found.discard("position")
    if "position" in found:
        return "other" if _COMMANDED.intersection(words) or _is_set(words) else "position"
    for role in ("input", "time", "other"):
        if role in found:
            return role
    return None


def _is_aside(words: Sequence[str], found: Collection[Role]) -> bool:
    """Say whether a name's position is only what moves or what reads, beside another quantity: "Force sensor".

    The voltage of a sensor is its reading.
    """
    own = {word for word in words if _is_word(word, "position")}
    asked = {word for word in words if _is_word(word, "input")}
    read = all(word.startswith(_VOLTAGE) for word in asked) and "time" not in found
    return bool(asked or "time" in found) and own <= _BODIES | (set() if read else _SENSORS)


def _is_set(words: Sequence[str]) -> bool:
    """Say whether a word is one of a commanded position: "Sollwinkel"."""
    return any(_SETS.fullmatch(word) for word in words)


def tokens(name: str) -> list[str]:
    """Words of a name in lower case; digits, signs and humps of camelCase part them."""
    humps = re.sub(rf"(?<=[a-zäöüéß])(?=[A-Z])|{_AXIS}", " ", unicodedata.normalize("NFC", name))
    return [word for word in re.split(r"[\W\d_]+", humps.lower()) if word]


def _is_word(word: str, role: Role) -> bool:
    whole, starts = _WORDS[role]
    heads = {"position": _HEADS, "other": _RATE_HEADS}.get(role, ())
    ends = word.endswith(heads) and not _NO_HEAD.fullmatch(word)
    ends = ends or (role == "other" and _RATES.fullmatch(word) is not None)
    return word in whole.split() or (len(word) > 3 and word.startswith(tuple(starts.split()))) or ends


def _unit_of(text: str, role: str, *, bracketed: bool) -> str | None:
    spelled = _SPELLED[role]
    if not bracketed and text.lower() in _SHORT and text not in ("V", "N", "A"):
        return None
    if text in spelled:
        return spelled[text]
    return spelled.get(text.lower()) if len(text) > 1 and text.lower() != "nm" else None


def _role_by_unit(unit: str) -> Role | None:
    roles: list[Role] = [role for role in ("time", "position", "input") if unit in SCALES[role]]
    return roles[0] if len(roles) == 1 else None
