"""What people say about drafts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stepid.core.base import Array
from stepid.core.mass_offset import WEIGHT
from stepid.core.quantities import MOTIONS
from stepid.errors import InputError
from stepid.io.ecp import FEWEST
from stepid.io.guess.draft import ROLES, TURNS, USUAL, Draft, Found
from stepid.io.guess.questions import counts_alone
from stepid.io.guess.words import COUNTS, SCALES, unit_for

SAID = "as you said"
MARK = "?"


@dataclass(frozen=True)
class Answers:
    """What was said, by flags or to questions; None where nothing was.

    Masses are in kg, `sample_time` in s, `step` in V; units are spelled as in `SCALES` or SI units per unit.
    """

    added_mass: tuple[float, ...] | None = None
    weight: float | None = None
    position_unit: str | None = None
    counts_per_meter: float | None = None
    time_unit: str | None = None
    sample_time: float | None = None
    input_unit: str | None = None
    step: float | None = None
    spring: tuple[str, ...] | None = None
    damper: tuple[str, ...] | None = None
    motion: str | None = None


def with_answers(drafts: Sequence[Draft], answers: Answers) -> tuple[Draft, ...]:
    """Put what was said into drafts; InputError where it cannot be meant."""
    masses = _each(answers.added_mass, len(drafts), "added_mass")
    springs, dampers = (_each(getattr(answers, key), len(drafts), key) for key in ("spring", "damper"))
    if answers.motion not in (None, *MOTIONS):
        raise InputError(f"motion is {answers.motion!r}", f"Give {' or '.join(MOTIONS)}.")
    if answers.motion is not None:
        drafts = [_moving(draft, Found(answers.motion, SAID)) for draft in drafts]
    out = [
        _signed(_with_times(_with_units(_with_labels(draft, mass, spring, damper, answers), answers), answers))
        for draft, mass, spring, damper in zip(drafts, masses, springs, dampers, strict=True)
    ]
    directions = {draft.falling for draft in out if _tells_direction(draft)}
    # one encoder, one sign: a single run that seems to go the other way is no proof of it
    falling = directions == {True} or _said_to_fall(answers)
    return tuple(_turned(draft.having(falling=falling)) for draft in out)


def _moving(draft: Draft, motion: Found[str]) -> Draft:
    """Say how the plant moves; where it turns, the encoder's angle is that of the plant."""
    if motion.value == "rotation" and draft.turn is not None and counts_alone(draft):
        draft = draft.having(scales={**draft.scales, "position": draft.turn})
    return draft.having(motion=motion)


def _turned(draft: Draft) -> Draft:
    """Say what of a draft does not go with an angle; an added mass in kg is none that turns."""
    unit, mass = draft.units.get("position"), draft.mass
    if unit is not None and unit.value in TURNS and not draft.turns and draft.motion is None:
        words = 'the position is an angle, the input a force: with motion = "rotation" give the torque in N·m'
        return draft.having(doubts=(*draft.doubts, words))
    if draft.turns and mass is not None and mass.value and mass.why != SAID:
        words = f"{mass.value:g} kg were added by {mass.why}: give their moment of inertia, in kg·m²"
        return draft.having(doubts=(*draft.doubts, words), mass=None, weights=None)
    return draft


def check_unit(role: str, said: str) -> str | float:
    """Return a unit as `SCALES` spells it, or SI units per unit; InputError where it is neither."""
    known = unit_for(said, role)
    if known is not None:
        return known
    try:
        scale = float(said.replace(",", "."))
    except ValueError:
        scale = 0.0
    if scale == 0 or not np.isfinite(scale):
        listed = ", ".join((*SCALES[role], *((COUNTS,) if role == "position" else ())))
        raise InputError(
            f"{said!r} is no unit of the {role}", f"Give one of {listed}, or SI units per unit as a number."
        )
    return scale


def _each(said: Sequence[object] | None, runs: int, key: str) -> list[object]:
    if said is None:
        return [None] * runs
    if len(said) not in (1, runs):
        raise InputError(
            f"{key} has {len(said)} values for {runs} runs", "Give one value a run, in their order, or one for all."
        )
    return [said[0]] * runs if len(said) == 1 else list(said)


def _with_labels(draft: Draft, mass: object, spring: object, damper: object, answers: Answers) -> Draft:
    weights = draft.weights
    if isinstance(mass, float):
        if not (np.isfinite(mass) and mass >= 0):
            raise InputError(f"added_mass is {mass:g} kg", "Give 0 or more.")
        draft = draft.having(mass=Found(mass, SAID))
    elif draft.mass is None and weights is not None:
        if answers.weight is not None:
            draft = draft.having(mass=Found(weights * answers.weight, f"{weights} × {answers.weight:g} kg"))
        elif draft.format == "ecp" and not draft.turns:  # the plant's own weights
            draft = draft.having(mass=Found(weights * WEIGHT, f"{weights} × {WEIGHT:g} kg, {USUAL}"))
    if isinstance(spring, str):
        draft = draft.having(spring=Found(spring, SAID))
    return draft.having(damper=Found(damper, SAID)) if isinstance(damper, str) else draft


