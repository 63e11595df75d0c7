"""What is plainly wrong with a record or the weights, beside what a search found."""

from __future__ import annotations

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor
from stepid.diagnosis.explore import Found, fault_beside, outweighs
from stepid.fitting.eccentricity import Eccentricity, find_eccentricity
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.run_fault import accuse, find_fault
from stepid.fitting.swapped_weights import Swap, find_swap


def swap_of(found: Found, criteria: Criteria) -> Swap | None:
    """Two runs whose masses are noted for each other, where that is likelier than what the search found."""
    context, best = found.context, found.likeliest
    if context.by_weights is not None or (at_floor(context, criteria, best) and best.complexity <= 1):
        return None
    swap = find_swap(context.linear, next((c.optimum for c in found.single), None), context.floor)
    likelier = swap is not None and outweighs(swap.optimum.cost, swap.optimum, found, criteria)
    return swap if likelier else None


def fault_beside_the_plant(found: Found, criteria: Criteria) -> RecordFault | None:
    """What is plainly wrong with one run of more than two, beside the linear plant.

    Where errors of the weights that they may have are enough, nothing is.
    """
    context = found.context
    if context.by_weights is not None:
        return None
    patterned = len(found.candidates) > 1 and context.colored is None
    alone = accuse(context.linear, context.floor, sure=criteria.size, patterned=patterned)
    return alone.fault if alone is not None and outweighs(alone.cost, context.linear, found, criteria) else None


def fault_beside_effects(found: Found, criteria: Criteria) -> RecordFault | None:
    """The same beside the answer, or in its rest."""
    if len(found.context.records.runs) <= 2:
        return None
    beside = fault_beside(found, criteria)
    if beside is not None or not found.best.effects or at_floor(found.context, criteria, found.best):
        return beside
    return find_fault(found.best.optimum, found.context.floor, sure=criteria.size)


def eccentricity_of(found: Found, criteria: Criteria, accused: tuple[RecordFault, ...]) -> Eccentricity | None:
    """A line in position on the readings, where a rest remains and none was subtracted yet."""
    if at_floor(found.context, criteria, found.best):
        return None
    plain = [c for c in found.candidates if not c.effects]  # runs that differ leave the line bare
    looked = (find_eccentricity(c.optimum, found.context.floor) for c in (found.best, *plain, *found.single))
    line = next(filter(None, looked), None)
    return line if line is not None and all(f.kind != line.fault.kind for f in accused) else None
