"""How a model that has no words of its own is shown: on one line, and as a table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from stepid.core.base import Model

_LINE = 120  # letters of a line
_SHORT = 48  # of a value in it
_DIGITS = 10  # of a number
_ROWS = 40  # entries of a mapping in a table

HEADER = ("field", "value")


def one_line(model: Model) -> str:
    """Write a model on one line: what differs from the defaults, large values by their size."""
    fields = type(model).model_fields
    told = []
    for name, field in fields.items():
        value = getattr(model, name)
        if field.is_required() or not _is(value, field.get_default(call_default_factory=True)):
            told.append(f"{name}={_brief(value)}")
    kind, most = type(model).__name__, len(told)
    while most and len(_call(kind, told, most)) > _LINE:
        most -= 1
    return _call(kind, told, most)


def _call(kind: str, told: list[str], most: int) -> str:
    return f"{kind}({', '.join([*told[:most], *['…'] * (most < len(told))])})"


def rows(model: Model) -> list[tuple[str, str]]:
    """Fields of a model and their values with units; the entries of a short mapping one by one."""
    out: list[tuple[str, str]] = []
    for name in type(model).model_fields:
        out += _rows(name.replace("_", " "), getattr(model, name), partial(model._unit, name))
    return out


def _rows(name: str, value: object, unit: Callable[[str], str]) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping) and 0 < len(value) <= _ROWS:
        for key, one in value.items():
            yield f"{name} [{key}]", _measured(one, unit(key))
    elif isinstance(value, tuple) and value and all(isinstance(one, str) for one in value):
        for number, one in enumerate(value):
            yield (name if number == 0 else ""), str(one)
    else:
        yield name, value if isinstance(value, str) else _measured(value, unit(""))


def _measured(value: object, unit: str) -> str:
    """A number, or a few in brackets, with its unit; what is none as it is."""
    numbers = value if isinstance(value, tuple) else (value,)
    bare = numbers and all(isinstance(one, int | float) and not isinstance(one, bool) for one in numbers)
    return f"{_brief(value)} {unit}".rstrip() if bare else _brief(value)


def _is(value: object, default: object) -> bool:
    if isinstance(value, np.ndarray) or isinstance(default, np.ndarray):
        return False
    return type(value) is type(default) and value == default


def _brief(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"<{' × '.join(map(str, value.shape))} numbers>"
    if isinstance(value, Mapping):
        return "{}" if not value else f"<{_some(len(value), 'entry', 'entries')}>"
    if isinstance(value, tuple):
        short = f"({', '.join(map(_brief, value))}{',' * (len(value) == 1)})"
        return short if len(short) <= _SHORT else f"<{_some(len(value), 'item', 'items')}>"
    if isinstance(value, float):
        text = repr(value)
        return text if len(text) <= _DIGITS else f"{value:.6g}"
    text = repr(value) if not hasattr(value, "_repr_html_") else _model(value)
    return text if len(text) <= _SHORT else f"{text[: _SHORT - 1]}…"


def _model(value: object) -> str:
    said = value.__str__ if type(value).__name__ == "Estimate" else value.__repr__
    text = said()
    if len(text) <= _SHORT:
        return text
    name = getattr(value, "name", None)
    return f"<{type(value).__name__}{f' {name!r}' if isinstance(name, str) else ''}>"


def _some(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"
