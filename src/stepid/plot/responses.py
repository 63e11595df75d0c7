"""Verification responses: measured dots, model line, residual below (as in Figs. 3 and 6 to 8)."""

from __future__ import annotations

import math
import textwrap

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from stepid.plot.style import (
    MARK,
    MEASURED,
    MODEL,
    PAGE,
    column_axes,
    dress,
    length_unit,
    new_figure,
    stacked_axes,
    styled,
)
from stepid.verification import Verification, VerificationRun

AxesPair = tuple[Axes, Axes]


def response(run: VerificationRun, *, axes: Axes) -> Axes:
    """Draw the measured response as dots and the model's as a line, with the first peak marked.

    Parameters
    ----------
    run : VerificationRun
    axes : matplotlib.axes.Axes
        To draw into.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    with styled():
        dress(axes)
        axes.plot(run.time, 1e3 * run.measured, ".", color=MEASURED, markersize=3, label="measured", rasterized=True)
        axes.plot(run.time, 1e3 * run.simulated, "-", color=MODEL, label="model")
        _mark_peak(run, axes)
        axes.set_ylabel("position [mm]")
        axes.set_title(_title(run))
        axes.legend(loc="best")
    return axes


def residual(run: VerificationRun, *, axes: Axes) -> Axes:
    """Draw measured minus model, with the first peak marked.

    Parameters
    ----------
    run : VerificationRun
    axes : matplotlib.axes.Axes
        To draw into.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    difference = run.measured - run.simulated
    scale, unit = length_unit(difference)
    with styled():
        dress(axes)
        axes.axhline(0.0, color=MODEL, linewidth=0.8)
        axes.plot(run.time, scale * difference, ".", color=MEASURED, markersize=2.5, rasterized=True)
        _mark_peak(run, axes)
        axes.set_ylabel(f"residual [{unit}]")
        axes.set_xlabel("time [s]")
    return axes


def _title(run: VerificationRun) -> str:
    fit = f"fit {run.fit_percent:.1f} %"
    return f"{run.name}: {fit}" if len(run.name) < 20 else f"{textwrap.fill(run.name, 30)}\n{fit}"


def _mark_peak(run: VerificationRun, axes: Axes) -> None:
    if run.peak_time is not None:
        axes.axvline(run.peak_time, color=MARK, linewidth=0.9, linestyle="--", label="first peak")


def verification(run: VerificationRun, *, axes: AxesPair | None = None) -> AxesPair:
    """Draw one run's verification response with its residual below.

    Parameters
    ----------
    run : VerificationRun
        One of ``stepid.verify(parameters, campaign).runs``.
    axes : pair of matplotlib.axes.Axes or None
        For response and residual; a new figure, one column wide, if not given.

    Returns
    -------
    pair of matplotlib.axes.Axes
    """
    axes = axes or column_axes()
    response(run, axes=axes[0])
    residual(run, axes=axes[1])
    axes[0].set_xlabel("")
    return axes


def verification_grid(
    verified: Verification, *, columns: int = 3, axes: npt.NDArray[np.object_] | None = None
) -> npt.NDArray[np.object_]:
    """Draw all runs on one page, each with its residual below.

    Parameters
    ----------
    verified : Verification
        From `stepid.verify`.
    columns : int
        Runs side by side, at most, on a new page.
    axes : array of matplotlib.axes.Axes, shape (runs, 2), or None
        To draw into; a new page with one legend if not given.

    Returns
    -------
    array of matplotlib.axes.Axes, shape (runs, 2)
        Response and residual by run.
    """
    if axes is not None:
        for run, pair in zip(verified.runs, axes, strict=True):
            verification(run, axes=(pair[0], pair[1]))
        return axes
    bands = math.ceil(len(verified.runs) / columns)
    columns = math.ceil(len(verified.runs) / bands)
    figure = new_figure(width=PAGE, height=2.6 * bands + 0.3)
    outer = figure.add_gridspec(bands, columns)
    drawn = np.empty((len(verified.runs), 2), dtype=object)
    for i, run in enumerate(verified.runs):
        drawn[i] = verification(run, axes=stacked_axes(figure, outer[divmod(i, columns)], ratio=2.2))
    handles, labels = drawn[0, 0].get_legend_handles_labels()
    for upper in drawn[:, 0]:
        upper.get_legend().remove()  # one legend a page is enough
    with styled():
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return drawn
