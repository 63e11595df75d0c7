"""Functions whose results know where they come from."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from contextvars import ContextVar
from functools import wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import ParamSpec, TypeVar

from stepid.core.base import Model
from stepid.core.provenance import Provenance, made_now

P = ParamSpec("P")
R = TypeVar("R")
_READ: ContextVar[list[tuple[Path, str]] | None] = ContextVar("files read", default=None)
_NO_SETTINGS = {"workers", "progress", "executor"}  # what the answer does not depend on


def note_read(path: Path, raw: bytes) -> None:
    """Tell the function that reads a file what its bytes were."""
    read = _READ.get()
    if read is not None:
        read.append((path, hashlib.sha256(raw).hexdigest()))


def recorded(**chosen: Callable[[], object]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Have a function's results bear their `Provenance`.

    Positional arguments are the data; keyword-only ones are the settings. Only the outermost of nested functions tells,
    and whichever reads files.

    Parameters
    ----------
    **chosen : callable
        What the function takes where a keyword is None: ``criteria=Criteria``.

    Returns
    -------
    callable
        A decorator.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        takes = signature(function)
        keywords = {n for n, p in takes.parameters.items() if p.kind is Parameter.KEYWORD_ONLY} - _NO_SETTINGS

        @wraps(function)
        def inner(*args: P.args, **kwargs: P.kwargs) -> R:
            around, read = _READ.get(), list[tuple[Path, str]]()
            token = _READ.set(read)
            try:
                result = function(*args, **kwargs)
            finally:
                _READ.reset(token)
            if around is not None:
                around += read
            if around is None or read:
                given = takes.bind(*args, **kwargs)
                given.apply_defaults()
                data = [value for name, value in given.arguments.items() if name not in keywords | _NO_SETTINGS]
                settings = {n: v for n, v in given.arguments.items() if n in keywords}
                _stamp(result, made_now(function.__name__, read=read, data=data, settings=_filled(settings, chosen)))
            return result

        return inner

    return decorate


def _filled(settings: Mapping[str, object], chosen: Mapping[str, Callable[[], object]]) -> dict[str, object]:
    return {n: chosen[n]() if value is None and n in chosen else value for n, value in settings.items()}


def _stamp(result: object, provenance: Provenance) -> None:
    if isinstance(result, Model):
        if result.provenance is None:
            result._provenance = provenance
    elif isinstance(result, list | tuple):
        for one in result:
            _stamp(one, provenance)
