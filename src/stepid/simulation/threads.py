"""One thread for the linear algebra: its matrices are small, and more threads than cores wait for each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache, wraps
from threading import Lock
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


@cache
def _libraries() -> ThreadpoolController:
    """The BLAS libraries that are loaded, looked up once: numpy's does all the work here."""
    return ThreadpoolController()


class _Limit:
    """One limit for all that run at a time: the first to come sets it, the last to go takes it back."""

    def __init__(self) -> None:
        self._lock, self._inside, self._set = Lock(), 0, ExitStack()

    @contextmanager
    def held(self) -> Iterator[None]:
        with self._lock:
            if not self._inside:
                self._set.enter_context(_libraries().limit(limits=1, user_api="blas"))
            self._inside += 1
        try:
            yield
        finally:
            with self._lock:
                self._inside -= 1
                if not self._inside:
                    self._set.close()


_limit = _Limit()


def single_threaded(function: Callable[P, R]) -> Callable[P, R]:
    """Run a function with the BLAS libraries held to one thread; once none runs any more they are as before."""

    @wraps(function)
    def inner(*args: P.args, **kwargs: P.kwargs) -> R:
        with _limit.held():
            return function(*args, **kwargs)

    return inner
