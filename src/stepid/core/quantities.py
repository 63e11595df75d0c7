"""What plants measure, in words and units: a cart that moves along, or a disk that turns; driven by V, A, N or N·m.

All numbers are the same, whichever it is: the equations know no units. Texts are written for a cart driven in V, and
put into the words of another plant here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, ValuesView
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from itertools import chain
from typing import Any, Literal, NamedTuple, ParamSpec, TypeVar

from stepid.core.vocabulary import (
    is_word,
    translated_formula,
    translated_law,
    translated_page,
    translated_text,
    translated_unit,
)
from stepid.errors import StepidError

P = ParamSpec("P")
R = TypeVar("R")
Motion = Literal["translation", "rotation"]
InputUnit = Literal["V", "A", "N", "N·m"]
MOTIONS: tuple[Motion, ...] = ("translation", "rotation")
INPUT_UNITS: tuple[InputUnit, ...] = ("V", "A", "N", "N·m")
TORQUES = ("Nm", "N m", "N*m", "N.m", "N⋅m")
"""How keyboards without a middle dot write N·m."""

_NAMES = {"name", "run", "runs", "from_run", "to_run", "spring", "damper", "base", "campaign", "still", "kind"}
_LABELS = {"springs", "dampers", "bases", "row_labels", "column_labels", "covariance_labels", "effects"}
_KEYED = {"masses", "run_rms", "runs", "stiffness", "damping", "base_mass", "pooled_damping", "excluded"}
_Say = Callable[[str, str], str]


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
        kept = {name for name in names if self.text(name) != name and not is_word(name)}
        return self._replace(kept=self.kept | kept)

    def unit(self, unit: str) -> str:
        """Return what stands for a cart's unit: ``"kg·m²"`` for ``"kg"``, ``"rad/A"`` for ``"m/V"``."""
        return unit if self.usual else translated_unit(unit, self.motion, self.input_unit)

    def text(self, words: str) -> str:
        """Translate sentences: units and words such as "added mass", whole ones only; twice is as good as once."""
        return words if self.usual else translated_text(words, *self)

    def formula(self, latex: str) -> str:
        """Translate the symbols of a formula: mass, position and velocity are moment of inertia, angle and its rate."""
        return translated_formula(latex) if self.motion == "rotation" else latex

    def law(self, law: str) -> str:
        """Translate a law or an equation in plain text: its letters, and the words in it."""
        return self.text(translated_law(law)) if self.motion == "rotation" else law

    def html(self, page: str) -> str:
        """Translate what a page shows and says, not its tags, styles and scripts."""
        return page if self.usual else translated_page(page, *self)

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
