"""What the residual follows, where it is largest, and which candidates explain it."""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.axes import Axes

from stepid.core.takes import a, takes
from stepid.core.words import digits
from stepid.diagnosis.result import Diagnosis, Ranked, Where
from stepid.diagnosis.wording import candidate_name, chance, per_cent
from stepid.plot.gap import AFTER, BEFORE, NOISE, a_diagnosis
from stepid.plot.panels import Force, force_jump, phase_levels, position_force, ranked_candidates, velocity_force
from stepid.plot.scale import plain_logarithm
from stepid.plot.style import OTHER, SERIES, an_axes, dress, in_own_words, styled

_what = a((Diagnosis, Where), "a Diagnosis, or its `where`")
_SHOWN = 6  # candidates, for which there is room
_FEWEST = 3  # candidates in any case
_WIDE = 60  # letters of a candidate's name on one line


@in_own_words
@takes(d=_what, axes=an_axes)
def force_against_velocity(d: Diagnosis | Where, *, axes: Axes) -> Axes:
    """Draw the residual force of the linear model against velocity: Coulomb friction is a step at zero.

    Parameters
    ----------
    d : Diagnosis or Where
        A diagnosis, or its answer to where the linear model disagrees.
    axes : matplotlib.axes.Axes
        To draw into.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    where = d.where if isinstance(d, Diagnosis) else d
    _force(axes, velocity_force(where), "velocity")
    jump = force_jump(where)
    if jump is not None:
        with styled():
            axes.annotate("", (0, jump.above), (0, jump.below), arrowprops={"arrowstyle": "<->", "color": OTHER})
            axes.annotate(
                jump.said,
                (0, 0),
                xytext=(4, 2),
                textcoords="offset points",
                color=OTHER,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
            )
    return axes


@in_own_words
@takes(d=_what, axes=an_axes)
def force_against_position(d: Diagnosis | Where, *, axes: Axes) -> Axes:
    """Draw the residual force of the linear model against position from rest: a cubic spring is a cubic.

    Parameters
    ----------
    d : Diagnosis or Where
        A diagnosis, or its answer to where the linear model disagrees.
    axes : matplotlib.axes.Axes
        To draw into.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    where = d.where if isinstance(d, Diagnosis) else d
    return _force(axes, position_force(where), "position", " from rest")


def _force(axes: Axes, shown: Force, of: str, since: str = "") -> Axes:
    with styled():
        dress(axes)
        axes.axhline(0.0, color=AFTER, linewidth=0.6)
        axes.axvline(0.0, color=AFTER, linewidth=0.6)
        for levels, force in shown.pieces:
            axes.plot(levels, force, "o-", color=SERIES[0], markersize=3, linewidth=0.9)
        axes.set_xlabel(f"{of}{since} [{shown.unit}]")
        axes.set_ylabel("residual force [N]")
        axes.set_title(f"force against {of}")
    return axes


@in_own_words
@takes(d=a_diagnosis, axes=an_axes)
def phase_bars(d: Diagnosis, *, axes: Axes) -> Axes:
    """Draw the linear model's residual by phase of the response.

    Parameters
    ----------
    d : Diagnosis
    axes : matplotlib.axes.Axes
        To draw into.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    shown = phase_levels(d)
    places = range(len(shown.names))
    with styled():
        dress(axes)
        axes.bar(places, shown.values["linear"], 0.6, color=BEFORE, hatch="//", edgecolor="white", zorder=2)
        axes.axhline(shown.noise, color=NOISE, linestyle="--", label="noise", zorder=3)
        axes.set_xticks(places, shown.names, rotation=30, ha="right", rotation_mode="anchor")
        axes.grid(axis="x", visible=False)
        axes.set_ylabel("RMS, linear [µm]")
        axes.set_title("where: by phase")
        axes.legend()
    return axes


@in_own_words
@takes(d=a_diagnosis, axes=an_axes)
def candidates(d: Diagnosis, *, axes: Axes) -> Axes:
    """Draw what each of the best candidates leaves, best on top, with the linear model and the noise floor.

    Parameters
    ----------
    d : Diagnosis
    axes : matplotlib.axes.Axes
        To draw into.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, with a logarithmic scale.
    """
    most = _SHOWN
    while sum(_height(one) for one, _, _ in ranked_candidates(d, most=most)[0]) > _SHOWN + 1 and most > _FEWEST:
        most -= 1  # the linear model has its own place
    shown, noise, span = ranked_candidates(d, most=most)
    heights = np.array([_height(one) for one, _, _ in shown])
    places = np.cumsum(heights) - 1.0
    with styled():
        dress(axes)
        for place, (one, left, named) in zip(places.tolist(), shown, strict=True):
            color, marker = (AFTER, "o") if named else (BEFORE, "D")
            axes.plot([left], [place], marker, color=color, markersize=5, zorder=3)
            said = f"{digits(left)}{_explains(one, d.reaches_noise)}"
            axes.annotate(said, (left, place), xytext=(5, 0), textcoords="offset points", va="center", fontsize=7)
            # above its dot: beside it, long names would leave no room in a column
            axes.text(
                0.01,
                place - 0.26,
                _candidate(one),
                transform=axes.get_yaxis_transform(),
                va="bottom",
                fontsize=7,
                zorder=4,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
            )
        axes.axvline(noise, color=NOISE, linestyle="--", zorder=3)
        if not shown:
            axes.text(0.5, 0.5, "none was needed", transform=axes.transAxes, ha="center")
        if span:
            axes.set_xscale("log")
            low, high = 0.5 * span[0], span[1] ** 1.5 / span[0] ** 0.5 * 1.6  # with room for the numbers
            axes.set_xlim(low, high)
            plain_logarithm(axes.xaxis, marks=(1.0,) if high > 50 * low else (1.0, 2.0, 5.0))
        axes.set_yticks(places.tolist(), [""] * len(shown))
        axes.tick_params(axis="y", length=0)
        axes.set_ylim(max(float(heights.sum()), 1.0) - 0.7, -0.85)
        axes.set_xlabel(f"RMS left [µm] (dashed: noise; %: explained{', probable' if d.reaches_noise else ''})")
        axes.set_title("candidates")
    return axes


def _explains(one: Ranked, probable: bool) -> str:
    """What a candidate explains of the misfit, and how `probable` it is, in brackets; nothing for the linear model."""
    if not (one.effects or one.deviations):
        return ""
    return f"  ({per_cent(one.explained)}{', ' + chance(one.probability) if probable else ''})"


def _height(one: Ranked) -> float:
    """Places that a candidate takes: more where its name has further lines."""
    return 1.0 + 0.8 * _candidate(one).count("\n")


def _candidate(one: Ranked) -> str:
    if not (one.effects or one.deviations):
        return "linear"
    return textwrap.fill(candidate_name(one.effects, one.deviations), _WIDE)
