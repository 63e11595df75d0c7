"""Work beside the page: progress is told, cancel ends it, errors are words, a closed page ends it."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

import stepid
import webapp_files as files
from stepid.errors import InputError
from stepid.webapp.session import Session
from stepid.webapp.work import Tell, Work


def endless(tell: Tell) -> str:
    while True:
        time.sleep(0.005)
        tell(stepid.Progress("still", best=("coulomb_friction",), left=3, promise=0.5))


def until(met: Callable[[], bool], seconds: float = 30.0) -> bool:
    end = time.monotonic() + seconds
    while not met() and time.monotonic() < end:
        time.sleep(0.01)
    return met()


def test_progress_is_told_and_cancel_ends_it() -> None:
    work = Work(endless).start()
    assert until(lambda: work.status.stage == "still")
    assert work.status.stage.best == ("coulomb_friction",)
    assert work.status.seconds > 0
    work.cancel()
    assert work.wait(5)
    assert work.status.canceled
    assert not work.status.running
    assert work.status.result is None


def test_work_ends_when_nobody_wants_it() -> None:
    wanted = [True]
    work = Work(endless, wanted=lambda: wanted[0]).start()
    assert until(lambda: work.status.stage == "still")
    wanted[0] = False
    assert work.wait(5)
    assert work.status.canceled


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (InputError("the run is bad", "Record it again."), "the run is bad. Record it again."),
        (ZeroDivisionError("oh"), "stepid itself failed: ZeroDivisionError: oh"),
    ],
)
def test_errors_are_words(error: Exception, said: str) -> None:
    def failing(_: Tell) -> None:
        raise error

    work = Work(failing).start()
    assert work.wait(5)
    assert work.status.failure.startswith(said)
    assert not work.status.canceled


def test_a_diagnosis_of_a_session() -> None:
    session = Session(stepid.datasets.lab_campaign()[["case 4", "case 5", "case 6"]])
    work = session.diagnose(stepid.Effort.quick())
    assert not session.take() or not work.status.running
    assert work.wait(120)
    assert session.take()
    assert session.found is not None
    assert session.found.effects == ("coulomb_friction",)
    session.edit(0, "name", "other")  # what was found was of another campaign
    assert session.found is None
    session.close()


def test_a_change_of_the_campaign_and_a_closed_page_end_the_diagnosis() -> None:
    session = Session(stepid.datasets.lab_campaign())
    first = session.diagnose()
    session.edit(0, "added_mass", "1.1")
    assert session.work is None
    second = session.diagnose()
    session.watched = lambda: False  # the page was closed; its session lingers a while
    assert first.wait(5)
    assert second.wait(5)
    assert first.status.canceled
    assert second.status.canceled
    session.close()


def test_a_single_run_is_refused_in_words() -> None:
    session = Session()
    session.drop({"run_0kg.csv": files.recording(0.0)})
    work = session.diagnose()
    assert work.wait(60)
    assert "has one run" in work.status.failure
    session.close()
