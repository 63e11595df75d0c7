"""File names for results."""

from __future__ import annotations

import re
from collections.abc import Iterable


def file_names(runs: Iterable[str]) -> dict[str, str]:
    """Give each run name a file name of its own without spaces or signs.

    Parameters
    ----------
    runs : iterable of str

    Returns
    -------
    dict
        Run name to file name without ending, for example ``"case 4"`` to ``"case-4"``.
    """
    names: dict[str, str] = {}
    for run in runs:
        plain = re.sub(r"[^\w.+]+", "-", run).strip("-.") or "run"
        taken, name, count = set(names.values()), plain, 2
        while name in taken:
            name, count = f"{plain}-{count}", count + 1
        names[run] = name
    return names
