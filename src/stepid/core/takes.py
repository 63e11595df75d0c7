"""Arguments of public functions, checked before anything else is done: each refusal names argument and remedy."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from numbers import Integral, Real
from typing import Any, ParamSpec, TypeVar

from stepid.errors import InputError

P = ParamSpec("P")
R = TypeVar("R")
Check = Callable[[Any], Any]
"""Returns the value that the function gets, or raises `WantedError`."""
_PLAIN = (str, bytes, bool, int, float, complex, type(None))
_FEW = 8  # items of a value in a message
_SHOWN = 60  # letters of a value in a message


class WantedError(Exception):
    """What a value should have been."""


def takes(**checks: Check) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Check arguments of a function by name; those that are left out keep their defaults.

    Parameters
    ----------
    **checks
        Argument to the check of its value.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        signature = inspect.signature(function)
        name = function.__name__

        @wraps(function)
        def checked(*args: P.args, **kwargs: P.kwargs) -> R:
            given = signature.bind(*args, **kwargs)
            for argument, check in checks.items():
                if argument in given.arguments:
                    given.arguments[argument] = taken(name, argument, given.arguments[argument], check)
            return function(*given.args, **given.kwargs)

        return checked

    return decorate


def taken(function: str, argument: str, value: object, check: Check) -> Any:
    """Return a value as its check takes it; InputError names the argument and says what it should be."""
    try:
        return check(value)
    except WantedError as wanted:
        raise InputError(f"{function}: {argument} is {described(value)}", f"Give {wanted}.") from None


def described(value: object) -> str:
    """What a value is, in a few words."""
    if isinstance(value, type):
        return f"the class {value.__name__}"
    several = (
        isinstance(value, list | tuple | dict) and len(value) <= _FEW and all(isinstance(v, _PLAIN) for v in value)
    )
    if several or isinstance(value, _PLAIN):
        try:
            text = repr(value)
        except ValueError:  # Python writes no numbers of more than 4,300 digits
            return "a number of thousands of digits"
        return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
    return article(type(value).__name__)


def article(name: str) -> str:
    """Put "a" or "an" before a name."""
    return f"{'an' if name[:1] in 'aeiouAEIOU' else 'a'} {name}"


def one_of(words: Sequence[str], spelled: Callable[[object], object] = lambda value: value) -> Check:
    """Check of one of a few words, however `spelled` takes it."""

    def check(value: object) -> object:
        word = spelled(value)
        if not (isinstance(word, str) and word in words):
            raise WantedError(" or ".join(map(repr, words)))
        return word

    return check


def a(kind: type | tuple[type, ...], words: str) -> Check:
    """Check of an instance of a class."""

    def check(value: object) -> object:
        if not isinstance(value, kind):
            raise WantedError(words)
        return value

    return check


def able(method: str, words: str) -> Check:
    """Check of an object with a method; its class is none."""

    def check(value: object) -> object:
        if isinstance(value, type) or not callable(getattr(value, method, None)):
            raise WantedError(words)
        return value

    return check


def caller(words: str) -> Check:
    """Check of a function that can be called with one argument."""

    def check(value: object) -> object:
        if not callable(value):
            raise WantedError(words)
        try:
            inspect.signature(value).bind(None)
        except TypeError:
            raise WantedError(words) from None
        except ValueError:  # some functions written in C do not say what they take
            pass
        return value

    return check


def each(of: Check, words: str, *, least: int = 0) -> Check:
    """Check of several, in any iterable but text and mappings; they come as a tuple."""

    def check(value: object) -> tuple[Any, ...]:
        if isinstance(value, str | bytes | Mapping | type) or not isinstance(value, Iterable):
            raise WantedError(words)
        try:
            items = tuple(value)
        except TypeError:  # an array without dimension
            raise WantedError(words) from None
        if len(items) < least:
            raise WantedError(words)
        try:
            return tuple(map(of, items))
        except WantedError:
            raise WantedError(words) from None

    return check


def optional(of: Check) -> Check:
    """Check of what may be None, too."""

    def check(value: object) -> object:
        return None if value is None else of(value)

    return check


def number(words: str = "a finite number", *, above: float = -math.inf) -> Check:
    """Check of a finite number above a limit."""

    def check(value: object) -> object:
        try:
            good = (
                not isinstance(value, bool)
                and isinstance(value, Real)
                and math.isfinite(value)
                and float(value) > above
            )
        except (OverflowError, TypeError):  # an integer beyond all floats
            good = False
        if not good:
            raise WantedError(words)
        return value

    return check


def count(words: str = "a whole number, 1 or more", *, most: int = 10**6) -> Check:
    """Check of a whole number from 1 to `most`."""

    def check(value: object) -> int:
        if isinstance(value, bool) or not isinstance(value, Integral) or not 1 <= int(value) <= most:
            raise WantedError(words)
        return int(value)

    return check


def text(words: str = "text that is not empty") -> Check:
    """Check of text."""

    def check(value: object) -> str:
        if not isinstance(value, str) or not value:
            raise WantedError(words)
        return value

    return check
