"""Which runs and stretches of a campaign a joint fit can use; what it cannot is left out by name."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.copies import copies
from stepid.core.experiment import Campaign, Experiment
from stepid.core.hand import hand
from stepid.core.held_before import all_held_before
from stepid.core.jumps import jumps, split_at
from stepid.core.mass_offset import WEIGHT, known_in_words, weight_spread
from stepid.core.noise import record_noise
from stepid.core.outliers import Mask
from stepid.core.releases import split_releases
from stepid.core.repeated_readings import at_sensor_rates, sensor_notes
from stepid.core.samples import means_of_blocks
from stepid.core.units import UNIT, check_speed, check_travel
from stepid.core.words import at_samples, counted
from stepid.errors import InputError
from stepid.fitting.first_step import from_rest
from stepid.fitting.flat_readings import flat_readings
from stepid.fitting.reading_faults import mend
from stepid.fitting.record_fault import RecordFault
from stepid.simulation.clock import clock_notes
from stepid.simulation.starts import starts_in_motion

_PARTS = 32  # of a record, whose means show whether it moves behind its noise
_OVER_READ = 0.9  # of the noise, below which a whole record varies only where the noise is read too high
_CHANCE = 5.0  # standard deviations that these may vary by more than noise does
_FEWEST = 8  # samples of a record, as of any `Experiment`
_JUMPS = "samples were lost there, or the reading slipped. What moves on from elsewhere is"


class Screened(NamedTuple):
    """The part of a campaign that can be fitted, and in words what was left out."""

    campaign: Campaign
    notes: tuple[str, ...]
    faults: tuple[RecordFault, ...] = ()
    wrong: Mapping[str, Mask] = MappingProxyType({})  # run name to samples that do not count, where there are any


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
    runs, slow = at_sensor_rates(campaign.experiments)
    if slow:
        campaign = campaign.model_copy(update={"experiments": tuple(runs)})
    flat = flat_readings(campaign.experiments)
    mended = {run.name: flat.get(run.name) or mend(run) for run in campaign.experiments}
    faults = tuple(fault for found in mended.values() for fault in found.faults)
    if faults:
        campaign = campaign.model_copy(update={"experiments": tuple(found.run for found in mended.values())})
    _check_meters(campaign.experiments)
    kept, notes = list(campaign.experiments), [*splits, *sensor_notes(slow), *(fault.words for fault in faults)]
    for stage in (_moving, _without_copies, all_held_before, from_rest):
        kept, said = stage(kept)
        notes += said
    in_motion = _on_starts(kept)
    kept, let_go = _let_go(kept)
    if not kept:
        raise InputError(
            f"campaign {campaign.name!r}: no run can be used. {' '.join([*notes, *let_go])}",
            "Check that the drive was on and the encoder is the right one, and each run's file; record them again.",
        )
    notes += [
        *in_motion,
        *let_go,
        *_on_light_weights(campaign),
        *clock_notes(run for run in kept if run.name not in slow),
    ]
    if not notes:
        return Screened(campaign, ())
    masks = {name: found.wrong for name, found in mended.items() if found.faults}
    masks |= {name: found.stale | mended[name].wrong for name, found in slow.items()}
    wrong = {run.name: masks[run.name][-run.position.size :] for run in kept if run.name in masks}
    return Screened(campaign.model_copy(update={"experiments": tuple(kept)}), tuple(notes), faults, wrong)


def _check_meters(runs: Iterable[Experiment]) -> None:
    """Refuse positions that cannot be meters."""
    for run in runs:
        who = f"run {run.name!r}: its positions"
        check_travel(run.position, who, UNIT)
        check_speed(run.position, run.sample_time, who)


def _moving(runs: list[Experiment]) -> tuple[list[Experiment], list[str]]:
    """Leave out runs in which nothing moves, and say why."""
    still = {run.name: _why_still(run) for run in runs if _still(run)}
    kept = [run for run in runs if run.name not in still]
    return kept, [f"Run {name!r} is left out: {why}" for name, why in still.items()]


def _without_copies(runs: list[Experiment]) -> tuple[list[Experiment], list[str]]:
    """Leave out runs that hold the record of another, and say which."""
    same = copies(runs)
    return [run for run in runs if run.name not in same], list(dict.fromkeys(same.values()))


def _on_starts(runs: Iterable[Experiment]) -> list[str]:
    """Say which driven runs are found to start in motion."""
    return [
        f"Run {run.name!r} starts in motion: its initial position and velocity are fitted, too."
        for run in runs
        if run.starts == "auto" and not run.is_release and starts_in_motion(run)
    ]


def _on_light_weights(campaign: Campaign) -> list[str]:
    """Say where the added masses are not known at all, as of rigs far smaller than those of the default uncertainty."""
    heaviest, of = max(run.added_mass for run in campaign.experiments), campaign.weight_uncertainty
    if not weight_spread(heaviest, of) >= heaviest / 2 > 0:
        return []
    return [
        f"{known_in_words(heaviest, of)} only, by the campaign's weight_uncertainty of {of:.2g} kg for a weight of "
        f"{WEIGHT:g} kg: no mass, stiffness or force is determined. State the weight_uncertainty of these weights."
    ]


def _let_go(runs: list[Experiment]) -> tuple[list[Experiment], list[str]]:
    """Begin each release where no hand can hold the cart anymore; say so of all, and of each where a hand is seen.

    One that is held nearly to its end is left out.
    """
    held = [run.name for run in runs if run.position.size - hand(run).first < _FEWEST]
    notes = [
        f"Run {name!r} is left out: a hand held or moved the cart until it ends, but for a few samples."
        for name in held
    ]
    runs = [run for run in runs if run.name not in held]
    hands = {run.name: hand(run) for run in runs}
    notes += [
        f"Run {name!r}: the first {first} samples are left out: a hand held or moved the cart."
        for name, (first, seen) in hands.items()
        if seen
    ]
    unseen = {name: first for name, (first, seen) in hands.items() if first and not seen}
    if unseen:
        runs = [_free(run, unseen[run.name]) if run.name in unseen else run for run in runs]
        who = f"{'Releases' if len(unseen) > 1 else 'Release'} {', '.join(map(repr, unseen))}"
        what = f"the first {counted(max(unseen.values()), 'sample')}"
        notes.append(
            f"{who}: {what} at most are left out: a hand may still have held the cart. "
            'Say starts="motion" where none did.'
        )
    return runs, notes


def _free(run: Experiment, first: int) -> Experiment:
    return run.slice(first).model_copy(update={"starts": "motion"})


def split_campaign(campaign: Campaign) -> tuple[Campaign, tuple[str, ...]]:
    """Take each release of a record that holds several as a run of its own, and what follows a jump; say so.

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    tuple of Campaign and tuple of str
        The campaign itself where no record holds several, nor jumps.
    """
    runs: list[Experiment] = []
    notes = []
    for run in campaign.experiments:
        parts, what = _parts(run)
        taken = {other.name for other in campaign.experiments} & {part.name for part in parts} - {run.name}
        if not what or taken:  # one, or what a part would be called, others are
            runs.append(run)
            continue
        runs += parts
        names = ", ".join(repr(part.name) for part in parts)
        out = run.time.size - sum(part.time.size for part in parts)
        short = f" {counted(out, 'sample')} in parts too short for a run are left out." if out else ""
        notes.append(f"Run {run.name!r} {what} taken as run{'s' * (len(parts) > 1)} {names}.{short}")
    if not notes:
        return campaign, ()
    return campaign.model_copy(update={"experiments": tuple(runs)}), tuple(notes)


def _parts(run: Experiment) -> tuple[tuple[Experiment, ...], str]:
    """Split a record that holds several releases, or jumps, and say which: nothing of one that does not."""
    parts = split_releases(run)
    if len(parts) > 1:
        return parts, f"holds {len(parts)} releases. They are"
    at = jumps(mend(run).run)  # a reading that sticks jumps as well
    parts = split_at(run, at)
    return parts, f"jumps at {at_samples(at)}: {_JUMPS}" if parts[0] is not run else ""


def _still(run: Experiment) -> bool:
    travel = float(np.ptp(run.position))
    if travel <= 3.0 * (run.resolution or 0.0):
        return True
    # noise alone: no swing, nor a new rest, behind it
    spread, noise = float(np.std(run.position)), record_noise(run)
    return spread < 1.2 * noise and (spread > _OVER_READ * noise or not _sways(run.position))


def _sways(y: Array) -> bool:
    """Tell whether means over parts of a record vary by more than those of noise or of a fast hum.

    Differences, which tell the noise, take a fast hum for more than it is; in means it is less than noise.
    """
    size = max(y.size // _PARTS, 1)
    means = means_of_blocks(y, size)
    times = size * float(np.var(means)) / max(float(np.var(y)), np.finfo(float).tiny)
    return times > 1.0 + _CHANCE * math.sqrt(2.0 / means.size)


def _why_still(run: Experiment) -> str:
    level = float(np.abs(run.input).max())
    if level == 0:
        return "nothing moves in it."
    return f"nothing moves in it although {level:g} V is commanded. Was the amplifier off, or the step too small?"
