"""The still pictures of a report: for paper, for browsers without scripts, for Markdown and PDF."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from stepid import plot
from stepid.diagnosis.result import Diagnosis
from stepid.identification.transfer.verification import Verification
from stepid.plot.layout import new_figure
from stepid.plot.ring_down import zoomed_ring_down
from stepid.plot.style import MARKERS, PAGE, SERIES, in_own_words, styled

Stills = Mapping[str, Callable[[], Any]]  # to axes; matplotlib's own types stay in stepid.plot
_MARKED = 8  # markers on a curve


def stills(d: Diagnosis, verified: Verification | None) -> Stills:
    """Name the still pictures, each with what draws it.

    Parameters
    ----------
    d : Diagnosis
    verified : Verification or None
        Of the peak method, if it has any.

    Returns
    -------
    mapping of str to callable
        Each returns axes of its figure.
    """
    drawn: dict[str, Callable[[], Any]] = {
        "records": lambda: _records(d),
        "where": lambda: _where(d),
        "gap": lambda: _gap(d),
        "runs": lambda: plot.gap_runs(d)[0, 0],
    }
    if zoomed_ring_down(d) is not None:
        drawn["ring-down"] = lambda: _ring_down(d)
    if verified is not None:
        drawn["verification"] = lambda: plot.verification_grid(verified)[0, 0]
    if d.ranking:
        drawn["candidates"] = lambda: _candidates(d)
    return drawn


@in_own_words
def _records(d: Diagnosis) -> Any:
    figure = new_figure(width=PAGE, height=3.0)
    with styled():
        axes = figure.add_subplot()
        for i, run in enumerate(d.runs):
            axes.plot(
                run.time,
                1e3 * run.measured,
                color=SERIES[i % len(SERIES)],
                marker=MARKERS[(i + i // len(SERIES)) % len(MARKERS)],
                markevery=max(run.time.size // _MARKED, 1),
                markersize=3.5,
                linewidth=0.9,
                label=run.name,
            )
        axes.set_xlabel("time [s]")
        axes.set_ylabel("position [mm]")
        axes.set_title("all records")
        figure.legend(loc="outside right upper")
    return axes


def _where(d: Diagnosis) -> Any:
    figure = new_figure(width=PAGE, height=2.4)
    with styled():
        first, second, third = figure.subplots(1, 3)
    plot.phase_bars(d, axes=first)
    plot.force_against_velocity(d, axes=second)
    plot.force_against_position(d, axes=third)
    return first


def _gap(d: Diagnosis) -> Any:
    figure = new_figure(width=PAGE * 0.6, height=2.6)
    with styled():
        axes = figure.add_subplot()
    return plot.gap_bars(d, axes=axes)


def _ring_down(d: Diagnosis) -> Any:
    figure = new_figure(width=PAGE * 0.85, height=2.4)
    with styled():
        axes = figure.add_subplot()
    return plot.ring_down(d, axes=axes)


def _candidates(d: Diagnosis) -> Any:
    figure = new_figure(width=PAGE * 0.85, height=2.4)
    with styled():
        axes = figure.add_subplot()
    return plot.candidates(d, axes=axes)
