"""What plants measure, in words and units: a cart that moves along, or a disk that turns; driven by V, A, N or N·m.

All numbers are the same, whichever it is: the equations know no units. Texts are written for a cart driven in V, and
put into the words of another plant here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, ValuesView
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, wraps
from html import escape
from itertools import chain
from typing import Any, Literal, NamedTuple, ParamSpec, TypeVar

from stepid.errors import StepidError

P = ParamSpec("P")
R = TypeVar("R")
Motion = Literal["translation", "rotation"]
InputUnit = Literal["V", "A", "N", "N·m"]
MOTIONS: tuple[Motion, ...] = ("translation", "rotation")
INPUT_UNITS: tuple[InputUnit, ...] = ("V", "A", "N", "N·m")
TORQUES = ("Nm", "N m", "N*m", "N.m", "N⋅m")
"""How keyboards without a middle dot write N·m."""

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
_VOLTS = {"A": "amperes", "N": "newtons", "N·m": "newton meters"}
_ATOM = r"(?:kg|[mcµ]?m|m?[NVA]|m?s|[mcµ]?rad|1)(?:[²³]|\^\w+)?"
_PART = rf"(?:{_ATOM}|\({_ATOM}(?:[·/]{_ATOM})*\)(?:\^\w+)?)"
_UNIT = rf"{_PART}(?:[·/]{_PART})*"
_NAMES = {"name", "run", "runs", "from_run", "to_run", "spring", "damper", "base", "campaign", "still", "kind"}
_LABELS = {"springs", "dampers", "bases", "row_labels", "column_labels", "covariance_labels", "effects"}
_KEYED = {"masses", "run_rms", "runs", "stiffness", "damping", "base_mass", "pooled_damping", "excluded"}
_TAGS = re.compile(r"(<(?:style|script)\b.*?</(?:style|script)>|<[^>]+>)", re.DOTALL)
_Say = Callable[[str, str], str]
_SAID_BY_TAGS = re.compile(r'(?<=\s)((?:alt|title|aria-label)=")([^"]*)(?=")')


class Quantities(NamedTuple):
    """How a plant moves, what drives it, and names of the user's own, which are not words.

    `kept` are runs and labels whose names hold words that would change.
    """

    motion: str = "translation"
    input_unit: str = "V"
    kept: frozenset[str] = frozenset()

    @property
    def usual(self) -> bool:
        """True for a cart driven in V: there is nothing to translate."""
        return self.motion == "translation" and self.input_unit == "V"

    def keeping(self, names: Iterable[str]) -> Quantities:
        """Return the same that leave names alone, but for those that are nothing but a word, as the base "cart"."""
        if self.usual:
            return self
        kept = {name for name in names if self.text(name) != name and not _a_word(name)}
        return self._replace(kept=self.kept | kept)

    def unit(self, unit: str) -> str:
        """Return what stands for a cart's unit: ``"kg·m²"`` for ``"kg"``, ``"rad/A"`` for ``"m/V"``."""
        return unit if self.usual else _translated(unit, self)

    def text(self, words: str) -> str:
        """Translate sentences: units and words such as "added mass", whole ones only; twice is as good as once."""
        return words if self.usual else _pattern(self).sub(lambda found: _one(found, self), words)

    def formula(self, latex: str) -> str:
        """Translate the symbols of a formula: mass, position and velocity are moment of inertia, angle and its rate."""
        if self.motion == "translation":
            return latex
        return _SYMBOL.sub(lambda found: _TURNED_SYMBOLS[found[0]], latex)

    def html(self, page: str) -> str:
        """Translate what a page shows and says, not its tags, styles and scripts."""
        if self.usual:
            return page
        parts = _TAGS.split(page)
        shown = [self.text(part) if i % 2 == 0 else self._tag(part) for i, part in enumerate(parts)]
        return "".join(shown)

    def _tag(self, tag: str) -> str:
        if tag.startswith(("<style", "<script")):
            return tag
        return _SAID_BY_TAGS.sub(lambda found: found[1] + self.text(found[2]), tag)

    def result(self, value: R, *, words: bool = False) -> R:
        """Translate units and sentences in results and all that they hold, and have them know it.

        Parameters
        ----------
        value : model, error, text, or mapping or sequence of such
            Not changed, unless it is an error; what is something else is returned as it is.
        words : bool
            Translate single words, too, not only units and sentences.
        """

        def say(text: str, field: str) -> str:
            if field == "unit":
                return self.unit(text)
            sentence = (words or " " in text) and field not in _NAMES and field not in _LABELS
            return self.text(text) if sentence else text

        return value if self.usual else self._any(value, "", say)

    def bear(self, value: R) -> R:
        """Return results that know these quantities, their texts as they are."""
        return value if self.usual else self._any(value, "", lambda text, _: text)

    def _any(self, value: Any, field: str, say: _Say) -> Any:
        if isinstance(value, str):
            return say(value, field)
        if isinstance(value, StepidError):
            return self.error(value)
        if hasattr(type(value), "model_fields"):
            return self._model(value, say)
        if isinstance(value, Mapping):
            return {key: self._any(one, "unit" if key == "unit" else field, say) for key, one in value.items()}
        if isinstance(value, tuple) and hasattr(value, "_fields"):
            return type(value)(*(self._any(one, field, say) for one in value))
        if isinstance(value, tuple | list):
            return type(value)(self._any(one, field, say) for one in value)
        return value

    def _model(self, model: Any, say: _Say) -> Any:
        fields = type(model).model_fields
        changed = {name: self._any(getattr(model, name), name, say) for name in fields}
        for name, own in (("motion", self.motion), ("input_unit", self.input_unit)):
            if name in fields:
                changed[name] = own
        copy = model.model_copy()
        object.__setattr__(copy, "__dict__", changed)  # without what was cached of the old words
        copy._quantities = self
        return copy

    def error(self, error: StepidError) -> StepidError:
        """Translate the message of an error, and return it."""
        if not self.usual:
            error.cause, error.remedy = self.text(error.cause), self.text(error.remedy)
            error.args = tuple(self.text(part) if isinstance(part, str) else part for part in error.args)
        return error

    @contextmanager
    def spoken(self) -> Iterator[None]:
        """Have tables be laid out, and errors raised, in these quantities."""
        token = _SPOKEN.set(self)
        try:
            yield
        except StepidError as error:
            self.error(error)
            raise
        finally:
            _SPOKEN.reset(token)


