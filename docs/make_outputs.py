"""Write what the code blocks of the tutorial print below them. Run with ``python docs/make_outputs.py``."""

from __future__ import annotations

import contextlib
import io
import os
import re
import tempfile
from pathlib import Path

PAGES = (Path(__file__).parent / "tutorial.md",)
BLOCK = re.compile(r"^```(python|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MARK = "<!-- output -->\n"


def fill(text: str) -> str:
    """A page's text with all its Python blocks run, in order, and every marked block of output written anew."""
    names: dict[str, object] = {"__name__": "__main__"}
    said = ""

    def renew(found: re.Match[str]) -> str:
        nonlocal said
        if found[1] == "python":
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile(found[2], "page", "exec"), names)
            said = "\n".join(line.rstrip() for line in out.getvalue().splitlines())
            return found[0]
        if text[: found.start()].endswith(MARK):
            return f"```text\n{said}\n```"
        return found[0]

    return BLOCK.sub(renew, text)


def main() -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    back = Path.cwd()
    with tempfile.TemporaryDirectory() as scratch:
        os.chdir(scratch)
        done = {page: fill(page.read_text(encoding="utf-8")) for page in PAGES}
        os.chdir(back)
    for page, text in done.items():
        page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
