"""What the residual follows, where it is largest, and which candidates explain it."""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.axes import Axes

from stepid.core.base import Array
from stepid.core.takes import a, takes
from stepid.diagnosis.result import Diagnosis, Ranked, Where
from stepid.diagnosis.wording import candidate_name, chance, digits, per_cent
from stepid.plot.gap import AFTER, BEFORE, NOISE, a_diagnosis
from stepid.plot.scale import plain_logarithm
from stepid.plot.style import OTHER, SERIES, an_axes, dress, in_own_words, styled

_what = a((Diagnosis, Where), "a Diagnosis, or its `where`")
_SHOWN = 6  # candidates, for which there is room
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
    _force(axes, where.velocity_levels, where.velocity_force, "velocity [m/s]", 1.0, parted=True)
    ends = jump_ends(where)
    if ends is not None:
        with styled():
            axes.annotate("", (0, ends[1]), (0, ends[0]), arrowprops={"arrowstyle": "<->", "color": OTHER})
            axes.annotate(
                f"jump {abs(ends[1] - ends[0]):.2g} N",
                (0, 0),
                xytext=(4, 2),
                textcoords="offset points",
                color=OTHER,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
            )
    return axes


def jump_ends(where: Where) -> tuple[float, float] | None:
    """Forces [N] below and above zero velocity, apart by the jump; None where there is none."""
    below, above = where.velocity_force[where.velocity_levels < 0], where.velocity_force[where.velocity_levels >= 0]
    if where.jump is None or not below.size or not above.size:
        return None
    middle = float(below[-1] + above[0]) / 2
    return middle - where.jump / 2, middle + where.jump / 2


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
    return _force(axes, where.position_levels, where.position_force, "position from rest [mm]", 1e3, parted=False)


def _force(axes: Axes, levels: Array, force: Array, label: str, factor: float, *, parted: bool) -> Axes:
    with styled():
        dress(axes)
        axes.axhline(0.0, color=AFTER, linewidth=0.6)
        axes.axvline(0.0, color=AFTER, linewidth=0.6)
        # no line across zero velocity: what happens there is the point of the picture
        parts = (levels < 0, levels >= 0) if parted else (np.ones(levels.size, dtype=bool),)
        for part in parts:
            axes.plot(factor * levels[part], force[part], "o-", color=SERIES[0], markersize=3, linewidth=0.9)
        axes.set_xlabel(label)
        axes.set_ylabel("residual force [N]")
        axes.set_title(f"force against {label.split(' [')[0].removesuffix(' from rest')}")
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
    names, values = list(d.where.phases), [1e6 * rms for rms in d.where.phases.values()]
    with styled():
        dress(axes)
        axes.bar(range(len(names)), values, 0.6, color=BEFORE, hatch="//", edgecolor="white", zorder=2)
        axes.axhline(1e6 * d.gap.noise, color=NOISE, linestyle="--", label="noise", zorder=3)
        axes.set_xticks(range(len(names)), names, rotation=30, ha="right", rotation_mode="anchor")
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
    shown = leading(d, most=_SHOWN)
    with styled():
        dress(axes)
        for place, (one, named) in enumerate(shown):
            color, marker = (AFTER, "o") if named else (BEFORE, "D")
            axes.plot([1e6 * one.rms], [place], marker, color=color, markersize=5, zorder=3)
            said = f"{digits(1e6 * one.rms)}{_explains(one)}"
            at = (1e6 * one.rms, place)
            axes.annotate(said, at, xytext=(5, 0), textcoords="offset points", va="center", fontsize=7)
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
        axes.axvline(1e6 * d.gap.noise, color=NOISE, linestyle="--", zorder=3)
        if not shown:
            axes.text(0.5, 0.5, "none was needed", transform=axes.transAxes, ha="center")
        values = [1e6 * v for v in (d.gap.noise, *(one.rms for one, _ in shown)) if v > 0]
        if values:
            axes.set_xscale("log")
            low, high = 0.5 * min(values), max(values) ** 1.5 / min(values) ** 0.5 * 1.6  # with room for the numbers
            axes.set_xlim(low, high)
            plain_logarithm(axes.xaxis, marks=(1.0,) if high > 50 * low else (1.0, 2.0, 5.0))
        axes.set_yticks(range(len(shown)), [""] * len(shown))
        axes.tick_params(axis="y", length=0)
        axes.set_ylim(max(len(shown), 1) - 0.7, -0.85)
        axes.set_xlabel("RMS left [µm] (dashed: noise; %: explained, probable)")
        axes.set_title("candidates")
    return axes


def leading(d: Diagnosis, *, most: int) -> list[tuple[Ranked, bool]]:
    """The best candidates, then the linear model, each with whether the diagnosis names it, alone or among others.

    A set of effects that was fitted with and without conditions that differ between runs counts as named once: where
    it leaves what the answer leaves, else where it ranks best.
    """
    named: dict[tuple[str, ...], Ranked] = {}
    for one in d.ranking:
        answered = one.effects == d.effects and one.rms == d.gap.after
        if one.effects and one.effects in (d.effects, *d.alternatives) and (answered or one.effects not in named):
            named[one.effects] = one
    plain = [one for one in d.ranking if not (one.effects or one.deviations)][:1]
    best = [one for one in d.ranking if one.effects or one.deviations][:most] + plain
    return [(one, named.get(one.effects) is one) for one in best]


def _explains(one: Ranked) -> str:
    """What a candidate explains of the misfit, and how probable it is, in brackets; nothing for the linear model."""
    if not (one.effects or one.deviations):
        return ""
    return f"  ({per_cent(one.explained)}, {chance(one.probability)})"


def _candidate(one: Ranked) -> str:
    if not (one.effects or one.deviations):
        return "linear"
    return textwrap.fill(candidate_name(one.effects, one.deviations), _WIDE)
