"""Paper and screen show the same numbers, panel by panel."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes

import diagnosis_example as example
import stepid
from stepid import plot
from stepid.diagnosis.result import Diagnosis
from stepid.plot.panels import final_reach, gap_levels, linear_reach, phase_levels, ranked_candidates, residual
from stepid.report.pictures import pictures

RUN = example.RUNS[0]
DIGITS = 6e-5  # five digits on the screen


@pytest.fixture
def axes() -> Iterator[Axes]:
    yield plt.subplots()[1]
    plt.close("all")


def lines(drawn: Axes) -> list[tuple[Any, Any]]:
    return [line.get_data() for line in drawn.get_lines()]


def traces(d: Diagnosis, name: str, axis: str = "y") -> list[tuple[Any, Any]]:
    data = pictures(d, ())[name]["data"]
    return [(one["x"], one["y"]) for one in data if one.get("yaxis", "y") == axis]


def assert_same(paper: list[tuple[Any, Any]], screen: list[tuple[Any, Any]]) -> None:
    """Each curve on the screen has the samples of the one on paper, or some of them."""
    assert len(paper) == len(screen) > 0
    for (x, y), (u, v) in zip(paper, screen, strict=True):
        at = [int(np.abs(np.asarray(x) - one).argmin()) for one in u]
        np.testing.assert_allclose(np.asarray(x)[at], u, rtol=DIGITS, atol=1e-9)
        np.testing.assert_allclose(np.asarray(y)[at], v, rtol=DIGITS, atol=1e-9)


def test_responses(axes: Axes) -> None:
    d = example.named()
    assert_same(lines(plot.gap_response(d, RUN, axes=axes)), traces(d, "run-0"))


def test_residuals(axes: Axes) -> None:
    d = example.named()
    before, _ = lines(plot.gap_residual(d, RUN, axes=axes))
    assert_same([before], traces(d, "run-0", "y2"))
    layout = pictures(d, ())["run-0"]["layout"]
    assert layout["yaxis2"]["range"] == pytest.approx(axes.get_ylim())
    run = d.runs[0]
    after = residual(run.measured, run.model, reach=final_reach(d), noise=d.gap.noise)
    assert_same([(run.time, after.values)], traces(d, "run-0", "y3"))
    assert layout["yaxis3"]["range"] == pytest.approx((-after.end, after.end))


@pytest.mark.parametrize(
    ("draw", "name"), [(plot.force_against_velocity, "velocity"), (plot.force_against_position, "position")]
)
def test_forces(draw: Callable[..., Axes], name: str, axes: Axes) -> None:
    d = example.named()
    assert_same(lines(draw(d, axes=axes))[2:], traces(d, name))  # after the axes through zero
    said = [one["text"] for one in pictures(d, ())[name]["layout"].get("annotations", ())]
    assert said == [text.get_text() for text in axes.texts if text.get_text()]


def test_levels(axes: Axes) -> None:
    d = example.named()
    ((names, heights),) = traces(d, "phases")
    plot.phase_bars(d, axes=axes)
    assert [bar.get_height() for bar in axes.patches] == heights
    assert [text.get_text() for text in axes.get_xticklabels()] == names
    gap = plot.gap_bars(d, axes=plt.subplots()[1])
    by_model = [y for _, y in traces(d, "gap")]
    assert [float(y[0]) for _, y in lines(gap)] == [y for group in zip(*by_model, strict=True) for y in group]
    ranked = plot.candidates(d, axes=plt.subplots()[1])
    drawn = sorted(float(x[0]) for x, _ in lines(ranked)[:-1])
    assert drawn == sorted(x for shown, _ in traces(d, "candidates") for x in shown)


def test_ring_down(axes: Axes) -> None:
    d = example.named()
    assert_same(lines(plot.ring_down(d, axes=axes)), traces(d, "ring-down"))
    assert [line.get_label() for line in axes.get_lines()] == ["measured", "linear model", "with the effect added"]


def test_verification(axes: Axes) -> None:
    campaign = example.campaign()
    verified = stepid.verify(stepid.identify(campaign), campaign)
    drawn = pictures(example.named(), verified.runs)["verification-0"]
    curves = [(one["x"], one["y"]) for one in drawn["data"]]
    response, left = plot.verification(verified.runs[0], axes=(axes, plt.subplots()[1]))
    assert_same([*lines(response)[:2], lines(left)[1]], curves)


def test_lengths_are_in_the_unit_that_reads_well_and_levels_in_micrometers() -> None:
    d = example.named()
    one = residual(np.array([2e-3, 0.0]), np.zeros(2), reach=2e-3, noise=1e-5)
    assert (one.unit, *one.values, one.end, one.band) == pytest.approx(("mm", 2.0, 0.0, 2.1, 0.02))
    assert residual(np.zeros(1), np.zeros(1), reach=1e-5).unit == "µm"
    gap, phases = gap_levels(d), phase_levels(d)
    assert gap.values["linear"][0] == pytest.approx(1e6 * d.gap.before)
    assert gap.noise == phases.noise == pytest.approx(1e6 * d.gap.noise)
    assert linear_reach(d) == max(abs(run.measured - run.linear).max() for run in d.runs)


def test_what_is_nothing_has_no_place_on_a_logarithmic_axis() -> None:
    d = example.named()
    silent = d.model_copy(update={"gap": d.gap.model_copy(update={"noise": 0.0})})
    assert gap_levels(silent).span is not None
    assert min(gap_levels(silent).span or ()) > 0
    empty = silent.model_copy(update={"ranking": ()})
    assert ranked_candidates(empty, most=6).span is None
    assert len(pictures(empty.model_copy(update={"runs": ()}), ())["records"]["data"]) == 0


def test_candidates_with_long_names_are_fewer_and_farther_apart(axes: Axes) -> None:
    """In the place of a name of one line a second one had been drawn over the numbers of the candidate above."""
    d = example.named()
    (best, *_) = (one for one in d.ranking if one.effects)
    differs = ("damping", "friction", "gain", "start_time")
    long = [best.model_copy(update={"deviations": differs, "rms": best.rms * (1 + 0.01 * i)}) for i in range(6)]
    ranking = (*long, *(one for one in d.ranking if not one.effects))
    plot.candidates(example.changed(d, ranking=ranking), axes=axes)
    names = [text for text in axes.texts if "differ" in text.get_text()]
    assert 3 <= len(names) < 6
    assert all("\n" in text.get_text() for text in names)
    assert np.diff([text.get_position()[1] for text in names]).min() > 1.5
