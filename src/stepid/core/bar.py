"""A bar in notebooks for what takes long. In scripts there is none, and without tqdm or ipywidgets nothing is said."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Show = Callable[[str, int, int], object]
"""Takes a few words, how many steps are done and how many are left."""


def switched_off() -> bool:
    """Tell whether the environment wants no bars: ``STEPID_PROGRESS=0``."""
    return os.environ.get("STEPID_PROGRESS") == "0"


@contextmanager
def notebook_bar() -> Iterator[Show]:
    """Show a bar while something lasts, where there is a notebook to show it; it is gone afterward."""
    if switched_off() or not _in_notebook():
        yield _silent
        return
    try:
        import ipywidgets  # noqa: F401  # without it tqdm warns, and writes to standard error
        from tqdm.auto import tqdm
    except ImportError:
        yield _silent
        return
    with tqdm(total=1.0, leave=False, bar_format="{bar} {elapsed} {desc}") as bar:

        def show(words: str, done: int, left: int) -> None:
            every = done + left  # which grows while one searches: the bar shows the share, and words the counts
            bar.n = done / every if every else 0.0
            bar.set_description_str(f"{done}/{every} {words}" if every else words)

        yield show


def _in_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", _nothing)()
    return "IPKernelApp" in getattr(shell, "config", ())


def _nothing() -> None:
    return None


def _silent(words: str, done: int, left: int) -> None:
    return None
