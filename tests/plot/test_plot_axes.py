"""Figures drawn into axes of one's own: the same axes come back, dressed in the one style, nothing else is made."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

import figure_cases as cases
from stepid import plot
from stepid.errors import InputError
from stepid.plot.style import STYLE, figure_of


@pytest.fixture(autouse=True)
def _no_windows() -> Iterator[None]:
    mpl.use("Agg")
    yield
    assert len(plt.get_fignums()) == 1, "a figure was made beside the user's"
    plt.close("all")


def dressed(axes: Axes) -> bool:
    ticks = {label.get_fontsize() for label in (*axes.get_xticklabels(), *axes.get_yticklabels())}
    sizes = {axes.xaxis.label.get_fontsize(), axes.yaxis.label.get_fontsize()}
    plain = not axes.spines["top"].get_visible() and not axes.spines["right"].get_visible()
    return plain and ticks <= {STYLE["xtick.labelsize"]} and sizes == {STYLE["axes.labelsize"]}


def test_verification_of_every_run() -> None:
    _, mine = plt.subplots(4, 2)
    assert plot.verification_grid(cases.verification(), axes=mine) is mine
    assert [a.get_title(loc="left") for a in mine[:, 0]] == [f"case {i}: fit 94.2 %" for i in (4, 5, 6, 7)]
    assert all(dressed(a) for a in mine.ravel())


def test_gaps_of_every_run() -> None:
    _, mine = plt.subplots(4, 2)
    assert plot.gap_runs(cases.D, axes=mine) is mine
    assert [len(a.get_lines()) for a in mine.ravel()] == [3, 2] * 4
    assert all(dressed(a) for a in mine.ravel())


def test_trends_say_what_varies_and_what_is_held() -> None:
    _, mine = plt.subplots(2, 4)
    assert plot.trends(cases.trends(), axes=mine) is mine
    (head,) = mine[0, 0].texts
    assert head.get_text() == "What mass does (medium spring, damper 1/2 turn)"
    assert all(dressed(a) and a.get_xlabel() and a.get_ylabel() for a in mine.ravel())


def test_a_long_head_of_a_trend_pushes_no_axes_away() -> None:
    plt.close("all")
    drawn = plot.trends(cases.trends())
    figure_of(drawn[0, 0]).canvas.draw()
    places = [one.get_position() for one in drawn[0]]
    apart = [right.x0 - left.x1 for left, right in pairwise(places)]
    assert max(apart) < 1.5 * min(apart)


def test_panels_of_a_diagnosis_in_a_mosaic() -> None:
    names = [["gap", "velocity", "position"], ["phases", "candidates", "case 7"], ["case 5", "case 7 residual", "."]]
    mine = plt.figure().subplot_mosaic(names)
    drawn = plot.diagnosis(cases.D, axes=mine)
    assert drawn == mine
    assert all(dressed(a) for a in drawn.values())
    assert drawn["case 5"].get_title(loc="left").startswith("case 5:")
    assert drawn["case 7 residual"].get_ylabel() == "residual [mm]"
    assert [len(drawn[name].get_lines()) for name in ("gap", "phases", "candidates")] == [6, 1, 5]
    np.testing.assert_allclose(drawn["position"].get_lines()[2].get_ydata(), cases.D.where.position_force)


def test_unknown_panel_is_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"no panel 'cap'.*'gap', 'velocity'.*'case 4'.*residual"):
        plot.diagnosis(cases.D, axes={"cap": plt.subplots()[1]})


def test_the_figure_of_axes_in_a_subfigure_is_the_whole() -> None:
    whole = plt.figure()
    part = whole.subfigures(1, 2)[0]
    assert figure_of(part.subplots()) is whole
