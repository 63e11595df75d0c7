"""The whole page of a session without a browser: what follows from files, edits and choices."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import pytest

import webapp_files
from stepid.webapp.session import Session
from stepid.webapp.views.page import Page
from stepid.webapp.work import Status


class Clock:
    """Stands for the server's clock: it runs until it is stopped."""

    def __init__(self) -> None:
        self.running = True

    def start(self) -> None:
        self.running = True

    def stop(self) -> None:
        self.running = False


@pytest.fixture
def page(monkeypatch: pytest.MonkeyPatch) -> Iterator[Page]:
    monkeypatch.setattr("panel.state.add_periodic_callback", lambda *_, **__: Clock())
    session = Session()
    yield Page(session)
    session.close()


def settle(page: Page) -> None:
    """As the clock would, until nothing works any more."""
    for _ in range(20):
        for work, _ in list(page._tasks):
            assert work.wait(60)
        page._tick()
        if not page._tasks:
            break
    assert not page._ticking.running


def typed(page: Page, row: int, key: str, value: str) -> None:
    page._records._edit(SimpleNamespace(row=row, column=key, value=value))


def test_files_become_parameters_and_something_to_play_with(page: Page) -> None:
    assert not page._rest.visible
    assert "Not computed yet" in str(page._by_hand._text.object)
    page.session.drop(webapp_files.three())
    page._records_changed()
    assert page._rest.visible
    assert "Computing" in str(page._by_hand._text.object)
    settle(page)
    assert len(page._by_hand._pictures) == 3
    assert page._play._body.visible
    assert not page._diagnosis._start.disabled
    assert [table.caption for table in page._tables()] == [table.caption for table in page._by_hand.tables]
    assert page._tables()


def test_an_edit_takes_what_was_found_away_until_it_is_found_anew(page: Page) -> None:
    page.session.drop(webapp_files.three(named=False))
    page._records_changed()
    assert "Which masses were added?" in str(page._records._message.object)
    assert not page._tables()
    for row, mass in enumerate(("0", "0.5", "1")):
        typed(page, row, "added_mass", mass)
    assert not str(page._records._message.object)
    settle(page)
    before = page._by_hand._text.object
    typed(page, 2, "added_mass", "a lot")
    assert "a lot" in str(page._records._message.object)
    assert page.session.rows[2].added_mass == 1.0
    assert page._by_hand._text.object == before  # nothing changed
    assert "The value before stays." in str(page._records._message.object)
    assert str(page._records._table.value["added_mass"][2]) == "1"
    typed(page, 2, "added_mass", "1.1")
    # where it is typed before the value before is back in the browser, that would hide it
    assert str(page._records._table.value["added_mass"][2]) == "1.1"
    assert "Computing" in str(page._by_hand._text.object)
    settle(page)
    assert page._by_hand._text.object != before


def test_a_run_is_renamed_and_left_out(page: Page) -> None:
    page.session.drop(webapp_files.three())
    page._records_changed()
    typed(page, 0, "name", "first")
    assert page.session.rows[0].name == "first"
    assert "first <small>" in str(page._records._heads[0].object)
    names = [row.name for row in page.session.rows]
    page._records._choose(SimpleNamespace(new=names[:2]))
    assert [run.name for run in page.session.campaign] == names[:2]
    assert [shown.visible for shown in page._records._pictures] == [True, True, False]
    page._records._choose(SimpleNamespace(new=[]))
    assert str(page._records._message.object)
    page._records._rename(SimpleNamespace(new="lab 3"))
    assert page.session.campaign.name == "lab 3"
    settle(page)


def test_a_run_is_renamed_while_the_files_leave_a_question_open(page: Page) -> None:
    page.session.drop({f"{kg}kg.csv": webapp_files.recording(kg, units=False) for kg in (0.0, 0.5)})
    page._records_changed()
    assert page.session.intake.questions
    typed(page, 0, "name", "first")
    assert page.session.rows[0].name == "first"


def test_a_diagnosis_that_fails_is_told(page: Page) -> None:
    page.session.drop(webapp_files.three())
    page._records_changed()
    page._diagnosis.end(Status(running=False, failure="no plant"), None)
    assert "no plant" in str(page._diagnosis._progress.object)
    page._diagnosis.end(Status(running=False, canceled=True), None)
    assert "Canceled." in str(page._diagnosis._progress.object)
    assert page._diagnosis._cancel.disabled
    settle(page)
