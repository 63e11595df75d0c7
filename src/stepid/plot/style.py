"""One style for all pictures: sizes for a journal column, colors that color-blind eyes tell apart."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import LogLocator, NullFormatter

from stepid._base import Array

COLUMN = 85 / 25.4  # inches, one journal column of 85 mm
PAGE = 7.2  # inches, two columns
# Okabe and Ito, "Color universal design" (2008)
MEASURED, MODEL, OTHER, MARK = "#56B4E9", "#000000", "#D55E00", "#009E73"
SERIES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")

STYLE: Any = {  # Any, because matplotlib's own type for it changes between versions
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "savefig.dpi": 200,
}


@contextmanager
def styled() -> Iterator[None]:
    """Draw in the style, and leave the user's own settings as they were."""
    with plt.rc_context(STYLE):
        yield


def dress(*axes: Axes) -> None:
    """Bring axes into the style that were made outside it: the user's own."""
    for one in axes:
        one.spines[["top", "right"]].set_visible(False)
        one.grid(visible=True, color=STYLE["grid.color"], linewidth=STYLE["grid.linewidth"])
        one.set_axisbelow("line")
        one.tick_params(labelsize=STYLE["xtick.labelsize"])
        for text in (one.xaxis.label, one.yaxis.label):
            text.set_fontsize(STYLE["axes.labelsize"])


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


def length_unit(values: Array) -> tuple[float, str]:
    """Factor from meters and name of the unit in which the values read well."""
    largest = float(abs(values).max()) if values.size else 0.0
    return (1e3, "mm") if largest >= 1e-3 else (1e6, "µm")


def plain_logarithm(axis: Axis, *, marks: tuple[float, ...] = (1.0, 2.0, 5.0)) -> None:
    """Mark a logarithmic axis at `marks` times the powers of ten, in plain numbers."""
    axis.set_major_locator(LogLocator(subs=marks))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def figure_of(axes: Axes) -> Figure:
    """Return the whole figure that holds the axes, subfigures or not."""
    figure = axes.figure.figure  # get_figure(root=True) is of matplotlib 3.10
    assert isinstance(figure, Figure)
    return figure


def save(axes: Axes, path: str | Path) -> Path:
    """Write the figure that holds the axes, and close it.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Any axes of the figure.
    path : str or pathlib.Path
        The ending chooses the format: ``.png``, ``.pdf``, ``.svg``.

    Returns
    -------
    pathlib.Path
        Where it was written.
    """
    figure = figure_of(axes)
    with styled():
        figure.savefig(path)
    plt.close(figure)
    return Path(path)
