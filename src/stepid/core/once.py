"""Answers that are kept as long as what they are about lives."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

T = TypeVar("T", bound=Callable[..., Any])
_ITSELF = object()


def once(compute: T) -> T:
    """Compute once for each object, told by its identity, and each further argument: for objects that never change.

    Parameters
    ----------
    compute : callable
        Of an object that can be weakly referenced and further arguments that can be hashed, given by position.

    Returns
    -------
    callable
        The same; answers are forgotten with their object. Results are shared, and are not to be changed.
    """
    known: dict[int, dict[tuple[Any, ...], Any]] = {}

    @wraps(compute)
    def kept(about: Any, *more: Any) -> Any:
        key = id(about)
        answers = known.get(key)
        if answers is None:
            answers = known[key] = {}
            weakref.finalize(about, known.pop, key, None).atexit = False
        if more not in answers:
            found = compute(about, *more)
            answers[more] = _ITSELF if found is about else found  # what is kept would keep it alive
        return about if answers[more] is _ITSELF else answers[more]

    return kept  # type: ignore[return-value]
