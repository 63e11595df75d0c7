"""The linear algebra keeps to one thread while anything runs, and is as before once nothing does."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from threading import Event
from types import SimpleNamespace

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from stepid.simulation import threads
from stepid.simulation.threads import single_threaded


def blas() -> set[int]:
    np.linalg.norm(np.eye(2))
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def test_of_two_that_overlap_the_last_takes_the_limit_back(monkeypatch: pytest.MonkeyPatch) -> None:
    first_began, second_began, first_ended, said = Event(), Event(), Event(), []

    @contextmanager
    def limit(limits: int, user_api: str) -> Iterator[None]:
        said.append((limits, user_api))
        yield
        said.append("as before")

    monkeypatch.setattr(threads, "_libraries", lambda: SimpleNamespace(limit=limit))

    @single_threaded
    def first() -> None:
        first_began.set()
        assert second_began.wait(20)

    @single_threaded
    def second() -> list[object]:
        second_began.set()
        assert first_ended.wait(20)
        return list(said)

    with ThreadPoolExecutor(2) as pool:
        one = pool.submit(first)
        assert first_began.wait(20)
        two = pool.submit(second)
        one.result(20)
        first_ended.set()
        assert two.result(20) == [(1, "blas")]
    assert said == [(1, "blas"), "as before"]


def test_an_error_leaves_no_limit() -> None:
    @single_threaded
    def failing() -> None:
        assert blas() == {1}
        raise ValueError("no")

    with threadpool_limits(2, "blas"):
        before = blas()
        with pytest.raises(ValueError, match="no"):
            failing()
        assert blas() == before
