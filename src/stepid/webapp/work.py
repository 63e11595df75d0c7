"""Long work beside the page: it tells how far it is, and ends soon after nobody waits for it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from threading import Event, Thread
from typing import Generic, TypeVar

from stepid.diagnosis.progress import Progress
from stepid.errors import StepidError

T = TypeVar("T")
Tell = Callable[[Progress], None]


_FIRST = Progress("starting")


class CanceledError(Exception):
    """Raised within the work, at the next stage that it tells."""


@dataclass(frozen=True)
class Status(Generic[T]):
    """How far work is: its last stage, the seconds that it took so far, and how it ended.

    `result` is there once it is done; `failure` says why there is none.
    """

    stage: Progress = _FIRST
    seconds: float = 0.0
    running: bool = True
    result: T | None = None
    failure: str = ""
    canceled: bool = False


class Work(Generic[T]):
    """One piece of work in a thread of its own.

    Parameters
    ----------
    task : callable
        Takes a function that it calls with each `Progress`; an exception raised there ends it.
    wanted : callable
        Asked at each stage; the work ends where it says False, as when its page was closed.
    """

    def __init__(self, task: Callable[[Tell], T], *, wanted: Callable[[], bool] = lambda: True) -> None:
        self._task, self._wanted = task, wanted
        self._stop = Event()
        self._began = time.monotonic()
        self._status: Status[T] = Status()
        self._thread = Thread(target=self._run, daemon=True, name="stepid work")

    def start(self) -> Work[T]:
        """Begin."""
        self._began = time.monotonic()
        self._thread.start()
        return self

    def cancel(self) -> None:
        """Ask it to end at its next stage; what it still finds is not kept."""
        self._stop.set()

    def wait(self, seconds: float | None = None) -> bool:
        """Wait for its end; say whether it came."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    @property
    def status(self) -> Status[T]:
        """How far it is now."""
        now = self._status
        return replace(now, seconds=time.monotonic() - self._began) if now.running else now

    def _tell(self, stage: Progress) -> None:
        if self._stop.is_set() or not self._wanted():
            raise CanceledError
        self._status = replace(self._status, stage=stage)

    def _run(self) -> None:
        result, failure, canceled = None, "", False
        try:
            result = self._task(self._tell)
        except CanceledError:
            canceled = True
        except StepidError as error:
            failure = str(error)
        except Exception as error:  # a fault of ours must not leave the page waiting
            failure = f"stepid itself failed: {type(error).__name__}: {error}. Please report it with your campaign."
        if self._stop.is_set():
            result, canceled = None, True
        self._status = replace(
            self.status, running=False, result=result, failure=failure, canceled=canceled and not failure
        )
