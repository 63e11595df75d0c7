"""What a rule of the verdict is, and what it answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.result import Verdict
from stepid.diagnosis.selection.candidate import Candidate


@dataclass(frozen=True)
class Answer:
    """What a rule says: `shown` is the candidate whose effects are named, or the nearest where none is."""

    verdict: Verdict
    shown: Candidate
    alternatives: tuple[Candidate, ...]
    reasons: tuple[str, ...]
    rule: str = ""


Rule = Callable[[EvidenceRecord], Answer | None]
