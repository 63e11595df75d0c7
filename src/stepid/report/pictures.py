"""The interactive pictures, drawn by plotly; colors are named, so that the page can show them light or dark."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt
import plotly.graph_objects as go

from stepid.core.base import Array
from stepid.core.latex import parameter_name
from stepid.core.quantities import in_own_quantities
from stepid.diagnosis.result import Diagnosis, Ranked, RunGap
from stepid.diagnosis.wording import candidate_name, chance, per_cent
from stepid.identification.transfer.verification import VerificationRun
from stepid.plot.panels import (
    Force,
    Responses,
    final_reach,
    force_jump,
    gap_levels,
    linear_reach,
    phase_levels,
    position_force,
    ranked_candidates,
    residual,
    responses,
    velocity_force,
    verification_residual,
    verification_responses,
)
from stepid.plot.ring_down import RingDown, ring_down_responses, zoomed_ring_down
from stepid.plot.scale import reach_of
from stepid.report.axes import BAR, bars, dots, framed, noise_across, noise_upright, own_line, paired, run_line
from stepid.report.pull import linear_pull
from stepid.report.thin import kept_samples, listed

_SHOWN = 8  # candidates
_MARKED = 9  # markers on a curve
_NO_SPAN = (1.0, 1.0)  # µm, where there is nothing to show
_LINES = {
    "measured": ("measured", "measured"),
    "linear": ("before", "linear"),
    "effect": ("after", "with effect"),
}
_DOTS = {"linear": ("before", "linear model"), "effect": ("after", "with the effect")}


@in_own_quantities
def pictures(d: Diagnosis, verified: Sequence[VerificationRun]) -> dict[str, Any]:
    """Draw all interactive pictures of a report.

    Parameters
    ----------
    d : Diagnosis
    verified : sequence of VerificationRun
        Of the peak method; empty where it has none.

    Returns
    -------
    dict of str to dict
        By name, as plotly's JSON; a picture of one run is called ``"run-3"`` by the run's place in the diagnosis.
    """
    place = {run.name: i for i, run in enumerate(d.runs)}
    reach, rest = linear_reach(d), final_reach(d)
    drawn = {
        "records": _records(d),
        "residuals": _residuals(d),
        "phases": _phases(d),
        "velocity": _jump(d, _force(velocity_force(d.where), "velocity")),
        "position": _force(position_force(d.where), "from rest"),
        "gap": _gap(d),
    }
    shown = zoomed_ring_down(d)
    if shown is not None:
        drawn["ring-down"] = _ring_down(d, shown)
    if d.ranking:
        drawn["candidates"] = _candidates(d)
    if d.effects:
        drawn["pull"] = _pull(d)
    left = reach_of(run.measured - run.simulated for run in verified)
    for run in verified:
        if run.name in place:
            drawn[f"verification-{place[run.name]}"] = verification(run, left)
    for i, gap in enumerate(d.runs):
        drawn[f"run-{i}"] = _run(d, gap, reach, rest)
    return {name: figure.to_plotly_json() for name, figure in drawn.items()}


def _records(d: Diagnosis) -> go.Figure:
    shown = [responses(d, run) for run in d.runs]
    unit = shown[0].unit if shown else "mm"
    return _overlay(d, [one.curves["measured"] for one in shown], f"position [{unit}]", unit)


def _overlay(d: Diagnosis, curves: Sequence[Array], label: str, what: str) -> go.Figure:
    figure = framed(go.Figure(), x="time [s]", y=label)
    for i, (run, curve) in enumerate(zip(d.runs, curves, strict=True)):
        kept = kept_samples(curve)
        color, symbol, dash = run_line(i)
        figure.add_scatter(
            x=listed(run.time[kept]),
            y=listed(curve[kept]),
            name=escape(run.name),
            meta={"run": i, "at": " s", "unit": what},
            mode="lines+markers",
            line={"color": color, "width": 1.4, "dash": dash},
            marker={"symbol": symbol, "size": 7, "maxdisplayed": _MARKED},
            hovertemplate=f"%{{fullData.name}}<br>%{{x:.3f}} s<br>%{{y:.4g}} {what}<extra></extra>",
        )
    return figure


def _residuals(d: Diagnosis) -> go.Figure:
    reach = linear_reach(d)
    left = [residual(run.measured, run.linear, reach=reach, noise=d.gap.noise) for run in d.runs]
    unit = left[0].unit if left else "µm"
    figure = _overlay(d, [one.values for one in left], f"measured − linear [{unit}]", unit)
    for one in left[:1]:
        _noise_band(figure, one.band, "y")
    return figure


def _noise_band(figure: go.Figure, reach: float, axis: str) -> None:
    figure.add_shape(
        type="rect", xref="paper", x0=0, x1=1, yref=axis, y0=-reach, y1=reach,
        fillcolor="var(--noise)", opacity=0.3, line_width=0, layer="below",
    )  # fmt: skip


def verification(run: VerificationRun, reach: float) -> go.Figure:
    """Draw a verification response above what is left of it, whose scale ends at ±`reach` [m]."""
    every, unit, drawn = verification_responses(run)
    left = verification_residual(run, reach=reach)
    kept = kept_samples(run.measured, left.values)
    time = listed(every[kept])
    figure = paired(left.unit, left.end)
    figure.add_scatter(x=time, y=listed(drawn["measured"][kept]), **own_line("measured", "measured", unit))
    figure.add_scatter(x=time, y=listed(drawn["simulated"][kept]), **own_line("after", "model", unit))
    figure.add_scatter(x=time, y=listed(left.values[kept]), yaxis="y2", **own_line("left", "residual", left.unit))
    if run.peak_time is not None:
        figure.add_shape(
            type="line", x0=run.peak_time, x1=run.peak_time, y0=0, y1=1, yref="paper",
            line={"color": "var(--mark)", "dash": "dash", "width": 1.2},
        )  # fmt: skip
    return figure


def _run(d: Diagnosis, run: RunGap, reach: float, rest: float) -> go.Figure:
    before = residual(run.measured, run.linear, reach=reach, noise=d.gap.noise)
    after = residual(run.measured, run.model, reach=rest, noise=d.gap.noise)
    kept = kept_samples(run.measured, before.values)
    figure = paired(before.unit, before.end, (after.unit, after.end) if d.effects else None)
    _add_responses(figure, responses(d, run), kept)
    left = [("y2", "before", "linear residual", before)]
    left += [("y3", "after", "effect residual", after)] if d.effects else []
    for axis, kind, name, one in left:
        y = listed(one.values[kept])
        figure.add_scatter(x=listed(run.time[kept]), y=y, yaxis=axis, **own_line(kind, name, one.unit))
        _noise_band(figure, one.band, axis)
    return figure


def _add_responses(figure: go.Figure, shown: Responses, kept: npt.NDArray[np.intp]) -> None:
    time = listed(shown.time[kept])
    for name, curve in shown.curves.items():
        figure.add_scatter(x=time, y=listed(curve[kept]), **own_line(*_LINES[name], shown.unit))


def _ring_down(d: Diagnosis, shown: RingDown) -> go.Figure:
    drawn = ring_down_responses(d, shown)
    figure = framed(go.Figure(), x="time [s]", y=f"position [{drawn.unit}]")
    figure.update_layout(
        hovermode="x unified", xaxis={"unifiedhovertitle": {"text": "%{x:.3f} s"}}, showlegend=True, margin={"t": 40}
    )
    _add_responses(figure, drawn, kept_samples(shown.measured, shown.measured - shown.linear))
    return figure


def _jump(d: Diagnosis, figure: go.Figure) -> go.Figure:
    """Mark by how much the force jumps at zero velocity."""
    jump = force_jump(d.where)
    if jump is not None:
        line = {"color": "var(--before)", "width": 2}
        figure.add_shape(type="line", x0=0, x1=0, y0=jump.below, y1=jump.above, line=line)
        figure.add_annotation(
            x=0, y=(jump.below + jump.above) / 2, text=jump.said, showarrow=False,
            xanchor="left", xshift=5, font={"color": "var(--before)"}, bgcolor="var(--card)",
        )  # fmt: skip
    return figure


def _force(shown: Force, of: str) -> go.Figure:
    figure = framed(go.Figure(), x=f"{of} [{shown.unit}]", y="residual force [N]")
    for levels, force in shown.pieces:
        figure.add_scatter(
            x=listed(levels),
            y=listed(force),
            mode="lines+markers",
            line={"color": "var(--run-0)", "width": 1.5},
            marker={"size": 6},
            meta={"at": f" {shown.unit}", "unit": "N"},
            hovertemplate=f"%{{x:.3g}} {shown.unit}<br>%{{y:.3g}} N<extra></extra>",
        )
    figure.update_xaxes(zeroline=True)
    figure.update_yaxes(zeroline=True)
    return figure


def _phases(d: Diagnosis) -> go.Figure:
    figure = framed(go.Figure(), x="", y="RMS, linear [µm]")
    shown = phase_levels(d)
    figure.add_bar(x=list(shown.names), y=shown.values["linear"], **bars("before", "linear"))
    noise_across(figure, shown.noise)
    figure.update_xaxes(automargin=True)  # where there is little room its words are turned
    return figure


def _gap(d: Diagnosis) -> go.Figure:
    shown = gap_levels(d)
    names = list(shown.names)
    figure = framed(go.Figure(), x="", y="RMS gap [µm]")
    for kind, values in shown.values.items():
        figure.add_scatter(x=names, y=values, **dots(*_DOTS[kind]))
    figure.add_scatter(x=names, y=[shown.noise] * len(names), **dots("noise", "noise"))
    low, high = shown.span or _NO_SPAN
    figure.update_yaxes(type="log", range=[np.log10(0.3 * low), np.log10(3 * high)], dtick=1)
    figure.update_layout(showlegend=True, scattermode="group", scattergap=0.4)
    return figure


def _candidates(d: Diagnosis) -> go.Figure:
    shown, noise, span = ranked_candidates(d, most=_SHOWN)
    names = [_broken(candidate_name(each.one.effects, each.one.deviations)) for each in shown]
    figure = framed(go.Figure(), x="RMS left [µm]", y="")
    for kind in ("after", "before"):  # what the diagnosis names, and the others
        part = [(name, each) for name, each in zip(names, shown, strict=True) if each.named == (kind == "after")]
        style = dots(kind, "") | {
            "orientation": "h",
            "texttemplate": "%{x:.3r}",
            "textposition": "middle right",
            "hovertemplate": "%{y}<br>%{x:.4g} µm<br>%{customdata}<extra></extra>",
        }
        figure.add_scatter(
            y=[name for name, _ in part],
            x=[each.left for _, each in part],
            customdata=[_worth(each.one, d.reaches_noise) for _, each in part],
            **style,
        )
    noise_upright(figure, noise)
    low, high = span or _NO_SPAN
    figure.update_xaxes(type="log", range=[np.log10(0.5 * low), np.log10(2.5 * high)], dtick=1)
    figure.update_yaxes(categoryorder="array", categoryarray=names[::-1], automargin=True)
    figure.update_layout(height=124 + BAR * len(shown) + 15 * "".join(names).count("<br>"))
    return figure


def _worth(one: Ranked, probable: bool) -> str:
    """What is said of a candidate that is pointed at."""
    said = f"explains {escape(per_cent(one.explained))} of the misfit"
    return f"{said}<br>probability {escape(chance(one.probability))}" if probable else said


def _broken(name: str) -> str:
    """A long name on lines of its own."""
    return escape(name).replace(" and ", " and<br>").replace(", ", ",<br>")


def _pull(d: Diagnosis) -> go.Figure:
    figure = framed(go.Figure(), x="linear fit off by [%]", y="")
    rows = linear_pull(d)
    names, reach = [escape(parameter_name(name)) for name, _, _ in rows], [reach for _, _, reach in rows]
    figure.add_scatter(
        x=listed(np.array([off for _, off, _ in rows])),
        y=names,
        mode="markers",
        marker={"color": "var(--before)", "size": 9, "symbol": "diamond"},
        error_x={"array": reach, "color": "var(--before)", "thickness": 1.5, "width": 4},
        customdata=reach,
        orientation="h",
        meta={"at": "", "unit": "%"},
        hovertemplate="%{y}<br>%{x:+.2f} % ± %{customdata:.2g} % (95 %)<extra></extra>",
    )
    figure.update_yaxes(categoryorder="array", categoryarray=names[::-1], automargin=True)
    figure.update_xaxes(zeroline=True)
    figure.update_layout(height=110 + BAR * len(names))
    return figure
