"""Axes, lines and bars that the interactive pictures share."""

from __future__ import annotations

import math
from typing import Any

import plotly.graph_objects as go

RUN_COLORS = tuple(f"var(--run-{i})" for i in range(7))
_MARKERS = ("circle", "square", "triangle-up", "diamond", "triangle-down", "cross", "x", "star")
_DASHES = ("solid", "dash", "dot")
BAR = 34  # pixels, a row of a bar chart
_HEIGHT = 330
_LINES: dict[str, dict[str, Any]] = {
    "measured": {"color": "var(--measured)", "width": 5},
    "before": {"color": "var(--before)", "width": 1.8, "dash": "dash"},
    "after": {"color": "var(--after)", "width": 1.5},
    "left": {"color": "var(--run-0)", "width": 1.4},
}
_NOISE = {"color": "var(--mark)", "dash": "dash", "width": 1.5}
_NAMED: dict[str, Any] = {"text": "noise", "font": {"color": "var(--mark)"}, "showarrow": False}
_PATTERNS = {"before": "/", "after": "", "noise": "."}


def run_line(run: int) -> tuple[str, str, str]:
    """Color, marker and dash of a run's curve wherever it is drawn; all alike only after 168 runs."""
    turn, color = divmod(run, len(RUN_COLORS))
    return RUN_COLORS[color], _MARKERS[(run + 3 * turn) % len(_MARKERS)], _DASHES[turn % len(_DASHES)]


def framed(figure: go.Figure, *, x: str, y: str) -> go.Figure:
    """Give a figure its axes."""
    figure.update_layout(
        template="none",
        height=_HEIGHT,
        margin={"l": 62, "r": 12, "t": 12, "b": 46 if x else 28},
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"color": "var(--ink)", "size": 12.5, "family": "system-ui, sans-serif"},
        showlegend=False,
        legend={"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"},
        hoverlabel={"bgcolor": "var(--card)", "bordercolor": "var(--line)", "font": {"color": "var(--ink)"}},
        hovermode="closest",
    )
    line = {"gridcolor": "var(--grid)", "zerolinecolor": "var(--line)", "linecolor": "var(--line)", "zeroline": False}
    figure.update_xaxes(title={"text": x, "standoff": 8, "font": {"size": 12.5}}, **line)
    figure.update_yaxes(title={"text": y, "standoff": 6, "font": {"size": 12.5}}, **line)
    return figure


def noise_across(figure: go.Figure, noise: float) -> None:
    """A line across at the noise, named on its right."""
    figure.add_hline(y=noise, line=_NOISE)
    figure.add_annotation(**_NAMED, x=1, xref="paper", xanchor="left", y=noise, yanchor="middle")
    figure.update_layout(margin={"r": 46})
    figure.update_yaxes(rangemode="nonnegative")


def noise_upright(figure: go.Figure, noise: float) -> None:
    """A line up at the noise, named on its top; the axis is logarithmic."""
    if noise > 0:
        figure.add_vline(x=noise, line=_NOISE)
        figure.add_annotation(**_NAMED, x=math.log10(noise), y=1, yref="paper", yanchor="bottom")
        figure.update_layout(margin={"t": 26})


def paired(what: str, reach: float) -> go.Figure:
    """A response above what is left of it, with one time axis; the lower scale ends at ±reach."""
    figure = framed(go.Figure(), x="time [s]", y="position [mm]")
    upper = figure.layout.yaxis.to_plotly_json()
    figure.update_layout(
        height=340,
        hovermode="x unified",
        hoversubplots="axis",
        xaxis={"anchor": "y2", "unifiedhovertitle": {"text": "%{x:.3f} s"}},
        yaxis={"domain": [0.42, 1.0]},
        yaxis2=upper
        | {"domain": [0.0, 0.34], "anchor": "x", "range": [-reach, reach], "zeroline": True}
        | {"title": {"text": f"residual [{what}]", "font": {"size": 11.5}}},
    )
    return figure


def own_line(kind: str, name: str, what: str) -> dict[str, Any]:
    """How a curve of one run looks, and what it says when pointed at."""
    return {
        "name": name,
        "mode": "lines",
        "line": _LINES[kind],
        "meta": {"at": " s", "unit": what},
        "hovertemplate": f"%{{y:.4g}} {what}",
    }


def bars(kind: str, name: str) -> dict[str, Any]:
    """How bars look, and what they say."""
    return {
        "name": name,
        "marker": {
            "color": f"var(--{kind})",
            "pattern": {"shape": _PATTERNS[kind], "fgcolor": "var(--card)", "fgopacity": 0.6, "size": 8}
            | {"fillmode": "overlay"},
        },
        "meta": {"at": "", "unit": "µm"},
        "texttemplate": "%{y:.3s}",
        "textposition": "outside",
        "cliponaxis": False,
        "hovertemplate": "%{x}<br>%{y:.4g} µm<extra>" + name + "</extra>",
    }
