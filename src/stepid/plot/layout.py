"""Figures and the places on them: one axes above another, pages of such pairs, one legend for a page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
from matplotlib import pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from stepid.plot.style import COLUMN, PAGE, figure_of, styled


def new_figure(*, width: float, height: float) -> Figure:
    """Make an empty figure, sizes in inches."""
    with styled():
        return plt.figure(figsize=(width, height), layout="constrained")


def stacked_axes(figure: Figure, place: SubplotSpec, *, ratio: float) -> tuple[Axes, Axes]:
    """Make one axes above another with a common time axis, the upper `ratio` times as high."""
    with styled():
        inner = place.subgridspec(2, 1, height_ratios=(ratio, 1))
        upper = figure.add_subplot(inner[0])
        lower = figure.add_subplot(inner[1], sharex=upper)
        upper.tick_params(labelbottom=False)
        figure.align_ylabels([upper, lower])
    return upper, lower


def column_axes() -> tuple[Axes, Axes]:
    """Make a figure one column wide with room for a response and what is left of it below."""
    figure = new_figure(width=COLUMN, height=3.2)
    return stacked_axes(figure, figure.add_gridspec(1, 1)[0], ratio=2.5)


def page_of_pairs(count: int, *, columns: int, ratio: float) -> npt.NDArray[np.object_]:
    """Make a page of `count` stacked axes, at most `columns` side by side; shape (count, 2), upper and lower."""
    bands = math.ceil(count / columns)
    columns = math.ceil(count / bands)
    figure = new_figure(width=PAGE, height=2.6 * bands + 0.3)
    places = figure.add_gridspec(bands, columns)
    made = np.empty((count, 2), dtype=object)
    for i in range(count):
        made[i] = stacked_axes(figure, places[divmod(i, columns)], ratio=ratio)
    return made


def one_legend(
    shown: Iterable[Axes], drawn: Sequence[Axes], *, loc: Literal["outside upper center", "outside lower center"]
) -> None:
    """Put one legend, of what `shown` show, on the page in the place of those of all axes drawn."""
    known: dict[str, Artist] = {}
    for one in shown:
        for handle, label in zip(*one.get_legend_handles_labels(), strict=True):
            known.setdefault(label, handle)
    for one in drawn:
        legend = one.get_legend()
        if legend is not None:
            legend.remove()
    with styled():
        figure_of(drawn[0]).legend(list(known.values()), list(known), loc=loc, ncols=len(known))
