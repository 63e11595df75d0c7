"""What people still have to say about drafts: each question with what leaves it open, in the order in which to ask."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from stepid.core.mass_offset import WEIGHT
from stepid.io.guess.draft import Draft, quantities_of_drafts
from stepid.io.guess.words import COUNTS


class Question(NamedTuple):
    """What is open: the field of `Answers` (or ``"position"``, a column), the question, the runs that it is about."""

    key: str
    text: str
    runs: tuple[str, ...]
    default: str = ""


def open_questions(drafts: Sequence[Draft]) -> tuple[Question, ...]:
    """List what no file tells and nobody has said, in the order in which to ask."""
    say = quantities_of_drafts(drafts).text
    found = []
    for key, asked in _ASKED.items():
        runs = tuple(draft.name for draft in drafts if asked.open(draft))
        if runs:
            found.append(Question(key, say(asked.text(drafts)), runs, asked.default(drafts)))
    return tuple(found)


def counts_alone(draft: Draft) -> bool:
    """Tell whether the position is in counts of which nothing says how large one is."""
    unit = draft.units.get("position")
    return unit is not None and unit.value == COUNTS and draft.scale("position") is None


class _Asked(NamedTuple):
    """When a draft leaves a question open, how it is asked, and what is proposed."""

    open: Callable[[Draft], bool]
    text: Callable[[Sequence[Draft]], str]
    default: Callable[[Sequence[Draft]], str] = lambda drafts: ""


def _words(text: str) -> Callable[[Sequence[Draft]], str]:
    return lambda drafts: text


def _has_table(draft: Draft, role: str) -> bool:
    return draft.format == "table" and role in draft.columns


def _which_column(drafts: Sequence[Draft]) -> str:
    choices = next((draft.choices for draft in drafts if draft.choices), ())
    return f'Which column is the position ({", ".join(choices)}; "all" if each is a run)?'


def _needs_sample_time(draft: Draft) -> bool:
    return draft.sample_time is None and draft.has_no_clock


def _which_sample_time(drafts: Sequence[Draft]) -> str:
    coarse = [draft for draft in drafts if _needs_sample_time(draft) and draft.repeated < 1]
    text = "How many seconds are two samples apart?"
    if not coarse:
        return text
    time = coarse[0].si("time")
    about = "" if time is None else f" Rows are about {float(time[-1] - time[0]) / (time.size - 1):.6g} s apart."
    return f"The times are printed too coarsely, so that they repeat.{about} {text}"


def _has_open_unit(draft: Draft) -> bool:
    open_ = draft.scale("position") is None and not counts_alone(draft)
    return open_ and _has_table(draft, "position")


def _may_turn(draft: Draft) -> bool:
    return draft.turn is not None and draft.motion is None and counts_alone(draft)


def _needs_step(draft: Draft) -> bool:
    return "input" not in draft.columns and draft.step is None and not draft.release


def _which_masses(drafts: Sequence[Draft]) -> str:
    names = ", ".join(draft.name for draft in drafts)
    return f"Which masses were added, in kg ({names})?" if len(drafts) > 1 else "Which mass was added, in kg?"


_ASKED: dict[str, _Asked] = {
    "position": _Asked(lambda d: d.format == "table" and "position" not in d.columns, _which_column),
    "time_unit": _Asked(
        lambda d: _has_table(d, "time") and d.scale("time") is None, _words("In which unit is the time: s, ms or us?")
    ),
    "sample_time": _Asked(_needs_sample_time, _which_sample_time),
    "position_unit": _Asked(
        _has_open_unit, _words("In which unit is the position: m, cm, mm, um, in, deg, rad or counts?")
    ),
    "motion": _Asked(
        _may_turn,
        _words(
            "The files tell the encoder's counts of a revolution. Does the plant turn (rotation) or move along "
            "(translation)?"
        ),
    ),
    "counts_per_meter": _Asked(
        lambda d: counts_alone(d) and not _may_turn(d), _words("How many counts are one meter?")
    ),
    "input_unit": _Asked(
        lambda d: "input" in d.columns and d.scale("input") is None,
        _words("In which unit is the input: V, mV, N, A, or how many volts is one of its units?"),
    ),
    "step": _Asked(_needs_step, _words("How large was the step of the input in V (0: the cart was let go)?")),
    "weight": _Asked(
        lambda d: d.mass is None and d.weights is not None,
        _words("How many kg is one weight?"),
        lambda drafts: "" if any(d.turns for d in drafts) else f"{WEIGHT:g}",
    ),
    "added_mass": _Asked(
        lambda d: d.mass is None and d.weights is None, _which_masses, lambda drafts: "0" if len(drafts) == 1 else ""
    ),
}
