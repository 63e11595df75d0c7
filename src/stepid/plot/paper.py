"""The paper's verification figures (3, 6, 7, 8), from what can be recovered of it."""

from __future__ import annotations

from functools import cache

from matplotlib.axes import Axes

from stepid.core.takes import a, takes
from stepid.datasets.replication import PaperResponse, rebuild_paper
from stepid.plot.layout import column_axes
from stepid.plot.scale import length_unit, reach_of
from stepid.plot.style import MARK, MODEL, OTHER, dress, laid_out, styled


@takes(run=a(PaperResponse, "a response of stepid.rebuild_paper: rebuilt.responses[0]"))
def paper_figure(run: PaperResponse, *, axes: tuple[Axes, Axes] | None = None) -> tuple[Axes, Axes]:
    """Draw one verification figure of the paper.

    The raw records are not published. So the lines are the models of the printed and of the rebuilt parameters, and
    what was measured is marked where Table 2 gives it back: the first peak and the steady state.

    Parameters
    ----------
    run : PaperResponse
        One of ``stepid.rebuild_paper().responses``.
    axes : pair of matplotlib.axes.Axes or None
        For response and difference; a new figure, one column wide, if not given.

    Returns
    -------
    pair of matplotlib.axes.Axes
    """
    upper, lower = column_axes() if axes is None else laid_out(axes, (2,))
    reach = _reach()
    scale, unit = length_unit(reach)
    with styled():
        dress(upper, lower)
        upper.plot(
            run.time, 1e3 * run.printed, "-", color=OTHER, linewidth=3, alpha=0.6, label="model, printed Table 2"
        )
        upper.plot(run.time, 1e3 * run.rebuilt, "-", color=MODEL, label="model, rebuilt")
        upper.plot([run.peak_time], [1e3 * run.peak], "o", color=MARK, markerfacecolor="none", label="measured peak")
        upper.axhline(1e3 * run.steady_state, color=MARK, linestyle="--", linewidth=0.9, label="measured steady state")
        upper.set_ylabel("position [mm]")
        upper.set_ylim(bottom=0)
        upper.set_title(f"{run.figure}: {run.name}, 0.5 V step")
        upper.legend(loc="lower right")
        lower.axhline(0.0, color=MODEL, linewidth=0.8)
        lower.plot(run.time, scale * (run.rebuilt - run.printed), "-", color=OTHER)
        lower.set_ylim(-1.05 * scale * reach, 1.05 * scale * reach)  # one axis in all figures: they compare
        lower.text(
            0.98, 0.94, "no measured record is published", transform=lower.transAxes,
            ha="right", va="top", fontsize=7,
        )  # fmt: skip
        lower.set_ylabel(f"difference [{unit}]")
        lower.set_xlabel("time [s]")
    return upper, lower


@cache
def _reach() -> float:
    """m, the largest difference in any of the paper's figures."""
    return reach_of(one.rebuilt - one.printed for one in rebuild_paper().responses)
