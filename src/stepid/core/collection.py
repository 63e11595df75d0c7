"""What makes a campaign a collection of its runs, and how it is shown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING, Any, Self, cast, overload

import numpy as np

from stepid.core.base import Model
from stepid.core.slices import parts_of
from stepid.core.tables import text_table
from stepid.core.takes import described
from stepid.core.words import counted
from stepid.errors import InputError, MissingPackageError

if TYPE_CHECKING:
    from stepid.core.experiment import Campaign, Experiment

_POINTS, _WIDTH, _HEIGHT = 120, 120, 24  # of a sketch of a record, pixels
_HEADER = ("run", "samples", "duration [s]", "input [V]", "travel [mm]", "added mass [kg]", "spring", "damper", "base")


class _Field(str):
    """Name of a field, which is not the name of a run: what ``dict(campaign)`` asks for."""


class Runs(Model):
    """The part of a campaign that is a collection of experiments."""

    if TYPE_CHECKING:
        name: str
        experiments: tuple[Experiment, ...]

    def __len__(self) -> int:
        return len(self.experiments)

    def __iter__(self) -> Iterator[Experiment]:  # type: ignore[override]
        return iter(self.experiments)

    def __contains__(self, run: object) -> bool:
        return any(run == (e.name if isinstance(run, str) else e) for e in self.experiments)

    def keys(self) -> tuple[str, ...]:
        """Names of the fields, so that ``dict(campaign)`` holds them as it does for other models."""
        return tuple(_Field(field) for field in type(self).model_fields)

    @overload
    def __getitem__(self, key: str | int) -> Experiment: ...

    @overload
    def __getitem__(self, key: slice | list[str] | list[int]) -> Self: ...

    def __getitem__(self, key: Any) -> Any:
        """Return the run of a name or a place; of a slice or a list of names, a campaign of those runs."""
        if isinstance(key, _Field):
            return getattr(self, key)
        if isinstance(key, slice):
            kept = self.experiments[key]
            if not kept:
                raise InputError(f"campaign {self.name!r}: the slice holds no run", f"It has {len(self)} runs.")
            return self._of(kept)
        if isinstance(key, list):
            return self._of(tuple(self._run(one) for one in key))
        return self._run(key)

    def __add__(self, more: object) -> Self:
        """Return a campaign with a run, or the runs of another campaign or a list, at its end."""
        added = _runs_of(more)
        if added is None:
            return NotImplemented
        if isinstance(more, Runs):
            for field in set(type(self).model_fields) - {"name", "experiments"}:
                one, two = getattr(self, field), getattr(more, field)
                if one != two:
                    raise InputError(
                        f"campaigns {self.name!r} and {more.name!r} differ in {field}: {one!r} and {two!r}",
                        "If what belongs to the first holds for all, add the runs alone: campaign + list(other).",
                    )
        return self._of((*self.experiments, *added), more)

    def in_parts(self, number: int) -> Self:
        """Cut each run into equal parts, which are runs of their own: a model of one is then checked on another.

        Parameters
        ----------
        number : int
            Parts of each run, 2 or more; each needs 8 samples.

        Returns
        -------
        Campaign
            Its runs are called ``"case 4, part 1"`` and so on; see `stepid.Experiment.slice`.

        Raises
        ------
        stepid.errors.InputError
            If the number is none, or a record is too short for so many.
        """
        if isinstance(number, bool) or not isinstance(number, int | np.integer) or number < 2:
            raise InputError(
                f"campaign {self.name!r}: the number of parts is {described(number)}", "Give a whole number from 2 on."
            )
        return self._of(tuple(part for run in self.experiments for part in parts_of(run, int(number))))

    def summary(self) -> str:
        """Return a table of the runs."""
        return text_table(_HEADER, [_row(run) for run in self.experiments], title=self._title())

    def plot(self, *, axes: Any = None) -> Any:
        """Draw the records over each other, positions above inputs; see `stepid.plot.records`.

        Parameters
        ----------
        axes : pair of matplotlib.axes.Axes, optional
            To draw into; a new figure by default.

        Returns
        -------
        pair of matplotlib.axes.Axes

        Raises
        ------
        stepid.errors.MissingPackageError
            If matplotlib is not installed.
        """
        try:
            from stepid.plot.records import records
        except ModuleNotFoundError:
            raise MissingPackageError(
                "a picture needs the package 'matplotlib'", "Install it with: pip install 'stepid[plot]'."
            ) from None
        return records(cast("Campaign", self), axes=axes)

    def __repr__(self) -> str:
        return (
            f"Campaign({self.name!r}, {counted(len(self), 'run')}: {', '.join(repr(e.name) for e in self.experiments)})"
        )

    __str__ = summary

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(cell)}</th>" for cell in (*_HEADER, "position"))
        body = ""
        for run in self.experiments:
            first, *rest = _row(run)
            cells = "".join(f"<td>{escape(cell)}</td>" for cell in rest)
            body += f"<tr><th>{escape(first)}</th>{cells}<td>{_sketch(run)}</td></tr>"
        caption = f"<caption>{escape(self._title())}</caption>"
        return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

    def _title(self) -> str:
        return f"Campaign {self.name!r}: {counted(len(self), 'run')}"

    def _ipython_key_completions_(self) -> list[str]:
        return [run.name for run in self.experiments]

    def _run(self, key: object) -> Experiment:
        if isinstance(key, int | np.integer) and not isinstance(key, bool) and -len(self) <= key < len(self):
            return self.experiments[key]
        for run in self.experiments:
            if isinstance(key, str) and run.name == key:
                return run
        names = ", ".join(repr(run.name) for run in self.experiments)
        said = described(key) if isinstance(key, str | int) else f"of {type(key).__name__}"
        raise InputError(f"campaign {self.name!r} has no run {said}", f"Its runs are {names}.")

    def _of(self, runs: tuple[Experiment, ...], more: object = None) -> Self:
        """Make a campaign of other runs, with all else as it is; it comes from what this one does, and `more`."""
        from stepid.core.provenance import joined

        fields = {field: getattr(self, field) for field in type(self).model_fields}
        out = type(self)(**fields | {"experiments": runs})
        return out._bearing(joined(self, more))


def _runs_of(more: object) -> tuple[Experiment, ...] | None:
    """Return the runs in what is added to a campaign; None where it is something else."""
    from stepid.core.experiment import Experiment

    if isinstance(more, Experiment):
        return (more,)
    if isinstance(more, Iterable) and not isinstance(more, str | bytes):
        runs = tuple(more)
        if all(isinstance(run, Experiment) for run in runs):
            return runs
    return None


def as_tuple(value: object) -> object:
    """Return a list as a tuple, anything else as it is."""
    return tuple(value) if isinstance(value, list) else value


def check_names(names: Sequence[str]) -> None:
    """Raise ValueError where there is no run, or two of one name."""
    if not names:
        raise ValueError("holds no experiment; add at least one run")
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise ValueError(f"the name {twice[0]!r} is used by more than one run; give each run its own name")


def _row(run: Experiment) -> tuple[str, ...]:
    return (
        run.name,
        str(run.time.size),
        f"{run.time[-1] - run.time[0]:.4g}",
        _driven(run),
        f"{1e3 * float(np.ptp(run.position)):.3g}",
        f"{run.added_mass:g}",
        run.spring,
        run.damper,
        run.base,
    )


def _driven(run: Experiment) -> str:
    """Say in short how a run is driven."""
    if run.is_release:
        return "release"
    levels = np.append(run.input_before, run.input)
    changes = int(np.count_nonzero(np.diff(levels)))
    if changes == 1:
        return f"{levels[0]:g} → {levels[-1]:g}"
    return f"{levels.min():g} … {levels.max():g}" + ("" if changes == 0 else f", {changes} changes")


def _sketch(run: Experiment) -> str:
    """Draw the position as a small curve."""
    shown = run.position[:: -(-run.time.size // _POINTS)]
    low, span = float(shown.min()), float(np.ptp(shown)) or 1.0
    x = np.linspace(1, _WIDTH - 1, shown.size)
    y = _HEIGHT - 2 - (_HEIGHT - 4) * (shown - low) / span
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    return (
        f'<svg width="{_WIDTH}" height="{_HEIGHT}" role="img" aria-label="position over time">'
        f'<polyline points="{points}" fill="none" stroke="currentColor"/></svg>'
    )