def _with_units(draft: Draft, answers: Answers) -> Draft:
    """Units that were said go before those that were found."""
    units, scales = dict(draft.units), dict(draft.scales)
    for role in ROLES:
        said = getattr(answers, f"{role}_unit")
        if said is None or role not in draft.columns or draft.format == "ecp":
            continue
        unit = check_unit(role, said)
        if isinstance(unit, str):
            units[role] = Found(unit, SAID)
            scales.pop(role, None)
        else:
            scales[role] = Found(abs(unit) if role == "position" else unit, SAID)
            if not _is_of(role, units.get(role)):  # a sensor's volts, whose meters were said
                del units[role]
    counts = answers.counts_per_meter
    if counts is not None and not (np.isfinite(counts) and counts != 0):
        raise InputError(f"counts_per_meter is {counts:g}", "Give the counts of one meter.")
    found = units.get("position")
    if counts is not None and found is not None and found.value == COUNTS:
        scales["position"] = Found(1 / abs(counts), SAID)  # its sign is that of `falling`
    draft = draft.having(units=units, scales=scales)
    for role in ROLES:
        _check_column(draft, role)
    return draft


def _is_of(role: str, unit: Found[str] | None) -> bool:
    """Tell whether a unit is one of a role, or not known."""
    return unit is None or unit.value == COUNTS or unit.value in SCALES[role]


def _check_column(draft: Draft, role: str) -> None:
    """Refuse a column that was named for a role of which its unit is none."""
    unit = draft.units.get(role)
    if unit is None or _is_of(role, unit):
        return
    fitting = [name for name, own in draft.every if own in SCALES[role]] or [
        name for name, own in draft.every if own is None
    ]
    able = f"Columns that can be the {role}: {', '.join(fitting)}. " if fitting else ""
    raise InputError(
        f"{draft.file}: column {draft.titles[role]!r} is in {unit.value} by {unit.why}, no {role}",
        f"{able}If it is the {role} all the same, say the unit of the {role}.",
    )


def _with_times(draft: Draft, answers: Answers) -> Draft:
    """Sample time and step where no column has them, or stamps that repeat."""
    period, level = answers.sample_time, answers.step
    if period is not None:
        if not (np.isfinite(period) and period > 0):
            raise InputError(f"sample_time is {period:g} s", "Give a positive number of seconds.")
        if draft.repeated:
            draft = draft.having(sample_time=Found(period, SAID))
    if level is not None:
        if not np.isfinite(level):
            raise InputError("step is not finite", "Give its size in V.")
        position = draft.readings.get("position")
        known = position is None or position.size >= FEWEST
        if "input" not in draft.columns and known and not draft.release:
            start = None if position is None else _onset(draft)  # which column is the position is asked for
            draft = draft.having(step=Found((level, start), SAID))
    return draft


def _onset(draft: Draft) -> float:
    """When the cart starts to move, s: a step pulls it off like a parabola, whose root is the start."""
    position = draft.readings["position"]
    time = _clock(draft)
    moved = np.abs(position - np.median(position[:3]))
    top = int(np.argmax(moved > 0.3 * moved.max()))
    low = top
    while low > 0 and moved[low - 1] > 0.02 * moved.max():
        low -= 1
    if top - low < 3:
        return float(time[max(low - 1, 0)])
    root, middle = np.sqrt(moved[low : top + 1]), float(np.mean(time[low : top + 1]))
    later = time[low : top + 1] - middle  # about the middle a line has a slope however short the stretch, and late
    slope = float(later @ root) / (float(later @ later) or 1.0)  # stamps may all be the same
    start = middle - float(np.mean(root)) / slope if slope > 0 else float(time[0])
    return float(time[int(np.argmin(np.abs(time - start)))])


def _clock(draft: Draft) -> Array:
    time = draft.clock()
    return np.arange(draft.readings["position"].size, dtype=np.float64) if time is None else time


def _signed(draft: Draft) -> Draft:
    """Where a step was said, its sign against the motion tells whether readings fall."""
    if draft.step is None or draft.step.value[0] == 0 or "position" not in draft.readings:
        return draft
    position: Array = draft.readings["position"]
    rise = float(np.mean(position[position.size // 2 :]) - np.median(position[:3]))
    return draft.having(falling=rise * draft.step.value[0] < 0)


def _said_to_fall(answers: Answers) -> bool:
    unit = None if answers.position_unit is None else check_unit("position", answers.position_unit)
    return (answers.counts_per_meter or 0.0) < 0 or (isinstance(unit, float) and unit < 0)


def _tells_direction(draft: Draft) -> bool:
    return ("input" in draft.readings and bool(np.any(draft.readings["input"]))) or bool(
        draft.step is not None and draft.step.value[0] and "position" in draft.readings
    )
