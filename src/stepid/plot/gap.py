"""The gap between measurement and model, before and after the missing effect was added."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from stepid.core.takes import a, described, number, optional, takes
from stepid.diagnosis.result import Diagnosis, RunGap
from stepid.diagnosis.wording import digits, length
from stepid.errors import InputError
from stepid.plot.layout import one_legend, page_of_pairs
from stepid.plot.scale import length_unit, plain_logarithm, reach_of
from stepid.plot.style import MARK, MEASURED, MODEL, OTHER, an_axes, beside, dress, in_own_words, laid_out, styled

BEFORE, AFTER, NOISE = OTHER, MODEL, MARK
a_diagnosis = a(Diagnosis, "a Diagnosis, as stepid.diagnose returns it")
"""Check of an argument `d`."""


def _run(d: Diagnosis, name: str) -> RunGap:
    for run in d.runs:
        if isinstance(name, str) and run.name == name:
            return run
    raise InputError(
        f"the diagnosis of {d.campaign!r} has no run {described(name)}",
        f"Its runs are {', '.join(repr(run.name) for run in d.runs)}.",
    )


@in_own_words
@takes(d=a_diagnosis, axes=an_axes)
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


@in_own_words
@takes(d=a_diagnosis, axes=an_axes, largest=optional(number("a length in m", above=0.0)))
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
    reach = largest or reach_of(run.measured - run.linear for run in d.runs)
    scale, unit = length_unit(reach)
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


@in_own_words
@takes(d=a_diagnosis, axes=an_axes)
def gap_bars(d: Diagnosis, *, axes: Axes) -> Axes:
    """Draw the gap as dots: before, after and noise floor, of the runs that were fitted and of those held out.

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
    if d.gap.held_out:
        groups.append(("held out", *d.gap.held_out))
    with styled():
        dress(axes)
        for at, (_, before, after) in enumerate(groups):
            dots = [("linear", before, BEFORE, "D")]
            dots += [("with the effect", after, AFTER, "o")] if d.effects else []
            dots += [("noise", d.gap.noise, NOISE, "s")]
            for i, (label, value, color, marker) in enumerate(dots):
                place = at + 0.27 * (i - (len(dots) - 1) / 2)
                axes.plot([place], [1e6 * value], marker, color=color, markersize=5, label="" if at else label)
                axes.annotate(
                    digits(1e6 * value),
                    (place, 1e6 * value),
                    xytext=(0, 4),
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


@in_own_words
@takes(d=a_diagnosis, columns=beside)
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
    drawn = page_of_pairs(len(d.runs), columns=columns, ratio=2.0) if axes is None else laid_out(axes, (len(d.runs), 2))
    for run, (upper, lower) in zip(d.runs, drawn, strict=True):
        gap_response(d, run.name, axes=upper)
        gap_residual(d, run.name, axes=lower)
    if axes is None:
        every = drawn.ravel().tolist()
        for one in every:
            if not one.get_subplotspec().get_topmost_subplotspec().is_first_col():
                one.set_ylabel("")
        one_legend(drawn[0], every, loc="outside upper center")
    return drawn
