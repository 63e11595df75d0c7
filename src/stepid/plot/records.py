"""The records of a campaign over each other, as they were measured."""

from __future__ import annotations

from matplotlib.axes import Axes

from stepid.core.arguments import as_campaign
from stepid.core.experiment import Campaign
from stepid.plot.layout import new_figure, stacked_axes
from stepid.plot.scale import length_unit, reach_of
from stepid.plot.style import MARKERS, PAGE, SERIES, dress, in_own_words, styled

_MARKED = 8  # markers on a curve


@in_own_words
def records(campaign: Campaign, *, axes: tuple[Axes, Axes] | None = None) -> tuple[Axes, Axes]:
    """Draw the positions of all runs over each other, and their inputs below.

    Parameters
    ----------
    campaign : Campaign
    axes : pair of matplotlib.axes.Axes, optional
        To draw into, for positions and inputs; a new figure by default.

    Returns
    -------
    pair of matplotlib.axes.Axes
    """
    runs = as_campaign(campaign).experiments
    own = axes is None
    if axes is None:
        figure = new_figure(width=PAGE, height=3.6)
        axes = stacked_axes(figure, figure.add_gridspec(1, 1)[0], ratio=2.5)
    upper, lower = axes
    scale, unit = length_unit(reach_of([run.position for run in runs]))
    with styled():
        for number, run in enumerate(runs):
            color = SERIES[number % len(SERIES)]
            upper.plot(
                run.time,
                scale * run.position,
                color=color,
                marker=MARKERS[(number + number // len(SERIES)) % len(MARKERS)],
                markevery=max(run.time.size // _MARKED, 1),
                markersize=3.5,
                linewidth=0.9,
                label=run.name,
            )
            lower.plot(
                run.time, run.input, color=color, linewidth=0.9, drawstyle=_style(run.input_between), label=run.name
            )
        for one in axes:
            dress(one)
        upper.set_ylabel(f"position [{unit}]")
        upper.set_title(campaign.name)
        lower.set_ylabel("input [V]")
        lower.set_xlabel("time [s]")
        if own:
            upper.figure.legend(*upper.get_legend_handles_labels(), loc="outside right upper")
        else:
            upper.legend(loc="best")
    return upper, lower


def _style(between: str) -> str:
    return "steps-post" if between == "held" else "default"
