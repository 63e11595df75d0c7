"""One style for all pictures: sizes for a journal column, colors that color-blind eyes tell apart."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

from stepid.core.quantities import CART, quantities_of
from stepid.core.takes import a, count, takes
from stepid.errors import InputError

P = ParamSpec("P")
R = TypeVar("R")
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
    """Draw in the style, and leave the user's own settings as they were.

    The first figure of a notebook loads its backend, which turns the interactive mode on: that stays.
    """
    own = {key: plt.rcParams[key] for key in STYLE}
    plt.rcParams.update(STYLE)
    try:
        yield
    finally:
        plt.rcParams.update(own)


def dress(*axes: Axes) -> None:
    """Bring axes into the style that were made outside it: the user's own."""
    for one in axes:
        one.spines[["top", "right"]].set_visible(False)
        one.grid(visible=True, color=STYLE["grid.color"], linewidth=STYLE["grid.linewidth"])
        one.set_axisbelow("line")
        one.tick_params(labelsize=STYLE["xtick.labelsize"])
        for text in (one.xaxis.label, one.yaxis.label):
            text.set_fontsize(STYLE["axes.labelsize"])


def figure_of(axes: Axes) -> Figure:
    """Return the whole figure that holds the axes, subfigures or not."""
    figure = axes.figure.figure  # get_figure(root=True) is of matplotlib 3.10
    assert isinstance(figure, Figure)
    return figure


def in_own_words(draw: Callable[P, R]) -> Callable[P, R]:
    """Have a picture speak of its data in their own quantities; see `stepid.core.quantities`."""

    @wraps(draw)
    def inner(*args: P.args, **kwargs: P.kwargs) -> R:
        drawn = draw(*args, **kwargs)
        quantities = quantities_of(args[0]) if args else CART
        if not quantities.usual:
            shown = drawn.values() if isinstance(drawn, Mapping) else np.asarray(drawn, dtype=object).flat
            own = kwargs.get("axes") is None  # else the figure is the caller's, and so is what else it says
            for one in {figure_of(axes) for axes in shown} if own else shown:
                for text in one.findobj(Text):
                    text.set_text(quantities.text(text.get_text()))
        return drawn

    return inner


an_axes = a(Axes, "axes of matplotlib")
"""Check of an argument `axes`."""
beside = count("how many stand side by side at most, 1 or more", most=1000)
"""Check of an argument `columns`."""


def laid_out(axes: object, shape: tuple[int, ...]) -> npt.NDArray[np.object_]:
    """Return axes that a caller made as an array; InputError where there are not as many as are drawn."""
    many = np.empty(0, dtype=object) if isinstance(axes, Axes) else np.asarray(axes, dtype=object)
    if many.shape != shape or not all(isinstance(one, Axes) for one in many.flat):
        size = " × ".join(map(str, shape))
        raise InputError(f"axes are no {size} axes of matplotlib", f"Give {size} of them, or leave axes out.")
    return many


@takes(axes=an_axes, path=a((str, os.PathLike), "the path of a picture, as text or pathlib.Path"))
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

    Raises
    ------
    stepid.errors.InputError
        If it cannot be written there.
    """
    figure = figure_of(axes)
    try:
        with styled():
            figure.savefig(path)
    except (OSError, ValueError) as error:  # a folder that is not there, an ending that no format has
        raise InputError(
            f"{os.fspath(path)!r}: the picture cannot be written ({error})",
            "Give a path that ends in .png, .pdf or .svg, in a folder that is there.",
        ) from None
    plt.close(figure)
    return Path(path)
