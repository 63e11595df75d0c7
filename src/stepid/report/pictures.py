"""The interactive pictures, drawn by plotly; colors are named, so that the page can show them light or dark."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import plotly.graph_objects as go

from stepid.core.base import Array
from stepid.core.latex import parameter_name
from stepid.core.quantities import in_own_quantities
from stepid.diagnosis.result import Diagnosis, Ranked, RunGap
from stepid.diagnosis.wording import candidate_name, chance, per_cent
from stepid.identification.transfer.verification import VerificationRun
from stepid.plot.causes import jump_ends, leading
from stepid.plot.ring_down import RingDown, zoomed_ring_down
from stepid.plot.scale import length_unit, reach_of
from stepid.report.axes import BAR, bars, dots, framed, noise_across, noise_upright, own_line, paired, run_line
from stepid.report.pull import linear_pull
from stepid.report.thin import kept_samples

_SHOWN = 8  # candidates
_MARKED = 9  # markers on a curve


@in_own_quantities
def pictures(d: Diagnosis, verified: Sequence[VerificationRun]) -> dict[str, Any]:
    """Draw all interactive pictures of a report.

    Parameters
    ----------
    d : Diagnosis
    verified : sequence of VerificationRun
        Of the hand method; empty where it has none.

    Returns
    -------
    dict of str to dict
        By name, as plotly's JSON; a picture of one run is called ``"run-3"`` by the run's place in the diagnosis.
    """
    place = {run.name: i for i, run in enumerate(d.runs)}
    reach = reach_of(run.measured - run.linear for run in d.runs)
    rest = reach_of([*(run.measured - run.model for run in d.runs), np.array([2 * d.gap.noise])])
    drawn = {
        "records": _overlay(d, [1e3 * run.measured for run in d.runs], "position [mm]", "mm"),
        "residuals": _residuals(d),
        "phases": _phases(d),
        "velocity": _jump(
            d, _force(d.where.velocity_levels, d.where.velocity_force, "velocity [m/s]", "m/s", parted=True)
        ),
        "position": _force(1e3 * d.where.position_levels, d.where.position_force, "from rest [mm]", "mm", parted=False),
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


def _listed(values: Array) -> list[float]:
    """Five digits are more than a screen shows, and an eighth of the size."""
    return [float(f"{v:.5g}") for v in values]


def _overlay(d: Diagnosis, curves: Sequence[Array], label: str, what: str) -> go.Figure:
    figure = framed(go.Figure(), x="time [s]", y=label)
    for i, (run, curve) in enumerate(zip(d.runs, curves, strict=True)):
        kept = kept_samples(curve)
        color, symbol, dash = run_line(i)
        figure.add_scatter(
            x=_listed(run.time[kept]),
            y=_listed(curve[kept]),
            name=escape(run.name),
            meta={"run": i, "at": " s", "unit": what},
            mode="lines+markers",
            line={"color": color, "width": 1.4, "dash": dash},
            marker={"symbol": symbol, "size": 7, "maxdisplayed": _MARKED},
            hovertemplate=f"%{{fullData.name}}<br>%{{x:.3f}} s<br>%{{y:.4g}} {what}<extra></extra>",
        )
    return figure


def _residuals(d: Diagnosis) -> go.Figure:
    left = [run.measured - run.linear for run in d.runs]
    scale, what = length_unit(reach_of(left))
    figure = _overlay(d, [scale * one for one in left], f"measured − linear [{what}]", what)
    _noise_band(figure, 2 * scale * d.gap.noise, "y")
    return figure


def _noise_band(figure: go.Figure, reach: float, axis: str) -> None:
    figure.add_shape(
        type="rect", xref="paper", x0=0, x1=1, yref=axis, y0=-reach, y1=reach,
        fillcolor="var(--noise)", opacity=0.3, line_width=0, layer="below",
    )  # fmt: skip


def verification(run: VerificationRun, reach: float) -> go.Figure:
    """Draw a verification response above what is left of it, whose scale ends at ±`reach` [m]."""
    scale, what = length_unit(reach)
    left = scale * (run.measured - run.simulated)
    kept = kept_samples(run.measured, left)
    time = _listed(run.time[kept])
    figure = paired(what, 1.05 * scale * reach)
    figure.add_scatter(x=time, y=_listed(1e3 * run.measured[kept]), **own_line("measured", "measured", "mm"))
    figure.add_scatter(x=time, y=_listed(1e3 * run.simulated[kept]), **own_line("after", "model", "mm"))
    figure.add_scatter(x=time, y=_listed(left[kept]), yaxis="y2", **own_line("left", "residual", what))
    if run.peak_time is not None:
        figure.add_shape(
            type="line", x0=run.peak_time, x1=run.peak_time, y0=0, y1=1, yref="paper",
            line={"color": "var(--mark)", "dash": "dash", "width": 1.2},
        )  # fmt: skip
    return figure


def _run(d: Diagnosis, run: RunGap, reach: float, rest: float) -> go.Figure:
    scale, what = length_unit(reach)
    finer, small = length_unit(rest)
    before, after = scale * (run.measured - run.linear), finer * (run.measured - run.model)
    kept = kept_samples(run.measured, before)
    time = _listed(run.time[kept])
    figure = paired(what, 1.05 * scale * reach, (small, 1.05 * finer * rest) if d.effects else None)
    figure.add_scatter(x=time, y=_listed(1e3 * run.measured[kept]), **own_line("measured", "measured", "mm"))
    figure.add_scatter(x=time, y=_listed(1e3 * run.linear[kept]), **own_line("before", "linear", "mm"))
    if d.effects:
        figure.add_scatter(x=time, y=_listed(1e3 * run.model[kept]), **own_line("after", "with effect", "mm"))
    figure.add_scatter(x=time, y=_listed(before[kept]), yaxis="y2", **own_line("before", "linear residual", what))
    _noise_band(figure, 2 * scale * d.gap.noise, "y2")
    if d.effects:
        figure.add_scatter(x=time, y=_listed(after[kept]), yaxis="y3", **own_line("after", "effect residual", small))
        _noise_band(figure, 2 * finer * d.gap.noise, "y3")
    return figure


def _ring_down(d: Diagnosis, shown: RingDown) -> go.Figure:
    scale, what = length_unit(reach_of([shown.measured - shown.measured[-1]]))
    figure = framed(go.Figure(), x="time [s]", y=f"position [{what}]")
    figure.update_layout(
        hovermode="x unified", xaxis={"unifiedhovertitle": {"text": "%{x:.3f} s"}}, showlegend=True, margin={"t": 40}
    )
    kept = kept_samples(shown.measured, shown.measured - shown.linear)
    curves = [("measured", "measured", shown.measured), ("before", "linear", shown.linear)]
    curves += [("after", "with effect", shown.model)] if d.effects else []
    for kind, name, curve in curves:
        figure.add_scatter(x=_listed(shown.time[kept]), y=_listed(scale * curve[kept]), **own_line(kind, name, what))
    return figure


def _jump(d: Diagnosis, figure: go.Figure) -> go.Figure:
    """Mark by how much the force jumps at zero velocity."""
    ends = jump_ends(d.where)
    if ends is not None:
        line = {"color": "var(--before)", "width": 2}
        figure.add_shape(type="line", x0=0, x1=0, y0=ends[0], y1=ends[1], line=line)
        figure.add_annotation(
            x=0, y=sum(ends) / 2, text=f"jump {abs(ends[1] - ends[0]):.2g} N", showarrow=False,
            xanchor="left", xshift=5, font={"color": "var(--before)"}, bgcolor="var(--card)",
        )  # fmt: skip
    return figure


def _force(levels: Array, force: Array, label: str, what: str, *, parted: bool) -> go.Figure:
    figure = framed(go.Figure(), x=label, y="residual force [N]")
    # no line across zero velocity: what happens there is the point of the picture
    for part in (levels < 0, levels >= 0) if parted else (np.ones(levels.size, dtype=bool),):
        figure.add_scatter(
            x=_listed(levels[part]),
            y=_listed(force[part]),
            mode="lines+markers",
            line={"color": "var(--run-0)", "width": 1.5},
            marker={"size": 6},
            meta={"at": f" {what}", "unit": "N"},
            hovertemplate=f"%{{x:.3g}} {what}<br>%{{y:.3g}} N<extra></extra>",
        )
    figure.update_xaxes(zeroline=True)
    figure.update_yaxes(zeroline=True)
    return figure


def _phases(d: Diagnosis) -> go.Figure:
    figure = framed(go.Figure(), x="", y="RMS, linear [µm]")
    figure.add_bar(x=list(d.where.phases), y=[1e6 * v for v in d.where.phases.values()], **bars("before", "linear"))
    noise_across(figure, 1e6 * d.gap.noise)
    figure.update_xaxes(automargin=True)  # where there is little room its words are turned
    return figure


def _gap(d: Diagnosis) -> go.Figure:
    groups = [("fitted", d.gap.before, d.gap.after)]
    if d.gap.held_out:
        groups.append(("held out", *d.gap.held_out))
    names = [name for name, _, _ in groups]
    figure = framed(go.Figure(), x="", y="RMS gap [µm]")
    figure.add_scatter(x=names, y=[1e6 * before for _, before, _ in groups], **dots("before", "linear model"))
    if d.effects:
        figure.add_scatter(x=names, y=[1e6 * after for _, _, after in groups], **dots("after", "with the effect"))
    figure.add_scatter(x=names, y=[1e6 * d.gap.noise] * len(groups), **dots("noise", "noise"))
    values = [1e6 * v for _, before, after in groups for v in (before, after, d.gap.noise) if v > 0] or [1.0]
    figure.update_yaxes(type="log", range=[np.log10(0.3 * min(values)), np.log10(3 * max(values))], dtick=1)
    figure.update_layout(showlegend=True, scattermode="group", scattergap=0.4)
    return figure


def _candidates(d: Diagnosis) -> go.Figure:
    shown = leading(d, most=_SHOWN)
    names = [_broken(candidate_name(one.effects, one.deviations)) for one, _ in shown]
    figure = framed(go.Figure(), x="RMS left [µm]", y="")
    for kind in ("after", "before"):  # what the diagnosis names, and the others
        part = [(name, one) for name, (one, named) in zip(names, shown, strict=True) if named == (kind == "after")]
        style = dots(kind, "") | {
            "orientation": "h",
            "texttemplate": "%{x:.3r}",
            "textposition": "middle right",
            "hovertemplate": "%{y}<br>%{x:.4g} µm<br>%{customdata}<extra></extra>",
        }
        figure.add_scatter(
            y=[name for name, _ in part],
            x=[1e6 * one.rms for _, one in part],
            customdata=[_worth(one) for _, one in part],
            **style,
        )
    noise_upright(figure, 1e6 * d.gap.noise)
    values = [1e6 * v for v in (d.gap.noise, *(one.rms for one, _ in shown)) if v > 0] or [1.0]
    figure.update_xaxes(type="log", range=[np.log10(0.5 * min(values)), np.log10(2.5 * max(values))], dtick=1)
    figure.update_yaxes(categoryorder="array", categoryarray=names[::-1], automargin=True)
    figure.update_layout(height=124 + BAR * len(shown) + 15 * "".join(names).count("<br>"))
    return figure


def _worth(one: Ranked) -> str:
    """What is said of a candidate that is pointed at."""
    return f"explains {escape(per_cent(one.explained))} of the misfit<br>probability {escape(chance(one.probability))}"


def _broken(name: str) -> str:
    """A long name on lines of its own."""
    return escape(name).replace(" and ", " and<br>").replace(", ", ",<br>")


def _pull(d: Diagnosis) -> go.Figure:
    figure = framed(go.Figure(), x="linear fit off by [%]", y="")
    rows = linear_pull(d)
    names, reach = [escape(parameter_name(name)) for name, _, _ in rows], [reach for _, _, reach in rows]
    figure.add_scatter(
        x=_listed(np.array([off for _, off, _ in rows])),
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
