"""Several figures in one PDF, a page each."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages

from stepid.plot.style import styled


def save_pages(drawn: Iterable[Callable[[], Axes]], path: str | Path, *, title: str) -> Path:
    """Write figures as the pages of one PDF, vectors wherever they were drawn as such, and close them.

    Parameters
    ----------
    drawn : iterable of callable
        Each draws one figure and returns any axes of it.
    path : str or pathlib.Path
    title : str
        Of the document.

    Returns
    -------
    pathlib.Path
        Where it was written.
    """
    with PdfPages(path, metadata={"Title": title, "CreationDate": None}) as pages:
        for draw in drawn:
            figure = draw().get_figure(root=True)
            assert figure is not None  # axes that were drawn into belong to a figure
            with styled():
                pages.savefig(figure)
            plt.close(figure)
    return Path(path)
