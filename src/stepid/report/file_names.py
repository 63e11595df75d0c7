"""File names for results."""

from __future__ import annotations

import re
from collections.abc import Iterable

_LONGEST = 80  # characters of a name
_LARGEST = 180  # bytes of a name; systems of files take 255 with what is put around it


def file_names(runs: Iterable[str]) -> dict[str, str]:
    """Give each run name a file name of its own without spaces or signs.

    Parameters
    ----------
    runs : iterable of str

    Returns
    -------
    dict
        Run name to file name without ending, for example ``"case 4"`` to ``"case-4"``. No two differ in large and small
        letters alone, which some systems take for one file.
    """
    names: dict[str, str] = {}
    taken: set[str] = set()
    for run in runs:
        cut = re.sub(r"[^\w.+]+", "-", run).strip("-.")[:_LONGEST].encode()[:_LARGEST]
        plain = cut.decode(errors="ignore").rstrip("-.") or "run"
        name, count = plain, 2
        while name.casefold() in taken:
            name, count = f"{plain}-{count}", count + 1
        names[run] = name
        taken.add(name.casefold())
    return names
