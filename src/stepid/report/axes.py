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
_PATTERNS = {"before": "/"}
_DOTS = {"before": "diamond", "after": "circle", "noise": "square"}


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


def paired(what: str, reach: float, after: tuple[str, float] | None = None) -> go.Figure:
    """A response above what is left of it, with one time axis; the lower scale ends at ±reach.

    With `after`, unit and reach of the residual of a second model, that has a scale of its own below.
    """
    figure = framed(go.Figure(), x="time [s]", y="position [mm]")
    upper = figure.layout.yaxis.to_plotly_json()

    def lower(name: str, what: str, reach: float, domain: list[float]) -> dict[str, Any]:
        own: dict[str, Any] = {"domain": domain, "anchor": "x", "range": [-reach, reach], "zeroline": True, "nticks": 5}
        return {**upper, **own, "title": {"text": f"{name} [{what}]", "font": {"size": 11.5}}}

    figure.update_layout(
        height=340,
        hovermode="x unified",
        hoversubplots="axis",
        xaxis={"anchor": "y2", "unifiedhovertitle": {"text": "%{x:.3f} s"}},
        yaxis={"domain": [0.42, 1.0]},
        yaxis2=lower("residual", what, reach, [0.0, 0.34]),
    )
    if after is not None:
        figure.update_layout(
            height=430,
            xaxis={"anchor": "y3"},
            yaxis={"domain": [0.55, 1.0]},
            yaxis2=lower("linear", what, reach, [0.29, 0.49]),
            yaxis3=lower("after", *after, [0.0, 0.2]),
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


def dots(kind: str, name: str) -> dict[str, Any]:
    """How values on a logarithmic axis look, which has no zero for a bar to stand on, and what they say."""
    return {
        "name": name,
        "mode": "markers+text",
        "marker": {"color": f"var(--{kind})", "symbol": _DOTS[kind], "size": 10},
        "meta": {"at": "", "unit": "µm"},
        "texttemplate": "%{y:.3r}",
        "textposition": "top center",
        "cliponaxis": False,
        "hovertemplate": "%{x}<br>%{y:.4g} µm<extra>" + name + "</extra>",
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
        "texttemplate": "%{y:.3r}",
        "textposition": "outside",
        "cliponaxis": False,
        "hovertemplate": "%{x}<br>%{y:.4g} µm<extra>" + name + "</extra>",
    }
