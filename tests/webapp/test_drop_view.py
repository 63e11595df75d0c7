"""The part of the page that takes files."""

from __future__ import annotations

from contextlib import suppress

import param
import pytest

import webapp_files
from stepid.webapp.session import Session
from stepid.webapp.views import drop


def test_the_same_files_told_twice_are_taken_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drop, "_PAUSE", 0.0)
    changes: list[int] = []
    session = Session()
    view = drop.DropView(session, lambda: changes.append(len(session.rows)))

    def dropped(files: dict[str, bytes]) -> None:
        with param.parameterized.discard_events(view._files):
            view._files.value = dict(files)
        waiting = view._drop(None)
        with suppress(StopIteration):  # by hand: a loop may be running in this thread
            while True:
                waiting.send(None)

    files = webapp_files.three()
    dropped(files)
    dropped(files)
    assert changes == [3]
    view._try(None)
    dropped(files)  # in place of the example
    assert changes == [3, 10, 3]
    session.close()
