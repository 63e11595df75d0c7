"""Many figures at once, each drawn and laid out once whatever the number of its files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import nullcontext
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages

from stepid.plot.style import figure_of, styled


def save_all(
    drawn: Mapping[str, Callable[[], Axes]], folder: Path, *, dots: Mapping[str, int], pages: Path | None = None
) -> dict[str, float]:
    """Write figures, each in every format asked for, and close them.

    Parameters
    ----------
    drawn : mapping of str to callable
        File name without ending, to what draws one figure and returns any axes of it.
    folder : pathlib.Path
    dots : mapping of str to int
        Ending to dots an inch, for example ``{"png": 200, "webp": 150}``.
    pages : pathlib.Path or None
        A PDF for all of them, a page each.

    Returns
    -------
    dict of str to float
        Name to the figure's width, inches.
    """
    widths = {}
    with PdfPages(pages, metadata={"CreationDate": None}) if pages else nullcontext() as book, styled():
        for name, draw in drawn.items():
            figure = figure_of(draw())
            figure.draw_without_rendering()
            figure.set_layout_engine("none")  # laid out; every file would do it again
            for ending, density in dots.items():
                exact = {"lossless": True} if ending == "webp" else {}  # lines take no more room that way
                figure.savefig(folder / f"{name}.{ending}", dpi=density, pil_kwargs=exact)
            if book is not None:
                book.savefig(figure)
            widths[name] = float(figure.get_size_inches()[0])
            plt.close(figure)
    return widths
