"""Names of columns that end with their run, as Pasco's programs write them: "Angle, Ch 1+2 (rad) Run #1"."""

from __future__ import annotations

import re
from collections.abc import Sequence

from stepid.io.guess.file_names import read_name

_RUN = re.compile(r"[\s,;:]*\bRun #(\d+)$")


def runs_of(names: Sequence[str]) -> list[str]:
    """The run that each name tells, "Run 1"; none where one does not."""
    found = [match for match in map(_RUN.search, names) if match]
    return [f"Run {match[1]}" for match in found] if len(found) == len(names) else []


def without_run(name: str) -> str:
    """A name without its run."""
    return _RUN.sub("", name)


def sensors_of(names: Sequence[str]) -> tuple[str, ...]:
    """Names without their run, where each run has several, which say the same of masses: its sensors; else none."""
    runs, bare = runs_of(names), list(map(without_run, names))
    if len(set(runs)) == len(runs) or len({*zip(runs, bare, strict=True)}) < len(runs):
        return ()
    return tuple(dict.fromkeys(bare)) if len(set(map(read_name, bare))) == 1 else ()


def is_within(label: str, other: str) -> bool:
    """Tell whether a label's words stand in another: those of run 1 do not in that of run 10."""
    return f" {label.lower()} " in f" {other.lower()} "
