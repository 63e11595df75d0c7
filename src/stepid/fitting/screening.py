"""Which runs and stretches of a campaign a joint fit can use; what it cannot is left out by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from stepid.core.experiment import Campaign, Experiment
from stepid.core.noise import record_noise
from stepid.core.releases import release_index, split_releases
from stepid.core.units import UNIT, check_speed, check_travel
from stepid.errors import InputError
from stepid.fitting.reading_faults import Mask, mend
from stepid.fitting.record_fault import RecordFault
from stepid.simulation.clock import clock_note
from stepid.simulation.starts import starts_in_motion

_LIKE = 0.9  # share of an input change that another must have to be as strong
_LATE = 4.0  # times the usual time to an answer
_STILL = 0.005  # of a run's travel: less is no motion
_LEAD = 10  # samples at rest that are kept before the first step
_REST = 40  # samples before a step in which a cart at rest does not move
_FIRST = 8  # samples in which a record that starts in motion moves
_LEAST = 24  # samples that a run must have after its unusable stretch


class Screened(NamedTuple):
    """The part of a campaign that can be fitted, and in words what was left out."""

    campaign: Campaign
    notes: tuple[str, ...]
    faults: tuple[RecordFault, ...] = ()
    wrong: Mapping[str, Mask] = MappingProxyType({})  # run name to samples that are interpolated, where there are any


class _Answer(NamedTuple):
    """What a run does after a change of its input at sample `at`, until sample `end`."""

    at: int
    end: int
    change: float  # V
    before: float  # V
    lag: float | None  # s to the first motion, None where nothing moves
    rests: bool  # the cart is at rest before


def screen(campaign: Campaign) -> Screened:
    """Leave out runs in which nothing moves, copies, and stretches in which the drive was not on.

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    Screened

    Raises
    ------
    stepid.errors.InputError
        If no run is left, or the positions cannot be meters.
    """
    campaign, splits = split_campaign(campaign)
    mended = {run.name: mend(run) for run in campaign.experiments}
    faults = tuple(fault for found in mended.values() for fault in found.faults)
    if faults:
        campaign = campaign.model_copy(update={"experiments": tuple(found.run for found in mended.values())})
    for run in campaign.experiments:
        who = f"run {run.name!r}: its positions"
        check_travel(run.position, who, UNIT)
        check_speed(run.position, run.sample_time, who)
    notes = [*splits, *(fault.words for fault in faults)]
    kept = [run for run in campaign.experiments if not _still(run)]
    left_out = {run.name for run in campaign.experiments} - {run.name for run in kept}
    for run in campaign.experiments:
        if run.name in left_out:
            notes.append(f"Run {run.name!r} is left out: {_why_still(run)}")
    kept = _without_copies(kept, notes)
    kept = _from_rest(kept, notes)
    if not kept:
        raise InputError(
            f"campaign {campaign.name!r}: no run can be used. {' '.join(notes)}",
            "Check that the drive was on and the encoder is the right one, and each run's file; record them again.",
        )
    notes += [
        f"Run {run.name!r} starts in motion: its initial position and velocity are fitted, too."
        for run in kept
        if run.starts == "auto" and not run.is_release and starts_in_motion(run)
    ]
    notes += [
        f"Run {run.name!r}: the first {begin} samples are left out: a hand held or moved the cart."
        for run in kept
        if (begin := release_index(run))
    ]
    notes += [note for run in kept if (note := clock_note(run)) is not None]
    if not notes:
        return Screened(campaign, ())
    wrong = {run.name: mended[run.name].wrong[-run.position.size :] for run in kept if mended[run.name].faults}
    return Screened(campaign.model_copy(update={"experiments": tuple(kept)}), tuple(notes), faults, wrong)


def split_campaign(campaign: Campaign) -> tuple[Campaign, tuple[str, ...]]:
    """Take each release of a record that holds several as a run of its own, and say so.

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    tuple of Campaign and tuple of str
        The campaign itself where no record holds several.
    """
    runs: list[Experiment] = []
    notes = []
    for run in campaign.experiments:
        parts = split_releases(run)
        taken = {other.name for other in campaign.experiments} & {part.name for part in parts} - {run.name}
        if taken:  # what it would be called, others are
            parts = (run,)
        runs += parts
        if len(parts) > 1:
            names = ", ".join(repr(part.name) for part in parts)
            notes.append(f"Run {run.name!r} holds {len(parts)} releases. They are taken as runs {names}.")
    if not notes:
        return campaign, ()
    return campaign.model_copy(update={"experiments": tuple(runs)}), tuple(notes)


def _quiet(run: Experiment) -> float:
    """Largest travel that noise and rounding make of a cart at rest, m."""
    return max(3.0 * (run.resolution or 0.0), 8.0 * record_noise(run))


def _still(run: Experiment) -> bool:
    travel = float(np.ptp(run.position))
    if travel <= 3.0 * (run.resolution or 0.0):
        return True
    # noise alone: no swing, nor a new rest, behind it
    return float(np.std(run.position)) < 1.2 * record_noise(run)


def _why_still(run: Experiment) -> str:
    level = float(np.abs(run.input).max())
    if level == 0:
        return "nothing moves in it."
    return f"nothing moves in it although {level:g} V is commanded. Was the amplifier off, or the step too small?"


def _without_copies(runs: list[Experiment], notes: list[str]) -> list[Experiment]:
    """Keep the first of equal records with equal labels; none of equal records with different labels."""
    groups: dict[bytes, list[Experiment]] = {}
    for run in runs:
        groups.setdefault(run.position.tobytes(), []).append(run)
    dropped: set[str] = set()
    for first, *others in groups.values():
        if not others:
            continue
        names = ", ".join(repr(r.name) for r in (first, *others))
        if all(_labels(r) == _labels(first) for r in others):
            notes.append(
                f"Runs {names} hold the same record, sample for sample: copies, no repeats; one of them is used."
            )
            dropped |= {r.name for r in others}
        else:
            notes.append(
                f"Runs {names} hold the same record under different labels: at most one of them is what it says, "
                "and they are left out. Check their files."
            )
            dropped |= {r.name for r in (first, *others)}
    return [r for r in runs if r.name not in dropped]


def _labels(run: Experiment) -> tuple[object, ...]:
    known = (run.added_mass, run.spring, run.damper, run.base, run.input_before, run.sample_time, run.input_between)
    return (*known, run.input.tobytes())


def _answers(run: Experiment, quiet: float) -> list[_Answer]:
    """What follows each change of the input; nothing where it changes all the time, or never."""
    before = np.concatenate([[run.input_before], run.input[:-1]])
    at = np.flatnonzero(run.input != before)
    if run.is_release or at.size > 0.05 * run.input.size:
        return []
    out = []
    still = max(quiet, _STILL * float(np.ptp(run.position)))
    for begin, end in zip(at, [*at[1:], run.input.size], strict=True):
        y = run.position[begin:end]
        moved = np.flatnonzero(np.abs(y - y[0]) > still)
        lag = float(moved[0]) * run.sample_time if moved.size else None
        led = run.position[max(0, begin - _REST) : begin + 1]
        rests = float(np.ptp(led)) <= still
        change = float(run.input[begin] - before[begin])
        out.append(_Answer(int(begin), int(end), change, float(before[begin]), lag, rests))
    return out


def _from_rest(runs: list[Experiment], notes: list[str]) -> list[Experiment]:
    """Begin each driven run at the first change of its input that it answers, from rest."""
    quiet = {run.name: _quiet(run) for run in runs}
    answers = {run.name: _answers(run, quiet[run.name]) for run in runs}
    free = {run.name: _begins_in_motion(run) for run in runs}
    lags = sorted(a.lag for some in answers.values() for a in some if a.lag is not None)
    if not lags:
        return runs
    usual = lags[len(lags) // 4]
    moving = [
        run.name
        for run in runs
        if not free[run.name] and answers[run.name] and _moves_first(run, answers[run.name][0], quiet[run.name])
    ]
    if 2 * len(moving) > len(runs):  # not a mistake but what this plant does: something shakes it, or its zero drifts
        moving = []
    out = []
    for run in runs:
        found = answers[run.name]
        weakest = min((abs(a.change) for a in found if a.lag is not None), default=np.inf)
        dead = 0
        while dead < len(found) and _dead(found[dead], weakest, usual, run.sample_time):
            dead += 1
        jump = _jump(run, quiet[run.name])
        if not dead and run.name not in moving and jump is None:
            out.append(run)
            continue
        if dead:
            what = "in which its input changes but nothing answers (was the amplifier off?)"
        elif jump is not None:
            what = f"up to a jump of {1e3 * jump[1]:.3g} mm from one sample to the next"
            dead = sum(a.at <= jump[0] for a in found)
        else:
            what, dead = "in which the cart already moves", 1
        good = next((a for a in found[dead:] if a.rests and a.lag is not None), None)
        begin = 0 if good is None else max(found[dead - 1].at + 1 if dead else 0, good.at - _LEAD)
        if good is None or run.position.size - begin < _LEAST:
            notes.append(f"Run {run.name!r} is left out: no step from rest follows the stretch {what}.")
            continue
        notes.append(f"Run {run.name!r}: the first {begin} samples, {what}, are left out.")
        out.append(_cut(run, begin, good.before))
    return out


def _dead(found: _Answer, weakest: float, usual: float, sample_time: float) -> bool:
    """Tell whether a change as strong as those that move the cart does not, or far too late."""
    if abs(found.change) < _LIKE * weakest:
        return False
    patience = _LATE * usual + _LEAD * sample_time
    if found.lag is None:
        return (found.end - found.at) * sample_time > patience
    return found.lag > patience


def _moves_first(run: Experiment, first: _Answer, quiet: float) -> bool:
    led = run.position[: first.at + 1]
    return led.size > 4 and float(np.ptp(led)) > max(quiet, 0.1 * float(np.ptp(run.position)))


def _begins_in_motion(run: Experiment) -> bool:
    """Tell whether a run's initial state is fitted, and it moves from its first samples on."""
    if run.starts != "auto":
        return run.starts == "motion"
    return float(np.ptp(run.position[:_FIRST])) > _quiet(run) and starts_in_motion(run)


def _jump(run: Experiment, quiet: float) -> tuple[int, float] | None:
    """Sample and size [m] of a jump near the start that no cart makes: many times any other change of the reading."""
    change = np.abs(np.diff(run.position))
    early = max(4, change.size // 20)
    at = int(np.argmax(change[:early]))
    others = np.delete(change, at)
    if change[at] > 3.0 * float(others.max()) and change[at] > 4.0 * quiet:
        return at, float(change[at])
    return None


def _cut(run: Experiment, begin: int, before: float) -> Experiment:
    fields = {name: getattr(run, name) for name in type(run).model_fields}
    arrays = {name: fields[name][begin:] for name in ("time", "position", "input")}
    return Experiment(**(fields | arrays | {"input_before": before, "starts": "auto"}))
