"""A bar in a notebook, nothing in a script, nothing where it is switched off or cannot be shown."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

import diagnosis_example as example
import stepid
from stepid.core.bar import Show, notebook_bar
from stepid.diagnosis.progress import telling
from stepid.errors import InputError

CODE = """
from stepid.core.bar import notebook_bar
with notebook_bar() as show:
    show("linear fit", 0, 0)
    show("cubic stiffness", 3, 9)
    print(show.__name__)
"""


@pytest.mark.filterwarnings("ignore::DeprecationWarning:jupyter_client.*", "ignore::DeprecationWarning:zmq.*")
@pytest.mark.parametrize(
    ("before", "shown"),
    [
        ("", True),
        ("import os; os.environ['STEPID_PROGRESS'] = '0'", False),
        ("import sys; sys.modules['tqdm.auto'] = None", False),
        ("import sys; sys.modules['ipywidgets'] = None", False),
    ],
    ids=["a bar", "off", "no tqdm", "no ipywidgets"],
)
def test_a_notebook_shows_a_bar(before: str, shown: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("STEPID_PROGRESS", raising=False)
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(f"{before}\n{CODE}")])
    notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3"}
    client = NotebookClient(notebook, timeout=60)
    done = client.execute()
    outputs = done.cells[0].outputs
    assert [o.text.strip() for o in outputs if o.output_type == "stream"] == ["show" if shown else "_silent"]
    states = done.metadata.get("widgets", {}).get("application/vnd.jupyter.widget-state+json", {}).get("state", {})
    values = [one["state"] for one in states.values()]
    if shown:
        assert 0.25 in [one.get("value") for one in values]
        told = " ".join(str(one.get("value")) for one in values).replace("\u2007", " ")  # tqdm's blank
        assert "3/12 cubic stiffness" in told
    else:
        assert not values


def test_a_script_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with notebook_bar() as show:
        show("linear fit", 1, 2)
    with telling(None) as tell:
        tell(stepid.Progress("linear fit", done=1, left=2))
    assert capsys.readouterr() == ("", "")
    assert "tqdm.auto" not in sys.modules


def test_many_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    def ready(campaign: stepid.Campaign, *, progress: Any, **_: Any) -> stepid.Diagnosis:
        assert progress is False  # one bar, not one in another
        return example.named()

    monkeypatch.setattr(sys.modules[stepid.diagnose.__module__], "diagnose", ready)
    told: list[stepid.Progress] = []
    campaign = example.campaign()
    assert len(stepid.diagnose_many([campaign] * 3, progress=told.append)) == 3
    assert [(p.done, p.left) for p in told] == [(0, 3), (1, 2), (2, 1)]
    assert set(told) == {campaign.name}


def test_several_are_named_beside_the_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[tuple[str, int, int]] = []

    @contextmanager
    def bar() -> Iterator[Show]:
        yield lambda words, done, left: said.append((words, done, left))

    monkeypatch.setattr("stepid.diagnosis.progress.notebook_bar", bar)
    monkeypatch.setattr(sys.modules[stepid.diagnose.__module__], "diagnose", lambda *_, **__: example.named())
    stepid.diagnose_many([example.campaign()] * 2)
    assert said == [("cases 4 to 7", 0, 2), ("cases 4 to 7", 1, 1)]  # a campaign has no best answer so far


def test_true_is_refused_with_the_remedy() -> None:
    with pytest.raises(InputError, match=r"progress is True\. Give a function, or False"):
        stepid.diagnose(example.campaign(), progress=True)
