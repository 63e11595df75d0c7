"""The page's server in a thread of the test."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Thread
from typing import Any

import stepid


@contextmanager
def serving(campaign: stepid.Campaign | None = None) -> Iterator[Any]:
    """A server in a thread of its own."""
    from stepid.webapp.views.serve import server

    ready: list[Any] = []

    def work() -> None:
        asyncio.set_event_loop(asyncio.new_event_loop())
        made = server(campaign, 0)
        made.start()
        made.io_loop.add_callback(ready.append, made)
        made.io_loop.start()

    thread = Thread(target=work, daemon=True)
    thread.start()
    while not ready:
        thread.join(0.05)
        assert ready or thread.is_alive()
    yield ready[0]
    ready[0].io_loop.add_callback(ready[0].stop)
    ready[0].io_loop.add_callback(ready[0].io_loop.stop)
    thread.join(10)
