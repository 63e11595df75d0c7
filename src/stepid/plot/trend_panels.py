"""What damping, mass and stiffness do to the response, drawn."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from stepid.core.takes import a, takes
from stepid.identification.trends import Trend, Trends
from stepid.plot.layout import new_figure
from stepid.plot.style import MARKERS, PAGE, SERIES, dress, in_own_words, laid_out, styled

_QUANTITIES = (  # field, label, factor from SI
    ("peak_time", "peak time [s]", 1.0),
    ("overshoot", "overshoot [%]", 100.0),
    ("settling_time", "settling time [s]", 1.0),
    ("static_gain", "static gain [m/V]", 1.0),
)
_ROOM = 24  # letters that fit below one axes


@in_own_words
@takes(one=a(Trend, "a Trend: one of the trends of stepid.find_trends"))
def trend(one: Trend, *, axes: Sequence[Axes] | None = None) -> Sequence[Axes]:
    """Draw peak time, overshoot, settling time and static gain of runs in which one thing varies.

    Parameters
    ----------
    one : Trend
        One of ``stepid.find_trends(characteristics).trends``.
    axes : sequence of four matplotlib.axes.Axes or None
        A new figure, one page wide, if not given.

    Returns
    -------
    sequence of matplotlib.axes.Axes
        With bars of two standard uncertainties.
    """
    if axes is None:
        with styled():
            axes = new_figure(width=PAGE, height=2.2).subplots(1, len(_QUANTITIES)).tolist()
    places = np.arange(len(one.runs))
    settings = [re.sub(r" kg(·m²)?$", "", one.setting(run)) for run in one.runs]
    crowded = sum(map(len, settings)) > _ROOM
    kind = ("damping", "mass", "stiffness").index(one.varies)
    with styled():
        for ax, (field, label, factor) in zip(axes, _QUANTITIES, strict=True):
            dress(ax)
            values = [getattr(run, field) for run in one.runs]
            spread = [getattr(run.uncertainty, field) or 0.0 for run in one.runs]
            known = [i for i, value in enumerate(values) if value is not None]
            ax.errorbar(
                places[known],
                [factor * values[i] for i in known],
                yerr=[2 * factor * spread[i] for i in known],
                fmt=f"{MARKERS[kind]}-",
                color=SERIES[kind],
                capsize=2,
                markersize=4,
            )
            ax.set_xticks(places, settings, rotation=30 if crowded else 0, ha="right" if crowded else "center")
            ax.set_xlim(-0.4, len(one.runs) - 0.6)
            ax.set_xlabel("added mass [kg]" if one.varies == "mass" else f"more {one.varies} →")
            ax.set_ylabel(label)
            ax.set_title(" ")  # keeps the line free for what is wider than its axes; a title would push the next away
        axes[0].annotate(
            f"What {one.varies} does ({one.held})",
            xy=(0, 1),
            xycoords="axes fraction",
            xytext=(0, plt.rcParams["axes.titlepad"]),
            textcoords="offset points",
            fontsize=plt.rcParams["axes.titlesize"],
            annotation_clip=False,
            in_layout=False,
        )
    return axes


@in_own_words
@takes(found=a(Trends, "what stepid.find_trends returns"))
def trends(found: Trends, *, axes: npt.NDArray[np.object_] | None = None) -> npt.NDArray[np.object_]:
    """Draw all trends on one page, a row each.

    Parameters
    ----------
    found : Trends
        From `stepid.find_trends`, at least one trend.
    axes : array of matplotlib.axes.Axes, shape (trends, 4), or None
        To draw into; a new page if not given.

    Returns
    -------
    array of matplotlib.axes.Axes, shape (trends, 4)
    """
    if axes is None:
        with styled():
            figure = new_figure(width=PAGE, height=2.2 * len(found.trends))
            axes = figure.subplots(len(found.trends), len(_QUANTITIES), squeeze=False)
    axes = laid_out(axes, (len(found.trends), len(_QUANTITIES)))
    for one, row in zip(found.trends, axes, strict=True):
        trend(one, axes=row.tolist())
    return axes
