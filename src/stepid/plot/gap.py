"""The gap between measurement and model, before and after the missing effect was added."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from stepid.core.takes import a, described, number, optional, takes
from stepid.core.words import digits, length
from stepid.diagnosis.result import Diagnosis, RunGap
from stepid.errors import InputError
from stepid.plot.layout import one_legend, page_of_pairs
from stepid.plot.panels import gap_levels, linear_reach, residual, responses
from stepid.plot.scale import plain_logarithm
from stepid.plot.style import MARK, MEASURED, MODEL, OTHER, an_axes, beside, dress, in_own_words, laid_out, styled

BEFORE, AFTER, NOISE = OTHER, MODEL, MARK
RESPONSE: Mapping[str, dict[str, Any]] = {
    "measured": {"linestyle": "", "marker": ".", "color": MEASURED, "markersize": 3.5, "label": "measured"},
    "linear": {"linestyle": "--", "color": BEFORE, "linewidth": 1.1, "label": "linear model"},
    "effect": {"linestyle": "-", "color": AFTER, "linewidth": 0.9, "label": "with the effect added"},
}
"""How the curves of `stepid.plot.panels.Responses` look."""
_DOTS = {"linear": ("linear", BEFORE, "D"), "effect": ("with the effect", AFTER, "o")}
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
    shown = responses(d, run)
    with styled():
        dress(axes)
        for kind, curve in shown.curves.items():
            axes.plot(shown.time, curve, rasterized=kind == "measured", **RESPONSE[kind])
        axes.set_ylabel(f"position [{shown.unit}]")
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
    reach = largest or linear_reach(d)
    linear, effect = (residual(run.measured, x, reach=reach, noise=d.gap.noise) for x in (run.linear, run.model))
    with styled():
        dress(axes)
        axes.axhspan(-linear.band, linear.band, color=NOISE, alpha=0.35, linewidth=0, label="noise, ±2σ")
        axes.plot(run.time, linear.values, **RESPONSE["linear"] | {"linewidth": 0.9})
        if d.effects:
            axes.plot(run.time, effect.values, **RESPONSE["effect"] | {"linewidth": 0.6})
        axes.set_ylim(-linear.end, linear.end)
        axes.set_ylabel(f"residual [{linear.unit}]")
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
    shown = gap_levels(d)
    with styled():
        dress(axes)
        for at in range(len(shown.names)):
            dots = [*((*_DOTS[kind], values[at]) for kind, values in shown.values.items())]
            dots += [("noise", NOISE, "s", shown.noise)]
            for i, (label, color, marker, value) in enumerate(dots):
                place = at + 0.27 * (i - (len(dots) - 1) / 2)
                below = i % 2 == 1  # numbers of equal dots would run together
                axes.plot([place], [value], marker, color=color, markersize=5, label="" if at else label)
                axes.annotate(
                    digits(value),
                    (place, value),
                    xytext=(0, -4 if below else 4),
                    textcoords="offset points",
                    ha="center",
                    va="top" if below else "bottom",
                    fontsize=7,
                )
        if shown.span:
            axes.set_yscale("log")
            axes.set_ylim(0.3 * shown.span[0], 10 * shown.span[1])  # with room for the legend
            plain_logarithm(axes.yaxis)
        axes.set_xticks(range(len(shown.names)), shown.names)
        axes.set_xlim(-0.6, len(shown.names) - 0.4)
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
