"""How much of all weight is on an answer."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stepid.diagnosis.evidence import Weighed
from stepid.diagnosis.selection.candidate import Candidate, includes
from stepid.diagnosis.vetoes import effects_of

if TYPE_CHECKING:
    from stepid.diagnosis.gather import EvidenceRecord


def weight_of(told: EvidenceRecord, found: tuple[Candidate, ...]) -> float:
    """Weight of all candidates that hold the effects of one of some, or effects that contain them.

    Of those that may be named: beside others, which can outweigh them by far, they would be alike.
    """
    able: list[Weighed] = []
    for w in told.weighed:
        if able and _over(w, able[0]) < (1.0 - told.criteria.sure) / len(told.weighed):
            break  # all of them together cannot dispute
        if _counts(told, w.candidate, found):
            able.append(w)
    raw = [(_over(w, able[0]), w.candidate.effects) for w in able]
    held = (one for one, effects in raw if any(includes(effects, c.effects) for c in found))
    return math.fsum(held) / math.fsum(one for one, _ in raw)


def _over(one: Weighed, first: Weighed) -> float:
    """Weight of one candidate over that of another."""
    return math.exp(-0.5 * (one.loss - first.loss))


def _counts(told: EvidenceRecord, other: Candidate, found: tuple[Candidate, ...]) -> bool:
    """Tell whether a candidate counts beside some: one with an open effect only for what it holds besides that."""
    if told.imitators(other):
        return False
    open_ = effects_of(told.open(other))
    return not open_ or any(includes(other.effects, c.effects) and not open_ & set(c.names) for c in found)
