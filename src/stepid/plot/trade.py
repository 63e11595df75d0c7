"""The trade of a plan: what each design would determine against its number of runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from stepid.core.base import Array
from stepid.plot.layout import new_figure, one_legend
from stepid.plot.scale import plain_logarithm
from stepid.plot.style import MARKERS, OTHER, PAGE, SERIES, dress, styled

_WIDE = 0.5  # of the distance of two numbers of runs, over which their designs are spread
_DECADES = 30.0  # worst value shown over the line that is wanted


Drawn = Mapping[str, Axes]
"""Axes by panel."""


class Panel(NamedTuple):
    """One thing that designs determine: `values` of all designs, the line `wanted`, which is to be undercut or reached.

    `best` are the designs, by index, that the line joins, one for each number of runs; `advised` is marked.
    """

    title: str
    label: str
    values: Sequence[float]
    wanted: float
    below: bool
    best: Sequence[int]
    advised: int


def trade(
    panels: Mapping[str, Panel],
    runs: Sequence[int],
    groups: Sequence[str],
    *,
    axes: Drawn | None = None,
) -> Drawn:
    """Draw what designs determine against their number of runs.

    Parameters
    ----------
    panels : mapping of str to Panel
    runs : sequence of int
        Number of runs of each design.
    groups : sequence of str
        What each design's color stands for, as the legend says it.
    axes : mapping of str to matplotlib.axes.Axes, optional
        By panel; a new figure, one page wide, if not given.

    Returns
    -------
    dict
        Panel to axes.
    """
    if axes is None:
        with styled():
            figure = new_figure(width=PAGE, height=2.7)
            axes = dict(zip(panels, figure.subplots(1, len(panels), squeeze=False)[0], strict=True))
    drawn = {name: axes[name] for name in panels}
    with styled():
        for name, panel in panels.items():
            _draw(drawn[name], panel, np.asarray(runs), np.asarray(groups))
        every = list(drawn.values())
        one_legend(every[:1], every, loc="outside lower center")
    return drawn


def _draw(ax: Axes, panel: Panel, runs: npt.NDArray[np.intp], groups: npt.NDArray[np.str_]) -> None:
    dress(ax)
    counts, place = np.unique(runs, return_inverse=True)
    values = np.asarray(panel.values, dtype=np.float64)
    kinds = list(dict.fromkeys(groups.tolist()))
    for i, kind in enumerate(kinds):
        of = np.flatnonzero((groups == kind) & np.isfinite(values) & (values > 0))
        shift = _WIDE * ((i + 0.5) / len(kinds) - 0.5)
        ax.plot(place[of] + shift, values[of], MARKERS[i % len(MARKERS)], color=SERIES[i % len(SERIES)],
                markersize=2.5, alpha=0.6, markeredgewidth=0, label=kind)  # fmt: skip
    best = np.array(panel.best, dtype=np.intp)
    ax.plot(place[best], values[best], "-", color="#000000", linewidth=0.9, label="best of that many runs")
    ax.axhline(panel.wanted, color=OTHER, linestyle="--", linewidth=1.0, label="wanted")
    ax.plot(place[panel.advised], values[panel.advised], "*", color=OTHER, markersize=10, markeredgecolor="white",
            markeredgewidth=0.5, zorder=5, label="advice")  # fmt: skip
    ax.set_yscale("log")
    _limit(ax, values, panel)
    plain_logarithm(ax.yaxis)
    ax.set_xticks(range(counts.size), [str(count) for count in counts])
    ax.set_xlabel("runs")
    ax.set_ylabel(panel.label)
    ax.set_title(panel.title)


def _limit(ax: Axes, values: Array, panel: Panel) -> None:
    """Leave out what is hopelessly far off."""
    shown = np.append(values[np.isfinite(values) & (values > 0)], panel.wanted)
    low, high = float(shown.min()), float(shown.max())
    if panel.below:
        high = min(high, _DECADES * panel.wanted)
    else:
        low = max(low, panel.wanted / _DECADES)
    ax.set_ylim(low / 1.4, high * 1.4)
