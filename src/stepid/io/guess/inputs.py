"""Which of several columns that may be the input drives the plant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stepid.io.guess.motion import copies
from stepid.io.guess.words import tokens

if TYPE_CHECKING:
    from stepid.io.guess.columns import Column

_TRIGGERS = frozenset({"trigger", "trig", "ttl", "sync", "gate"})


def without_triggers(inputs: list[Column]) -> list[Column]:
    """Of several inputs those that are not called a trigger: it starts what the drive then does."""
    driving = [c for c in inputs if not _TRIGGERS.intersection(tokens(c.name))]
    return driving or inputs


def others(inputs: Sequence[Column]) -> list[Column]:
    """Inputs beside the first that are not the same to scale."""
    return [c for c in inputs[1:] if not copies([inputs[0].values, c.values])]
