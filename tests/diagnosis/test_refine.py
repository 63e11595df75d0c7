"""The readings looked at again by what the best answer leaves: wrong ones, their color, a floor read too high."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

import stepid
from broken_campaigns import NOISE, campaign, changed
from stepid.diagnosis.explore import linear_candidate
from stepid.diagnosis.refine import refined
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.problem import build


def plain(seed: int = 1) -> stepid.Campaign:
    return campaign(seed, masses=(0.0, 0.5, 1.5))


def with_floor(context: FitContext, floor: float) -> FitContext:
    return FitContext(context.records, context.linear, floor)


def test_clean_readings_are_left_as_they_are() -> None:
    context = prepare(plain())
    assert refined(context, linear_candidate(context)) is None


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ((80, 140, 260), r"Run 'case 2': 3 readings stand out by up to [\d.]+ µm\. They are left out\."),
        ((140,), r"Run 'case 2': 1 reading stands out by [\d.]+ µm\. It is left out\."),
    ],
)
def test_wrong_readings_that_only_the_best_answer_shows_are_left_out(at: tuple[int, ...], said: str) -> None:
    clean = prepare(plain())
    y, begin = clean.records.position.copy(), int(clean.records.first[1])
    y[[begin + i for i in at]] += 20 * NOISE
    records = replace(clean.records, position=y)
    linear = minimize(build(records, ()), clean.linear.shared, clean.linear.local)
    assert linear is not None
    context = FitContext(records, linear, clean.floor)
    found = refined(context, linear_candidate(context))
    assert found is not None
    (fault,) = found.faults
    assert (fault.run, fault.kind, fault.unit) == ("case 2", "outliers", "m")
    assert fault.size == pytest.approx(20 * NOISE, rel=0.3)
    assert re.fullmatch(said, fault.words)
    assert (found.records.weight < 0.5).sum() == len(at)


@pytest.mark.parametrize(("times", "taken"), [(300.0, True), (20.0, False)])
def test_readings_that_bend_the_fit_are_left_out_where_they_are_most_of_the_misfit(times: float, taken: bool) -> None:
    """A misfit is smooth from sample to sample: most of its power is never in isolated readings."""
    clean = prepare(plain())
    y, first = clean.records.position.copy(), int(clean.records.first[1])
    y[[first + 140, first + 143]] += times * NOISE
    records = replace(clean.records, position=y)
    linear = minimize(build(records, ()), clean.linear.shared, clean.linear.local)
    assert linear is not None
    context = FitContext(records, linear, clean.floor / 4)  # the rest of the residual is more than noise
    found = refined(context, linear_candidate(context))
    assert (found is not None and [fault.kind for fault in found.faults] == ["outliers"]) == taken


def test_a_floor_that_was_read_too_high_is_lowered() -> None:
    context = prepare(plain())
    high = with_floor(context, 3 * context.floor)
    found = refined(high, linear_candidate(context))
    assert found is not None
    assert found.floor == pytest.approx(context.floor, rel=0.15)
    assert refined(found, linear_candidate(found)) is None


def test_noise_that_is_not_white_is_told_once() -> None:
    whole = plain()
    rng = np.random.default_rng(3)
    for run, e in enumerate(whole.experiments):
        colored = lfilter([1.0], [1.0, -0.7], 2 * NOISE * rng.standard_normal(e.position.size))
        whole = changed(whole, run, position=e.position + colored, counts_per_meter=None)
    context = prepare(whole)
    if context.colored is None:
        found = refined(context, linear_candidate(context))
        assert found is not None
        assert found.colored is not None
        context = found
    again = refined(context, linear_candidate(context))
    assert again is None or again.colored is context.colored


@pytest.mark.parametrize(("times", "taken"), [(1.05, True), (1.0, True), (0.95, False)])
def test_weights_stand_in_for_no_effect_that_is_likelier(
    times: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within a floor that is known to some per cent only, weights would take what an effect explains."""
    context = prepare(plain())
    linear = linear_candidate(context)
    monkeypatch.setattr("stepid.diagnosis.refine.by_weights", lambda optimum, floor: optimum)
    likeliest = replace(linear, optimum=replace(linear.optimum, cost=times * linear.optimum.cost))
    assert (refined(context, linear, likeliest, [linear]) is not None) is taken
