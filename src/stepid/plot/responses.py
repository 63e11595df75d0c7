"""Verification responses: measured dots, model line, residual below (as in Figs. 3 and 6 to 8)."""

from __future__ import annotations

import textwrap

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from stepid.core.takes import a, takes
from stepid.identification.transfer.verification import Verification, VerificationRun
from stepid.plot.layout import column_axes, one_legend, page_of_pairs
from stepid.plot.panels import verification_residual, verification_responses
from stepid.plot.style import MARK, MEASURED, MODEL, an_axes, beside, dress, in_own_words, laid_out, styled

AxesPair = tuple[Axes, Axes]
_a_run = a(VerificationRun, "a run of a Verification: verified[name]")


@in_own_words
@takes(run=_a_run, axes=an_axes)
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
    time, unit, drawn = verification_responses(run)
    with styled():
        dress(axes)
        axes.plot(time, drawn["measured"], ".", color=MEASURED, markersize=3, label="measured", rasterized=True)
        axes.plot(time, drawn["simulated"], "-", color=MODEL, label="model")
        _mark_peak(run, axes)
        axes.set_ylabel(f"position [{unit}]")
        axes.set_title(_title(run))
        axes.legend(loc="best")
    return axes


@in_own_words
@takes(run=_a_run, axes=an_axes)
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
    left = verification_residual(run)
    with styled():
        dress(axes)
        axes.axhline(0.0, color=MODEL, linewidth=0.8)
        axes.plot(run.time, left.values, ".", color=MEASURED, markersize=2.5, rasterized=True)
        _mark_peak(run, axes)
        axes.set_ylabel(f"residual [{left.unit}]")
        axes.set_xlabel("time [s]")
    return axes


def _title(run: VerificationRun) -> str:
    fit = f"fit {run.fit_percent:.1f} %"
    return f"{run.name}: {fit}" if len(run.name) < 20 else f"{textwrap.fill(run.name, 30)}\n{fit}"


def _mark_peak(run: VerificationRun, axes: Axes) -> None:
    if run.peak_time is not None:
        axes.axvline(run.peak_time, color=MARK, linewidth=0.9, linestyle="--", label="first peak")


@in_own_words
@takes(run=_a_run)
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
    upper, lower = column_axes() if axes is None else laid_out(axes, (2,))
    response(run, axes=upper)
    residual(run, axes=lower)
    return upper, lower


@in_own_words
@takes(verified=a(Verification, "what stepid.verify returns"), columns=beside)
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
    drawn = (
        page_of_pairs(len(verified.runs), columns=columns, ratio=2.2)
        if axes is None
        else laid_out(axes, (len(verified.runs), 2))
    )
    for run, (upper, lower) in zip(verified.runs, drawn, strict=True):
        verification(run, axes=(upper, lower))
    if axes is None:
        one_legend(drawn[:, 0], drawn.ravel().tolist(), loc="outside upper center")
    return drawn
