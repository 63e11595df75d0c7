"""A diagnosis on one page."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

from stepid.core.takes import a, each, optional, takes, text
from stepid.diagnosis.headline import answer
from stepid.diagnosis.result import Diagnosis
from stepid.errors import InputError
from stepid.plot.causes import candidates, force_against_position, force_against_velocity, phase_bars
from stepid.plot.gap import a_diagnosis, gap_bars, gap_residual, gap_response
from stepid.plot.layout import new_figure, one_legend, stacked_axes
from stepid.plot.style import PAGE, in_own_words, styled

_names = each(text(), "names of runs, as a tuple")
_panels = optional(a(Mapping, "a mapping of panels to axes"))
_RUNS = 3  # side by side
_PANELS: dict[str, Callable[..., Axes]] = {
    "gap": gap_bars,
    "velocity": force_against_velocity,
    "position": force_against_position,
    "phases": phase_bars,
    "candidates": candidates,
}


@in_own_words
@takes(d=a_diagnosis, runs=_names, axes=_panels)
def diagnosis(d: Diagnosis, *, runs: Sequence[str] = (), axes: Mapping[str, Axes] | None = None) -> dict[str, Axes]:
    """Draw a whole diagnosis on one page.

    On top, runs as measured and as simulated before and after, with their residuals on one scale and the noise as a
    band; below, the gap as bars, the residual force against velocity and position, where the gap is, the candidates.

    Parameters
    ----------
    d : Diagnosis
        From `stepid.diagnose`.
    runs : sequence of str
        Names of the runs to show, three look best; by default the runs with the largest, the middle and the least gap.
    axes : mapping of str to matplotlib.axes.Axes or None
        To draw into, by the names below, as ``figure.subplot_mosaic`` makes them; a new page if not given.

    Returns
    -------
    dict of str to matplotlib.axes.Axes
        ``"gap"``, ``"velocity"``, ``"position"``, ``"phases"``, ``"candidates"``, and for each run its name (response)
        and its name with ``" residual"``.

    Raises
    ------
    stepid.errors.InputError
        If there is no such run, or no panel of the name of an axes.
    """
    if axes is not None:
        return {name: _panel(d, name, place) for name, place in axes.items()}
    names = tuple(runs) or _telling(d)
    figure = new_figure(width=PAGE, height=8.2)
    rows = figure.add_gridspec(3, 1, height_ratios=(3.2, 2.2, 2.0))
    top = rows[0].subgridspec(1, max(len(names), 1))
    drawn: dict[str, Axes] = {}
    for column, name in enumerate(names):
        upper, lower = stacked_axes(figure, top[column], ratio=1.8)
        drawn[name] = gap_response(d, name, axes=upper)
        drawn[f"{name} residual"] = gap_residual(d, name, axes=lower)
        if column:
            upper.set_ylabel("")
            lower.set_ylabel("")
            lower.tick_params(labelleft=False)
    with styled():
        middle, bottom = rows[1].subgridspec(1, 3), rows[2].subgridspec(1, 3)
        drawn["gap"] = gap_bars(d, axes=figure.add_subplot(middle[0]))
        drawn["velocity"] = force_against_velocity(d, axes=figure.add_subplot(middle[1]))
        drawn["position"] = force_against_position(d, axes=figure.add_subplot(middle[2], sharey=drawn["velocity"]))
        drawn["position"].set_ylabel("")
        drawn["phases"] = phase_bars(d, axes=figure.add_subplot(bottom[0]))
        drawn["candidates"] = candidates(d, axes=figure.add_subplot(bottom[1:]))
        title = textwrap.fill(f"{d.campaign}: {answer(d, sizes=False)}", 100)
        figure.suptitle(title, x=0.01, ha="left", fontsize=9)
    shown = [names[0], f"{names[0]} residual"] if names else ["gap"]
    one_legend([drawn[key] for key in shown], list(drawn.values()), loc="outside lower center")
    return drawn


def _panel(d: Diagnosis, name: str, axes: Axes) -> Axes:
    """Draw one panel by its name."""
    if name in _PANELS:
        return _PANELS[name](d, axes=axes)
    runs = [run.name for run in d.runs]
    if name in runs:
        return gap_response(d, name, axes=axes)
    if name.removesuffix(" residual") in runs:
        return gap_residual(d, name.removesuffix(" residual"), axes=axes)
    raise InputError(
        f"the diagnosis of {d.campaign!r} has no panel {name!r}",
        f"Its panels are {', '.join(map(repr, [*_PANELS, *runs]))}, and of each run its name with ' residual'.",
    )


def _telling(d: Diagnosis) -> tuple[str, ...]:
    """Names of runs with the least, the middle and the largest gap, in the campaign's order."""
    order = sorted(range(len(d.runs)), key=lambda i: d.runs[i].before)
    picked = {order[round(p * (len(order) - 1))] for p in np.linspace(0, 1, _RUNS)} if order else set()
    return tuple(d.runs[i].name for i in sorted(picked))
