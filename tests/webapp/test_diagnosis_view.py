"""The part of the page that shows a diagnosis: answer first, numbers beside it, what nobody needs at once folded."""

from __future__ import annotations

import re
from collections.abc import Callable
from html import unescape
from typing import Any

import panel as pn
import pytest

import diagnosis_example as example
from stepid.diagnosis.headline import answer
from stepid.diagnosis.progress import Progress
from stepid.diagnosis.result import Diagnosis
from stepid.report.equation import numbers
from stepid.webapp.session import Session
from stepid.webapp.views.diagnosis import DiagnosisView
from stepid.webapp.work import Status, Work


def at_once(work: Work[Any], done: Callable[[Status[Any]], None]) -> None:
    work.start().wait()
    done(work.status)


def shown(d: Diagnosis) -> pn.Column:
    view = DiagnosisView(Session(), lambda: None, at_once, lambda: None)
    view.end(Status(stage=Progress("done"), seconds=1.0, running=False, result=d), None)
    return view._found


def words(part: object) -> str:
    """What stands in a part and in those inside, without marks; what is folded is left out."""
    if isinstance(part, pn.Card):
        return ""
    if isinstance(part, pn.pane.HTML):
        return unescape(re.sub(r"<[^>]+>", " ", str(part.object))).replace("\u00a0", " ")
    return " ".join(map(words, getattr(part, "objects", ())))


def test_the_numbers_that_were_found_are_seen_at_once() -> None:
    d = example.named()
    found = shown(d)
    head = words(found[0])
    assert head.strip().startswith(answer(d))
    assert all(value in head for _, value in numbers(d))
    assert "(m₀ + added mass) a" in head
    open_there = words(found)
    assert "The joint fit" in open_there
    assert open_there.index("Value ± standard uncertainty") < open_there.index("The gap by run")
    titles = [card.title for card in found if isinstance(card, pn.Card)]
    assert titles == ["Where they part", "The whole answer as text"]


def test_the_answer_is_there_before_its_pictures() -> None:
    """And what may be clicked below it when they stand: nothing moves it away any more."""
    d, waiting, stands = example.named(), [], []
    view = DiagnosisView(
        Session(),
        lambda: None,
        lambda work, done: waiting.append((work, done)),
        lambda: stands.append(words(view._found)),
    )
    view.end(Status(stage=Progress("done"), seconds=1.0, running=False, result=d), None)
    assert words(view._found).strip().startswith(answer(d))
    assert words(view._found).endswith("Drawing the pictures … ")
    late = waiting[:]
    assert not stands
    at_once(*waiting.pop())
    assert len(stands) == 1
    assert "The joint fit" in stands[0]
    assert "Drawing" not in words(view._found)
    assert "The joint fit" in words(view._found)
    view.clear(ready=True)
    late[0][1](late[0][0].status)  # pictures of an answer that is gone
    assert words(view._found) == ""
    assert len(stands) == 1


def test_an_answer_does_not_go_without_a_word() -> None:
    view = DiagnosisView(Session(), lambda: None, at_once, lambda: None)
    view.clear(ready=True)
    assert words(view._progress) == ""  # there was none
    view.end(Status(stage=Progress("done"), seconds=1.0, running=False, result=example.named()), None)
    view.clear(ready=True)
    assert "The answer was of those before: diagnose again." in words(view._progress)
    view.clear(ready=True)  # it is gone
    assert words(view._progress) == ""


def test_what_would_close_an_open_choice_stands_beside_it() -> None:
    head = words(shown(example.ambiguous())[0])
    assert re.search(r"Most likely Coulomb friction, 0\.\d+ ± 0\.\d+ N; these data do not tell it from", head)
    assert "load proportional friction.  Record with more mass." in re.sub(r"\s{2,}", "  ", head)


@pytest.mark.parametrize(("promise", "said"), [(0.0, "7"), (0.2, "7; the most promising may explain 20 %")])
def test_progress_says_what_is_left_to_try(promise: float, said: str) -> None:
    view = DiagnosisView(Session(), lambda: None, at_once, lambda: None)
    view.watch(Status(stage=Progress("cogging", left=7, promise=promise), seconds=1.0, running=True))
    assert f"<dt>left to try</dt><dd>{said}" in view._progress.object
