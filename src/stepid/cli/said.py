"""Options that say what files of recordings do not: one definition for all commands that take such files."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from stepid.io.guess.spoken import numbers

if TYPE_CHECKING:
    from stepid.io.guess.answers import Answers

_PANEL = "What the recordings do not say"


def _option(flag: str, metavar: str, words: str) -> Any:
    return typer.Option(flag, metavar=metavar, help=words, show_default=False, rich_help_panel=_PANEL)


def _options(
    added_mass: Annotated[
        str | None, _option("--added-mass", "KG,KG,…", "Known weights, one a run in order of files, or one for all.")
    ] = None,
    weight: Annotated[float | None, _option("--weight", "KG", 'Of one weight, where names say "2mass".')] = None,
    position_unit: Annotated[
        str | None, _option("--position-unit", "UNIT", "m, cm, mm, um, in, deg, rad, counts, or meters per unit.")
    ] = None,
    counts_per_meter: Annotated[
        float | None, _option("--counts-per-meter", "COUNTS", "Of the encoder, where positions are counts.")
    ] = None,
    time_unit: Annotated[str | None, _option("--time-unit", "UNIT", "s, ms, us, or seconds per unit.")] = None,
    sample_time: Annotated[
        float | None, _option("--sample-time", "S", "Between two rows, without a time or with one that repeats.")
    ] = None,
    input_unit: Annotated[
        str | None, _option("--input-unit", "UNIT", "V, mV, N, A, N·m, or volts per unit as a number.")
    ] = None,
    step: Annotated[
        float | None, _option("--step", "V", "Of the input where no column is one; 0 for a free release.")
    ] = None,
    spring: Annotated[str | None, _option("--spring", "LABEL,…", "Of the springs, one a run, or one for all.")] = None,
    damper: Annotated[str | None, _option("--damper", "LABEL,…", "Of the dampers, one a run, or one for all.")] = None,
    time: Annotated[
        str | None, _option("--time", "COLUMN", "The column of the time, by name or number from 0.")
    ] = None,
    position: Annotated[
        str | None, _option("--position", "COLUMN", "The column of the position; all if each of several is a run.")
    ] = None,
    motion: Annotated[
        str | None, _option("--motion", "MOTION", "rotation where the plant turns: kg·m², rad and N·m.")
    ] = None,
    input_column: Annotated[str | None, _option("--input", "COLUMN", "The column of the input.")] = None,
) -> None:
    """Carry the options; nothing calls it."""


@dataclass(frozen=True)
class Said:
    """What the options say: answers, and columns by their role."""

    answers: Answers
    columns: dict[str, str]
    given: tuple[str, ...]

    @property
    def each(self) -> tuple[str, ...]:
        """Those of the answers that say another value for each run."""
        keys = ("added_mass", "spring", "damper")
        return tuple(key for key in keys if len(set(getattr(self.answers, key) or ())) > 1)

    def hearing(self, key: str, value: Any) -> Said:
        """Return what is said with another answer."""
        answers: dict[str, Any] = {key: value}
        return replace(self, answers=replace(self.answers, **answers))


def taking_answers(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command these options beside its own; it takes them as its first argument, `said`."""
    extra = inspect.signature(_options).parameters
    own = inspect.signature(command).parameters

    @functools.wraps(command)
    def wrapped(**given: Any) -> None:
        options = {key: given.pop(key) for key in extra}
        command(_said(options), **given)

    hints = {**get_type_hints(command, include_extras=True), **get_type_hints(_options, include_extras=True)}
    parameters = [
        parameter.replace(annotation=hints[name], kind=inspect.Parameter.KEYWORD_ONLY)
        for name, parameter in {**own, **extra}.items()
        if name != "said"
    ]
    wrapped.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    wrapped.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return wrapped


def _said(options: dict[str, Any]) -> Said:
    from stepid.io.guess.answers import Answers

    given = tuple(key for key, value in options.items() if value is not None)
    columns = {"time": options.pop("time"), "position": options.pop("position"), "input": options.pop("input_column")}
    if options["added_mass"] is not None:
        options["added_mass"] = numbers(options["added_mass"], "--added-mass")
    for key in ("spring", "damper"):
        if options[key] is not None:
            options[key] = tuple(label.strip() for label in options[key].split(","))
    return Said(Answers(**options), {role: name for role, name in columns.items() if name is not None}, given)
