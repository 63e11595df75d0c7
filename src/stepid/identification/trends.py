"""The trends that the paper teaches: what damping, mass and stiffness alone do to the response (Table 1)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Literal

from stepid.core.base import Label, Model
from stepid.core.estimate import format_value
from stepid.core.quantities import InputUnit, Motion, in_own_quantities, spoken
from stepid.core.recorded import recorded
from stepid.core.tables import html_table, text_table
from stepid.core.takes import a, each, takes
from stepid.errors import InputError
from stepid.identification.characteristics_model import Characteristics

_QUANTITIES = (("peak_time", "s"), ("overshoot", "–"), ("settling_time", "s"), ("static_gain", "m/V"))
_CLEAR = 2.0  # standard uncertainties that a change must exceed to be called one


class Trend(Model):
    """Runs in which only one thing varies, in its rising order.

    Parameters
    ----------
    varies : str
        ``"damping"``, ``"mass"`` or ``"stiffness"``.
    held : str
        What the runs have in common.
    runs : tuple of Characteristics
        In rising order of what varies.
    """

    varies: Literal["damping", "mass", "stiffness"]
    held: Label
    runs: tuple[Characteristics, ...]

    def change(self, quantity: str) -> str:
        """Say what a quantity does from the first run to the last.

        Parameters
        ----------
        quantity : str
            ``"peak_time"``, ``"overshoot"``, ``"settling_time"`` or ``"static_gain"``.

        Returns
        -------
        str
            ``"rises"``, ``"falls"``, ``"no clear change"`` (within two standard uncertainties) or ``"unknown"``.
        """
        first, last = getattr(self.runs[0], quantity), getattr(self.runs[-1], quantity)
        if first is None or last is None:
            return "unknown"
        u1, u2 = (getattr(run.uncertainty, quantity) or 0.0 for run in (self.runs[0], self.runs[-1]))
        if abs(last - first) <= _CLEAR * (u1**2 + u2**2) ** 0.5:
            return "no clear change"
        return "rises" if last > first else "falls"

    @spoken
    def setting(self, run: Characteristics) -> str:
        """What varies, of one run: its damper, its added mass or its spring, as text."""
        return _setting(self.varies, run)

    def _rows(self) -> list[tuple[str, ...]]:
        rows = [
            (
                f"{run.name} ({self.setting(run)})",
                *(
                    "–" if (value := getattr(run, q)) is None else format_value(value, getattr(run.uncertainty, q))
                    for q, _ in _QUANTITIES
                ),
            )
            for run in self.runs
        ]
        return [*rows, (f"more {self.varies}", *(self.change(q) for q, _ in _QUANTITIES))]

    def summary(self) -> str:
        """Return a table: a row a run, and what more of it does."""
        return text_table(_HEADER, self._rows(), title=self._title)

    @property
    def _title(self) -> str:
        return f"What {self.varies} does ({self.held})"

    def __repr__(self) -> str:
        return f"Trend({self.varies!r}, {len(self.runs)} runs)"

    __str__ = summary

    def _repr_html_(self) -> str:
        return html_table(_HEADER, self._rows(), title=self._title)


class Trends(Model):
    """All groups of runs in which only one thing varies, made by `find_trends`."""

    trends: tuple[Trend, ...]
    motion: Motion = "translation"
    input_unit: InputUnit = "V"

    def summary(self) -> str:
        """Return the tables of all trends."""
        return "\n\n".join(trend.summary() for trend in self.trends) or _NONE

    def __repr__(self) -> str:
        return f"Trends({', '.join(trend.varies for trend in self.trends)})"

    __str__ = summary

    def _repr_html_(self) -> str:
        return "".join(trend._repr_html_() for trend in self.trends) or f"<p>{_NONE}</p>"


_NONE = "No two runs differ in one thing only."
_HEADER = ("run", *(f"{quantity.replace('_', ' ')} [{unit}]" for quantity, unit in _QUANTITIES))


@in_own_quantities
@takes(runs=each(a(object, ""), "[stepid.characterize(run) for run in campaign.experiments]"))
@recorded()
def find_trends(runs: Iterable[Characteristics]) -> Trends:
    """Group runs in which only damping, only mass, or only stiffness varies.

    Parameters
    ----------
    runs : iterable of Characteristics
        Runs without a known added mass take no part; of several runs alike, the first counts.

    Returns
    -------
    Trends
        Damping is ordered by damping ratio, mass by added mass, stiffness by natural frequency; each group has at
        least two runs.

    Raises
    ------
    stepid.errors.InputError
        If a run is no `Characteristics`.
    """
    given: list[object] = list(runs)
    characterized = [run for run in given if isinstance(run, Characteristics)]
    if len(characterized) < len(given):
        raise InputError(
            "trends are found among the characteristics of runs, and there is something else",
            "Give [stepid.characterize(run) for run in campaign.experiments].",
        )
    known = [run for run in characterized if run.added_mass is not None and run.peak_time is not None]
    found = []
    for varies, key, order, held in _KINDS:
        groups: dict[tuple[object, ...], dict[object, Characteristics]] = {}
        for run in known:
            groups.setdefault(key(run), {}).setdefault(_setting(varies, run), run)
        for group in groups.values():
            if len(group) > 1:
                ordered = tuple(sorted(group.values(), key=order))
                found.append(Trend(varies=varies, held=held(ordered[0]), runs=ordered))
    return Trends(trends=tuple(found))


def _said(run: Characteristics, first: str, *kinds: str) -> str:
    """What runs share, but for labels that nobody gave."""
    given = [
        f"{kind} {getattr(run, kind)}" for kind in kinds if getattr(run, kind) != type(run).model_fields[kind].default
    ]
    return ", ".join(filter(None, (first, *given))) or "all else alike"


def _setting(varies: str, run: Characteristics) -> str:
    return {"damping": run.damper, "mass": f"{run.added_mass:g} kg", "stiffness": run.spring}[varies]


_Kind = tuple[
    Literal["damping", "mass", "stiffness"],
    Callable[[Characteristics], tuple[object, ...]],
    Callable[[Characteristics], float],
    Callable[[Characteristics], str],
]
_KINDS: tuple[_Kind, ...] = (
    (
        "damping",
        lambda run: (run.added_mass, run.spring, run.base),
        lambda run: run.damping_ratio,
        lambda run: _said(run, f"{run.added_mass:g} kg added", "spring", "base"),
    ),
    (
        "mass",
        lambda run: (run.spring, run.damper, run.base),
        lambda run: run.added_mass or 0.0,
        lambda run: _said(run, "", "spring", "damper", "base"),
    ),
    (
        "stiffness",
        lambda run: (run.added_mass, run.damper, run.base),
        lambda run: run.natural_frequency,
        lambda run: _said(run, f"{run.added_mass:g} kg added", "damper", "base"),
    ),
)