CART = Quantities()
"""A cart driven in V, for which all texts are written."""
_SPOKEN: ContextVar[Quantities] = ContextVar("quantities that are spoken", default=CART)


def spoken_now() -> Quantities:
    """Quantities in which tables are laid out at present."""
    return _SPOKEN.get()


def quantities_of(thing: object) -> Quantities:
    """Return the quantities of a campaign, a run or a result; `CART` where they are not known."""
    own = getattr(thing, "_quantities", None)
    if isinstance(own, Quantities):
        return own
    motion, input_unit = getattr(thing, "motion", "translation"), getattr(thing, "input_unit", "V")
    if (motion, input_unit) == CART[:2] or motion not in MOTIONS or input_unit not in INPUT_UNITS:
        return CART
    return named(motion, input_unit, thing)


def named(motion: str, input_unit: str, thing: object = None) -> Quantities:
    """Return quantities that keep the names in a campaign or result."""
    return Quantities(motion, input_unit).keeping(_names(thing))


def _a_word(name: str) -> bool:
    """Whether a name is one of the words, as the label "cart" that a base has by itself."""
    return name.lower() in _WORDS or re.fullmatch(_UNIT, name) is not None


def _names(thing: object, field: str = "") -> Iterator[str]:
    if isinstance(thing, str):
        if field in _NAMES | {"springs", "dampers", "bases"}:
            yield thing
    elif fields := getattr(type(thing), "model_fields", None):
        for name in fields:
            yield from _names(getattr(thing, name), name)
    elif isinstance(thing, Mapping):
        if field in _KEYED:
            yield from (key for key in thing if isinstance(key, str))
        yield from chain.from_iterable(_names(one, field) for one in thing.values())
    elif isinstance(thing, tuple):
        yield from chain.from_iterable(_names(one, field) for one in thing)


def middle_dot(unit: object) -> object:
    """Return a unit of torque as N·m, however a keyboard without a middle dot writes it."""
    return "N·m" if isinstance(unit, str) and unit in TORQUES else unit


