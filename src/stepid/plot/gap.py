"""The gap between measurement and model, before and after the missing effect was added."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from stepid.diagnose.result import Diagnosis, RunGap
from stepid.diagnose.wording import length
from stepid.errors import InputError
from stepid.plot.style import (
    MARK,
    MEASURED,
    MODEL,
    OTHER,
    PAGE,
    dress,
    figure_of,
    length_unit,
    new_figure,
    plain_logarithm,
    stacked_axes,
    styled,
)

BEFORE, AFTER, NOISE = OTHER, MODEL, MARK


def _run(d: Diagnosis, name: str) -> RunGap:
    for run in d.runs:
        if run.name == name:
            return run
    raise InputError(
        f"the diagnosis of {d.campaign!r} has no run {name!r}",
        f"Its runs are {', '.join(repr(run.name) for run in d.runs)}.",
    )


def gap_response(d: Diagnosis, name: str, *, axes: Axes) -> Axes:
    """Draw a run as measured, as the linear model says, and as the model with the effects says.

    Parameters
    ----------
    d : Diagnosis
        From `stepid.diagnose`.
    name : str
        Of the run.
    axes : matplotlib.axes.Axes
        To draw into.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.

    Raises
    ------
    stepid.errors.InputError
        If there is no such run.
    """
    run = _run(d, name)
    with styled():
        dress(axes)
        axes.plot(run.time, 1e3 * run.measured, ".", color=MEASURED, markersize=3.5, label="measured", rasterized=True)
        axes.plot(run.time, 1e3 * run.linear, "--", color=BEFORE, linewidth=1.1, label="linear model")
        if d.effects:
            axes.plot(run.time, 1e3 * run.model, "-", color=AFTER, linewidth=0.9, label="with the effect added")
        axes.set_ylabel("position [mm]")
        axes.set_title(_title(d, run))
        axes.legend()
    return axes


def _title(d: Diagnosis, run: RunGap) -> str:
    if not d.effects:
        return f"{run.name}: {length(run.before)}"
    return f"{run.name}: {length(run.before)} → {length(run.after)}"


def gap_residual(d: Diagnosis, name: str, *, axes: Axes, largest: float | None = None) -> Axes:
    """Draw measured minus simulated before and after, with the noise as a band of two standard deviations.

    Parameters
    ----------
    d : Diagnosis
    name : str
        Of the run.
    axes : matplotlib.axes.Axes
        To draw into.
    largest : float or None
        m, end of the scale; that of all the diagnosis' runs if not given, so that runs compare.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.

    Raises
    ------
    stepid.errors.InputError
        If there is no such run.
    """
    run = _run(d, name)
    reach = largest or _largest(d.runs)
    scale, unit = length_unit(np.array([reach]))
    band = 2 * scale * d.gap.noise
    with styled():
        dress(axes)
        axes.axhspan(-band, band, color=NOISE, alpha=0.35, linewidth=0, label="noise, ±2σ")
        axes.plot(
            run.time, scale * (run.measured - run.linear), "--", color=BEFORE, linewidth=0.9, label="linear model"
        )
        if d.effects:
            axes.plot(
                run.time,
                scale * (run.measured - run.model),
                "-",
                color=AFTER,
                linewidth=0.6,
                label="with the effect added",
            )
        axes.set_ylim(-1.05 * scale * reach, 1.05 * scale * reach)
        axes.set_ylabel(f"residual [{unit}]")
        axes.set_xlabel("time [s]")
        axes.legend(loc="upper right")
    return axes


def _largest(runs: tuple[RunGap, ...]) -> float:
    return max((float(np.abs(run.measured - run.linear).max()) for run in runs), default=1e-6) or 1e-6


def gap_bars(d: Diagnosis, *, axes: Axes) -> Axes:
    """Draw the gap as bars: before, after and noise floor, of the runs that were fitted and of those held out.

    Parameters
    ----------
    d : Diagnosis
    axes : matplotlib.axes.Axes
        To draw into.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, with a logarithmic scale.
    """
    groups = [("fitted", d.gap.before, d.gap.after)]
    if d.gap.held_out_before is not None and d.gap.held_out_after is not None:
        groups.append(("held out", d.gap.held_out_before, d.gap.held_out_after))
    with styled():
        dress(axes)
        for at, (_, before, after) in enumerate(groups):
            bars = [("linear", before, BEFORE, "//")]
            bars += [("with the effect", after, AFTER, "")] if d.effects else []
            bars += [("noise", d.gap.noise, NOISE, "..")]
            for i, (label, value, color, hatch) in enumerate(bars):
                place = at + 0.27 * (i - (len(bars) - 1) / 2)
                axes.bar(
                    place,
                    1e6 * value,
                    0.25,
                    color=color,
                    hatch=hatch,
                    edgecolor="white",
                    label="" if at else label,
                    zorder=2,
                )
                axes.annotate(
                    f"{1e6 * value:.3g}",
                    (place, 1e6 * value),
                    xytext=(0, 1),
                    textcoords="offset points",
                    ha="center",
                    va="bottom",
                    fontsize=7,
                )
        values = [1e6 * v for _, before, after in groups for v in (before, after, d.gap.noise) if v > 0]
        if values:
            axes.set_yscale("log")
            axes.set_ylim(0.3 * min(values), 10 * max(values))  # with room for the legend
            plain_logarithm(axes.yaxis)
        axes.set_xticks(range(len(groups)), [name for name, _, _ in groups])
        axes.set_xlim(-0.6, len(groups) - 0.4)
        axes.grid(axis="x", visible=False)
        axes.set_ylabel("RMS gap [µm]")
        axes.set_title("gap")
        axes.legend(loc="upper left", ncols=3, columnspacing=1.0, handlelength=1.4)
    return axes


def gap_runs(d: Diagnosis, *, columns: int = 3, axes: npt.NDArray[np.object_] | None = None) -> npt.NDArray[np.object_]:
    """Draw every run on one page: measured, before and after, each with its residual below on one common scale.

    Parameters
    ----------
    d : Diagnosis
        With at least one run.
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
        for run, (upper, lower) in zip(d.runs, axes, strict=True):
            gap_response(d, run.name, axes=upper)
            gap_residual(d, run.name, axes=lower)
        return axes
    bands = math.ceil(len(d.runs) / columns)
    columns = math.ceil(len(d.runs) / bands)
    figure = new_figure(width=PAGE, height=2.6 * bands + 0.3)
    outer = figure.add_gridspec(bands, columns)
    drawn = np.empty((len(d.runs), 2), dtype=object)
    for i, run in enumerate(d.runs):
        row, column = divmod(i, columns)
        upper, lower = stacked_axes(figure, outer[row, column], ratio=2.0)
        drawn[i] = gap_response(d, run.name, axes=upper), gap_residual(d, run.name, axes=lower)
        if column:
            upper.set_ylabel("")
            lower.set_ylabel("")
    one_legend(drawn[0].tolist(), drawn.ravel().tolist(), loc="outside upper center")
    return drawn


def one_legend(
    first: Sequence[Axes], drawn: Sequence[Axes], *, loc: Literal["outside upper center", "outside lower center"]
) -> None:
    """Put one legend, of what the first axes show, on the page in the place of those of all axes."""
    known: dict[str, Artist] = {}
    for one in first:
        for handle, label in zip(*one.get_legend_handles_labels(), strict=True):
            known.setdefault(label, handle)
    for one in drawn:
        legend = one.get_legend()
        if legend is not None:
            legend.remove()
    with styled():
        figure_of(first[0]).legend(list(known.values()), list(known), loc=loc, ncols=len(known))
