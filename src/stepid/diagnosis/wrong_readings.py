"""What may be wrong with the readings where a rest remains: it is taken out, and the diagnosis begins anew."""

from __future__ import annotations

from collections.abc import Iterator

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor
from stepid.diagnosis.explore import Found
from stepid.fitting.eccentricity import Eccentricity, find_eccentricity
from stepid.fitting.lost_counts import Jump, find_jump
from stepid.fitting.record_fault import RecordFault


def wrong_readings(found: Found, criteria: Criteria, accused: tuple[RecordFault, ...]) -> Iterator[Eccentricity | Jump]:
    """Find a jump of the readings, or a line in position on them, where a rest remains and it was not taken out yet.

    Parameters
    ----------
    found : Found
        What a search found.
    criteria : Criteria
    accused : tuple of RecordFault
        What was told of the records so far.

    Yields
    ------
    Eccentricity or Jump
    """
    context, known = found.context, {(f.run, f.kind) for f in accused}
    if at_floor(context, criteria, found.best):
        return
    plain = [c for c in found.candidates if not c.effects]  # runs that differ leave it bare
    looked = [c.optimum for c in (found.best, *plain, *found.single)]
    jumps: Iterator[Eccentricity | Jump | None] = (find_jump(one, context.floor, context.period) for one in looked)
    lines: Iterator[Eccentricity | Jump | None] = (find_eccentricity(one, context.floor) for one in looked)
    for every in (jumps, lines):
        wrong = next((one for one in every if one is not None), None)
        if wrong is not None and (wrong.fault.run, wrong.fault.kind) not in known:
            yield wrong
