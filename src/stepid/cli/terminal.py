"""What commands share: the console, the examples and the manifest in their help."""

from __future__ import annotations

import os
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Literal, TypeVar

from rich.console import Console

_Command = TypeVar("_Command", bound=Callable[..., None])
_MANIFEST = """

CAMPAIGN.toml lists the runs; their files lie beside it. For tables, such as CSV:

[dim]name = "my rig"
format = "table"         # left out: exports of the ECP program
time = "time_s"          # the columns, by name or by index from 0
position = "position_mm"
position_scale = 0.001   # meters per unit
# also time_scale (s per unit), skiprows = 3, decimal = ","
input = "voltage_V"
spring = "medium"        # runs with the same label share a stiffness
damper = "none"
[\\[experiment]]
name = "run 1"
file = "run1.csv"
added_mass = 0.0         # kg
[\\[experiment]]
name = "run 2"
file = "run2.csv"
added_mass = 0.5[/dim]
"""


def examples(*lines: str) -> str:
    """Lines below the help of a command."""
    return "\n\n".join(["Examples:", *(f"[bold]{line}[/bold]" for line in lines)])


def showing_a_manifest(command: _Command) -> _Command:
    """Show a manifest in the help of a command."""
    command.__doc__ = f"{command.__doc__}{_MANIFEST}"  # below the first paragraph, which lists of commands show
    return command


def command(*words: str) -> str:
    """Write a command so that it can be copied: words with blanks and the like in quotation marks."""
    return subprocess.list2cmdline(words) if os.name == "nt" else shlex.join(words)


def console(*, stderr: bool = False) -> Console:
    """Standard output or error: colored only on a terminal."""
    # soft_wrap: tables keep their lines, also in a pipe; NO_COLOR: no bold either
    colors: Literal["auto"] | None = None if os.environ.get("NO_COLOR") else "auto"
    return Console(stderr=stderr, color_system=colors, highlight=False, soft_wrap=True)


def check_out(out: Path | None, *packages: str) -> None:
    """Refuse a folder that cannot be written, and say what to install to write into it: before a long search."""
    if out is not None:
        from stepid.core.atomic_write import check_writable
        from stepid.report.write import check_installed

        check_writable(out)
        check_installed(*packages)
