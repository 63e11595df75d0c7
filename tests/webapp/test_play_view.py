"""The part of the page that one plays with, without a browser: knobs turn what is drawn."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import stepid
from stepid.webapp.play import NONE
from stepid.webapp.views.play import PlayView
from stepid.webapp.work import Status, Work


def at_once(work: Work[Any], done: Callable[[Status[Any]], None]) -> None:
    assert work.start().wait(60)
    done(work.status)


@pytest.fixture(scope="module")
def campaign() -> stepid.Campaign:
    return stepid.datasets.lab_campaign()[["case 4", "case 5"]]


@pytest.fixture
def view(campaign: stepid.Campaign) -> PlayView:
    out = PlayView(at_once)
    out.begin(campaign)
    return out


def left(view: PlayView) -> float:
    """µm, as the page says it."""
    text = str(view._left.object)
    return float(text[: text.index(" µm RMS are left")].rpartition(">")[2])


def test_it_begins_with_the_linear_plant(view: PlayView, campaign: stepid.Campaign) -> None:
    assert view._body.visible
    assert view._run.options == ["case 4", "case 5"]
    assert view._effect.value == NONE
    assert view._fit.disabled
    assert left(view) > 100
    one = next(iter(view._sliders.values()))
    before = left(view)
    one.value = one.value * 1.02
    assert left(view) != before
    view._back.clicks += 1
    assert left(view) == before


def test_a_knob_of_an_effect_closes_the_gap_and_a_fit_turns_it_there(view: PlayView) -> None:
    view._effect.value = "coulomb_friction"
    assert not view._fit.disabled
    assert "What a lab sees" in str(view._seen.object)
    faint = left(view)
    view._fit.clicks += 1
    assert view._sliders["coulomb_friction.level"].value == pytest.approx(0.3, abs=0.03)
    assert left(view) < 40 < faint
    view._run.value = "case 5"
    assert left(view) < 40
    view._effect.value = NONE
    assert view._fit.disabled
    assert view._seen.object == ""


def test_what_fails_is_said_and_what_is_gone_is_hidden(view: PlayView) -> None:
    view._take(Status(running=False, failure="no plant"))
    assert "no plant" in str(view._message.object)
    view.clear("Files are missing.")
    assert not view._body.visible
    assert "Files are missing." in str(view._message.object)
    view._effect.value = "coulomb_friction"  # nothing to draw with, and no error
    view._fit.clicks += 1
    assert not view._body.visible