def spoken(method: Callable[P, R]) -> Callable[P, R]:
    """Have a method that writes text or a table write it in the quantities of its own object."""
    page = method.__name__ == "_repr_html_"
    marked = method.__name__ == "to_latex"  # its parts are translated before they are typeset

    @wraps(method)
    def inner(*args: P.args, **kwargs: P.kwargs) -> R:
        quantities = quantities_of(args[0])
        if quantities.usual:
            return method(*args, **kwargs)
        with quantities.spoken():
            out = method(*args, **kwargs)
        if not isinstance(out, str) or marked:
            return out
        return quantities.html(out) if page else quantities.text(out)  # type: ignore[return-value]

    return inner


def in_own_quantities(function: Callable[P, R]) -> Callable[P, R]:
    """Have a function speak of its data in their own quantities: its results, its texts and its errors."""

    @wraps(function)
    def inner(*args: P.args, **kwargs: P.kwargs) -> R:
        quantities = next((q for q in map(_given, chain(args, kwargs.values())) if not q.usual), CART)
        if quantities.usual:
            return function(*args, **kwargs)
        with quantities.spoken():
            out = function(*args, **kwargs)
        return quantities.text(out) if isinstance(out, str) else quantities.result(out)  # type: ignore[return-value]

    return inner


def _given(value: object) -> Quantities:
    """Quantities of an argument, or of the first thing in it."""
    if isinstance(value, Mapping):
        value = value.values()
    if isinstance(value, tuple | list | ValuesView):
        value = next(iter(value), None)
    return quantities_of(value)


@cache
def _pattern(q: Quantities) -> re.Pattern[str]:
    """One expression for names that are kept, words, and units."""
    kept = sorted({form for name in q.kept for form in (name, escape(name))}, key=len, reverse=True)
    own = "|".join(map(re.escape, kept)) or "(?!)"
    turned = q.motion == "rotation"
    words = "|".join(map(re.escape, sorted(_WORDS, key=len, reverse=True))) if turned else "(?!)"
    symbol = r"m(?=·ω|\[)" if turned else "(?!)"
    volts = r"volts?" if q.input_unit != "V" else "(?!)"
    return re.compile(
        rf"(?P<kept>(?<!\w)(?:{own})(?!\w))"
        rf"|(?<![\w/\\.'\"-])(?P<article>[Aa] )?(?P<word>(?i:{words}))(?![\w(:]|[-.]\w|\s?=)"
        rf"|(?<![\w·/\\])(?P<symbol>{symbol})"
        rf"|(?<![\w-])(?P<volts>{volts})(?!\w)"
        rf"|(?<![\w·/²³'\"\\$-])(?P<unit>{_UNIT})(?![\w·/'\"\\$(\[{{=]|\s?=|-\w)"
    )


def _one(found: re.Match[str], q: Quantities) -> str:
    if found["word"] is not None:
        said = _WORDS[found["word"].lower()]
        if found["word"][0].isupper():
            said = said[0].upper() + said[1:]
        article = found["article"] or ""
        return f"{article.rstrip()}n {said}" if article and said[0].lower() in "aeio" else article + said
    if found["symbol"]:
        return "J"
    if found["volts"]:
        plural = _VOLTS[q.input_unit]
        return plural if found["volts"] == "volts" else plural[:-1]
    return _translated(found["unit"], q) if found["unit"] else found[0]


@cache
def _translated(unit: str, q: Quantities) -> str:
    """Translate a unit, simple or compound, atom by atom; one that was translated stays as it is."""
    turns = q.motion == "rotation" and "N·m" not in unit and "kg·m²" not in unit

    def atom(found: re.Match[str]) -> str:
        prefix, symbol = found["prefix"], found["symbol"]
        if symbol == "V" and q.input_unit != "V":
            own = prefix + q.input_unit
            return f"({own})" if "·" in own and found.start() and unit[found.start() - 1] == "/" else own
        return _TURNED.get(prefix + symbol, found[0]) if turns else found[0]

    return re.sub(r"(?<![A-Za-zµ])(?P<prefix>[mcµ]?)(?P<symbol>kg|[mNV])(?![A-Za-z])", atom, unit)
