"""Golden images of every figure function: nothing is missing, nothing moves, and what is written can be read."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import pairwise

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt
from matplotlib.text import Text

import golden_images as golden
from figure_cases import CASES, COLUMN_CASES, PAGE_CASES
from stepid import plot

REMEDY = "if the change is meant, run python tests/golden_images.py and look at the pictures"
LEGIBLE = 6.5  # points, in print at the width of a column


@pytest.fixture(autouse=True)
def _no_windows() -> Iterator[None]:
    mpl.use("Agg")
    with mpl.rc_context(mpl.rcParamsDefault | {"backend": "Agg"}):
        yield
    plt.close("all")


def test_every_figure_function_has_a_case_and_every_case_its_picture() -> None:
    assert {name.split()[0] for name in CASES} == {name for name in plot.__all__ if not name.startswith("save")}
    pictures = list(golden.FOLDER.glob("*.png"))
    assert {path.name for path in pictures} == {golden.golden(n).name for n in CASES}
    assert sum(path.stat().st_size for path in pictures) < 1.5e6


@pytest.mark.parametrize("name", CASES)
def test_figure_is_the_golden_one(name: str) -> None:
    figure = CASES[name]()
    said = json.loads(golden.WORDS.read_text(encoding="utf-8"))
    assert golden.words(figure) == said[name], REMEDY
    off = golden.difference(golden.pixels(figure), golden.load(name))
    assert off <= golden.TOLERANCE, f"{name} is {off:.1f} levels off; {REMEDY}"


def without_each(name: str, *, of_axes: int | None) -> dict[str, float]:
    """Differences from the golden image that each curve, bar or band leaves when it is taken away."""
    figure = CASES[name]()
    golden.pixels(figure)  # lays out and hides the words, once
    found = {}
    for label, artist in golden.drawn(figure):
        if of_axes is None or label.startswith(f"axes {of_axes} "):
            artist.set_visible(False)
            found[label] = golden.difference(golden.render(figure), golden.load(name))
            artist.set_visible(True)
    return found


@pytest.mark.parametrize("name", COLUMN_CASES)
def test_a_missing_curve_is_caught(name: str) -> None:
    found = without_each(name, of_axes=None)
    assert len(found) >= 3
    assert min(found.values()) > 2 * golden.TOLERANCE, found


@pytest.mark.parametrize("name", PAGE_CASES)
def test_a_missing_curve_is_caught_on_a_page(name: str) -> None:
    found = without_each(name, of_axes=1)  # residuals: the faintest
    assert len(found) >= 3
    assert min(found.values()) > 2 * golden.TOLERANCE, found


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGE_CASES)
def test_any_missing_curve_is_caught_on_a_page(name: str) -> None:
    found = without_each(name, of_axes=None)
    assert len(found) >= 8  # the records of four runs have the fewest
    assert min(found.values()) > 2 * golden.TOLERANCE, found


def test_a_missing_word_is_caught() -> None:
    figure = CASES["gap_bars"]()
    (axes,) = figure.axes
    axes.set_ylabel("RMS gap")
    assert golden.words(figure) != json.loads(golden.WORDS.read_text(encoding="utf-8"))["gap_bars"]


@pytest.mark.parametrize("name", CASES)
def test_words_can_be_read_in_print(name: str) -> None:
    figure = CASES[name]()
    figure.canvas.draw()
    shown = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip()]
    assert min(text.get_fontsize() for text in shown) >= LEGIBLE
    whole = figure.bbox.padded(1.0)
    for axes in figure.axes:
        labels = [*axes.texts, axes.xaxis.label, axes.yaxis.label, axes.title]
        for text in labels:
            if text.get_text().strip():
                box = text.get_window_extent()
                assert whole.x0 <= box.x0 < box.x1 <= whole.x1, text.get_text()
                assert whole.y0 <= box.y0 < box.y1 <= whole.y1, text.get_text()
        for axis in (axes.xaxis, axes.yaxis):
            boxes = [t.get_window_extent() for t in axis.get_ticklabels() if t.get_text() and t.get_rotation() == 0]
            along = sorted((b.x0, b.x1) if axis is axes.xaxis else (b.y0, b.y1) for b in boxes)
            inside = [pair for pair in along if pair[1] > pair[0]]
            assert all(one[1] <= two[0] + 1 for one, two in pairwise(inside)), axis.axis_name
