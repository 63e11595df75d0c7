"""Every figure of a notebook is seen, also where nobody asked for inline pictures."""

from __future__ import annotations

import matplotlib
import matplotlib.pyplot as plt
import nbformat
import pytest
from nbclient import NotebookClient

from stepid.plot.style import styled

CELLS = (
    "import stepid\nc = stepid.datasets.lab_campaign()",
    "stepid.plot.records(c);",
    "stepid.plot.records(c);",
)


def test_what_a_backend_turns_on_stays() -> None:
    before = plt.isinteractive()
    try:
        for interactive in (True, False):
            with styled():
                matplotlib.interactive(interactive)  # as a notebook's backend does when the first figure loads it
            assert plt.isinteractive() is interactive
    finally:
        matplotlib.interactive(before)


@pytest.mark.slow
def test_every_cell_shows_its_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MPLBACKEND", raising=False)
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in CELLS])
    NotebookClient(book, timeout=300).execute()
    pictures = [[o for o in cell.outputs if "image/png" in o.get("data", {})] for cell in book.cells]
    assert [len(p) for p in pictures] == [0, 1, 1]
