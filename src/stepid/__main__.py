"""Entry of the `stepid` command and of `python -m stepid`."""

from __future__ import annotations

import io
import sys


def main() -> None:
    """Run the command line, or say what to install for it."""
    try:
        from stepid.cli import run
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in {"typer", "rich", "click"}:
            raise
        sys.stderr.write(
            f"stepid: the command line needs the package {error.name!r}. Install it with: pip install 'stepid[cli]'\n"
        )
        raise SystemExit(2) from None
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a console without ω shows ? in its place
    raise SystemExit(run(sys.argv[1:]))


if __name__ == "__main__":
    main()
